/* SPDX-License-Identifier: Apache-2.0 */
#include "render/accuracy.h"

#include <stdio.h>
#include <stdlib.h>

#include "render/path.h"
#include "render/primary.h"

/* Part of the error that the caches may have. */
#define CACHE_SHARE .75
/* Samples a pixel of path tracing that cost as much as the coarsest caches and a picture by them. */
enum { CHEAP_SAMPLES = 16 };
/* Paths that say how noisy path tracing is. */
enum { PILOT_PATHS = 4096, SEED_PILOT = 701, SEED_ROUND };
/* Samples of a half in the first round, and how many times as many there may be after the next. */
enum { FIRST_ROUND = 2, MOST_GROWTH = 8 };

bool accuracy_choose(const struct model *model, const struct render_options *options, enum render_method *method)
{
    const struct scene_camera *camera = &model->scene->camera;
    *method = RENDER_EAS;
    if (!(options->error > 0) || options->lamps_in_records || options->over_surfaces) return true;
    rgb(*pairs)[2] = calloc(PILOT_PATHS, sizeof *pairs);
    if (!pairs) return false;
#pragma omp parallel for schedule(dynamic, 64)
    for (int i = 0; i < 2 * PILOT_PATHS; i++) {
        struct rng rng = rng_seed(options->seed, SEED_PILOT, (uint64_t)i);
        /* Pixels by the R2 sequence (Roberts 2018). */
        float x = (float)fmod(.5 + .7548776662466927 * (i / 2 + 1), 1),
              y = (float)fmod(.5 + .5698402909980532 * (i / 2 + 1), 1);
        struct pixel pixel = {.samples = 0};
        struct point point;
        if (!primary(model, x * (float)camera->width, y * (float)camera->height, (float2){.5f, .5f}, &rng, &pixel,
                     &point) ||
            !is_black(pixel.emission))
            continue;
        struct radiance radiance = path_radiance(model, &point, NULL, &rng);
        pairs[i / 2][i % 2] = add(radiance.direct, radiance.indirect);
    }
    double squares = 0, sum = 0; /* of black ones both are 0: they only make the share of the rest smaller */
    for (int i = 0; i < PILOT_PATHS; i++) {
        rgb d = sub(pairs[i][0], pairs[i][1]), s = add(pairs[i][0], pairs[i][1]);
        squares += .5 * ((double)d.x * d.x + (double)d.y * d.y + (double)d.z * d.z);
        sum += .5 * ((double)s.x + s.y + s.z);
    }
    free(pairs);
    double cv2 = sum > 0 ? squares * 3 * PILOT_PATHS / (sum * sum) : 0;
    if (cv2 <= CHEAP_SAMPLES * options->error * options->error) *method = RENDER_PATH;
    return true;
}

bool accuracy_fill(const struct model *model, const struct render_options *options, struct progress *progress,
                   struct fill *fill, char error[static SCENE_ERROR])
{
    struct fill_options wanted = render_fill(options);
    for (wanted.coarseness = FILL_COARSEST;; wanted.coarseness--) {
        struct cached cached;
        double own = 0;
        if (!fill_build(model, &wanted, progress, fill, error)) return false;
        if (wanted.coarseness == 0) return true;
        progress_begin(progress, "caches' error", trace_rays(model->trace));
        bool ok = cached_prepare(model, fill, 1, options->seed, &cached) && cached_error(&cached, &own);
        cached_free(&cached);
        progress_end(progress, trace_rays(model->trace));
        if (ok && own <= CACHE_SHARE * options->error) return true;
        fill_free(fill);
        if (!ok) {
            snprintf(error, SCENE_ERROR, "radiance cache: out of memory");
            return false;
        }
    }
}

bool accuracy_render(const struct model *model, struct cached *cached, const struct render_options *options,
                     struct progress *progress, struct film *film, double *estimate, int *spp)
{
    struct film other; /* the second half */
    double own = 0;
    if (!film_alloc(&other, film->width, film->height, film->cache)) return false;
    bool ok = !cached || cached_error(cached, &own);
    double left = sqrt(fmax(options->error * options->error - own * own, .1 * options->error * options->error));
    int done = 0, most = options->spp > 2 ? options->spp / 2 : 1;
    for (int round = 0, next = FIRST_ROUND; ok && done < most; round++) {
        int count = next < most ? next - done : most - done;
        for (int half = 0; half < 2; half++) {
            uint64_t seed = rng_mix(options->seed ^ (uint64_t)SEED_ROUND << 32 ^ (uint64_t)(2 * round + half));
            if (cached) cached->spp = count, cached->seed = seed;
            render_samples(model, cached, count, seed, progress, half ? &other : film);
        }
        done += count;
        double noise = film_noise(film, &other), factor = noise * noise / (left * left);
        *estimate = sqrt(noise * noise + own * own);
        if (noise <= left) break;
        factor = fmin(1.05 * factor, MOST_GROWTH);
        next = (int)fmin(ceil(done * factor), 1 << 24);
        if (next <= done) next = done + 1;
    }
    film_add(film, &other);
    film_free(&other);
    *spp = 2 * done;
    return ok;
}
