/* SPDX-License-Identifier: Apache-2.0 */
#include "render/progress.h"

#include <stdio.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#define INTERVAL 0.1     /* s between two prints */
#define CLEAR "\r\033[K" /* to the line's start and erase it */

double progress_wall(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

double progress_cpu(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_utime.tv_sec + (double)usage.ru_utime.tv_usec * 1e-6;
}

void progress_begin(struct progress *progress, const char *name, uint64_t rays)
{
    progress->name = name;
    progress->wall_start = progress->last_print = progress_wall();
    progress->cpu_start = progress_cpu();
    progress->rays_start = rays;
}

void progress_show(struct progress *progress, double done)
{
    double now = progress_wall();
    if (progress->quiet || now - progress->last_print < INTERVAL || !isatty(STDERR_FILENO)) return;
    progress->last_print = now;
    fprintf(stderr, CLEAR "%s %3.0f %%", progress->name, 100 * done);
    if (done > 0.01) {
        long left = (long)((now - progress->wall_start) * (1 - done) / done + 0.5);
        fprintf(stderr, ", %ld:%02ld:%02ld left", left / 3600, left / 60 % 60, left % 60);
    }
    fflush(stderr);
}

void progress_end(struct progress *progress, uint64_t rays)
{
    struct progress_stage stage = {progress->name, progress_wall() - progress->wall_start,
                                   progress_cpu() - progress->cpu_start, rays - progress->rays_start};
    if (progress->stage_count < PROGRESS_STAGES) progress->stages[progress->stage_count++] = stage;
    if (progress->quiet) return;
    fprintf(stderr, "%s%s: %.2f s, CPU %.2f s", isatty(STDERR_FILENO) ? CLEAR : "", stage.name, stage.wall_s,
            stage.cpu_s);
    if (stage.rays > 0) fprintf(stderr, ", %.2f million rays", (double)stage.rays * 1e-6);
    fputc('\n', stderr);
}
