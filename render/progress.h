/* SPDX-License-Identifier: Apache-2.0 */
/* The line that shows how far a long stage is and the time left; stage seconds for --stats. */
#ifndef RENDER_PROGRESS_H
#define RENDER_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

#define PROGRESS_STAGES 16 /* later ones are shown, not kept */

struct progress_stage {
    const char *name;
    double wall_s, cpu_s;
    uint64_t rays;
};

/* One run's stages. Zero-initialise; set `quiet` to print nothing. Writes to stderr: on a terminal one line that is
 * written over and over, elsewhere one line at the end of each stage. One thread at a time. */
struct progress {
    bool quiet;
    int stage_count;
    struct progress_stage stages[PROGRESS_STAGES];
    const char *name; /* of the stage that runs */
    double wall_start, cpu_start, last_print;
    uint64_t rays_start;
};

/* Begins and ends a stage; `name` is borrowed for good; `rays` is the count so far, the difference is the stage's. */
void progress_begin(struct progress *progress, const char *name, uint64_t rays);
void progress_end(struct progress *progress, uint64_t rays);

/* Shows the share done (0 … 1) at most ten times a second. */
void progress_show(struct progress *progress, double done);

/* Seconds on a clock that only goes forward, and seconds of user CPU time of all threads of this process so far. */
double progress_wall(void);
double progress_cpu(void);

#endif
