/* SPDX-License-Identifier: Apache-2.0 */
#include "render/accuracy.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "render/adaptive.h"

/* Part of the error that the caches may have. */
#define CACHE_SHARE .75
/* Samples a pixel, by path tracing and with no records, that cost as much as the coarsest records and a picture by
 * them. */
enum { CHEAP_PATHS = 16, CHEAP_SAMPLES = 4 };
/* Noise is measured at no fewer than so many pixels of a large picture; samples a pixel of the two pilots. */
enum { NOISE_PIXELS = 1 << 13, PILOT_SAMPLES = 2 };
enum { SEED_PILOT = 701, SEED_ROUND = SEED_PILOT + 2 };
/* The part of the samples by the pilot's noise that are taken before it is measured anew. */
#define FIRST .5
/* How many times as many samples there may be after the next round; how many more than predicted, since another round
 * costs more than they do. */
enum { MOST_GROWTH = 8 };
#define MARGIN 1.15

/* Adds samples to a picture, or to some of its pixels. */
static void add_samples(const struct model *model, const struct cached *cached, int spp, const float *weights,
                        uint64_t seed, int stream, int stride, struct progress *progress, struct film *film)
{
    struct render_pass pass = {spp, weights, rng_mix(seed ^ (uint64_t)stream << 32), stride};
    render_samples(model, cached, &pass, progress, film);
}

/* Noise is measured at one pixel of so many in each row. */
static int noise_stride(const struct model *model)
{
    const struct scene_camera *camera = &model->scene->camera;
    int stride = camera->width * camera->height / NOISE_PIXELS;
    return stride < 1 ? 1 : stride < camera->width ? stride : camera->width;
}

/* CV(RMSE) of one sample a pixel, by two pictures at some of the pixels. False: no memory. */
static bool pilot_noise(const struct model *model, const struct cached *cached, uint64_t seed,
                        struct progress *progress, double *noise)
{
    struct film halves[2];
    bool ok = render_halves(model, cached, PILOT_SAMPLES, seed, SEED_PILOT, noise_stride(model), progress,
                            halves);
    *noise = ok ? film_noise(&halves[0], &halves[1]) * sqrt(PILOT_SAMPLES) : 0;
    for (int half = 0; half < 2; half++) film_free(&halves[half]);
    return ok;
}

static bool few_samples(const struct render_options *options, double few)
{
    return options->noise * options->noise <= few * options->error * options->error;
}

bool accuracy_choose(const struct model *model, struct render_options *options, struct progress *progress)
{
    if (options->method != RENDER_AUTO) return true;
    if (!(options->error > 0) || options->lamps_in_records || options->over_surfaces) {
        options->method = RENDER_EAS;
        return true;
    }
    if (!pilot_noise(model, NULL, options->seed, progress, &options->noise)) return false;
    if (few_samples(options, CHEAP_PATHS)) options->method = RENDER_PATH;
    else options->noise = 0;
    return true;
}

/* What there is still to do to caches. */
enum wanting { NOTHING, FINER, EAS_TOO };

/* The diffuse cache alone is good enough as soon as few samples are. While RENDER_AUTO makes hybrid's, finer ones are
 * made until they are good, and then EAS where the samples would cost more rays than the records have, `spent`: about
 * as many as EAS cost. False: no memory. */
static bool judge(const struct model *model, const struct fill *fill, struct render_options *options, uint64_t spent,
                  struct progress *progress, enum wanting *wanting)
{
    struct cached cached;
    double own = 0;
    bool bare = fill->options.kind == FILL_NONE, pilot = bare || options->method == RENDER_AUTO;
    uint64_t before = trace_rays(model->trace);
    progress_begin(progress, "caches' error", before);
    bool ok = cached_prepare(model, fill, &cached) &&
              (!pilot || pilot_noise(model, &cached, options->seed, progress, &options->noise));
    double sample = (double)(trace_rays(model->trace) - before) * noise_stride(model) / (2 * PILOT_SAMPLES);
    ok = ok && (bare || cached_error(&cached, options->seed, &own));
    cached_free(&cached);
    progress_end(progress, trace_rays(model->trace));
    double few = bare ? CHEAP_SAMPLES : pilot ? fmax((double)spent / sample, CHEAP_SAMPLES) : INFINITY;
    bool fine = fill->options.coarseness == 0 || own <= CACHE_SHARE * options->error;
    *wanting = fine && few_samples(options, few) ? NOTHING : fine && !bare ? EAS_TOO : FINER;
    if (*wanting != NOTHING) options->noise = 0;
    return ok;
}

/* False: as fill_build. */
static bool improve(const struct model *model, struct render_options *options, enum wanting wanting,
                    struct progress *progress, struct fill *fill, char error[static SCENE_ERROR])
{
    bool anew = wanting == FINER && fill->options.kind != FILL_NONE;
    if (wanting == EAS_TOO) options->method = RENDER_EAS;
    struct fill_options wanted = render_fill(options);
    wanted.coarseness = fill->options.coarseness - anew;
    if (anew) {
        fill_free(fill);
        return fill_build(model, &wanted, progress, fill, error);
    }
    fill->options = wanted; /* what is there stays */
    if (fill_extend(model, progress, fill, error)) return true;
    fill_free(fill);
    return false;
}

bool accuracy_fill(const struct model *model, struct render_options *options, struct progress *progress,
                   struct fill *fill, char error[static SCENE_ERROR])
{
    struct fill_options wanted = render_fill(options);
    enum wanting wanting = options->method == RENDER_GATHER ? NOTHING : FINER;
    wanted.coarseness = FILL_COARSEST;
    if (options->method == RENDER_AUTO) wanted.kind = FILL_NONE;
    uint64_t before = trace_rays(model->trace);
    if (!fill_build(model, &wanted, progress, fill, error)) return false;
    while (wanting != NOTHING && (fill->options.coarseness > 0 || options->method == RENDER_AUTO)) {
        if (!judge(model, fill, options, trace_rays(model->trace) - before, progress, &wanting)) {
            fill_free(fill);
            snprintf(error, SCENE_ERROR, "radiance cache: out of memory");
            return false;
        }
        before = trace_rays(model->trace);
        if (wanting != NOTHING && !improve(model, options, wanting, progress, fill, error)) return false;
    }
    if (options->method == RENDER_AUTO)
        options->method = fill->options.kind == FILL_NONE ? RENDER_GATHER : RENDER_HYBRID;
    return true;
}

bool accuracy_render(const struct model *model, const struct cached *cached, const struct render_options *options,
                     struct progress *progress, struct film *film, double *estimate, int *spp)
{
    struct film other = {0}; /* as many samples of some of the pixels */
    float *weights = NULL;
    double own = 0, noise = options->noise, gain = 1;
    bool ok = film_alloc(&other, film->width, film->height, film->cache) &&
              (!cached || cached_error(cached, options->seed, &own)) &&
              (noise > 0 || pilot_noise(model, cached, options->seed, progress, &noise));
    double left = sqrt(fmax(options->error * options->error - own * own, .1 * options->error * options->error));
    double wanted = MARGIN * noise * noise / (left * left); /* samples, everywhere alike */
    int done = 0;
    if (ok && cached && wanted >= ADAPTIVE_LEAST)
        ok = adaptive_weights(model, cached, options->seed, progress, &weights, &gain);
    /* Few samples spread less well than many: the pilot tells of too much noise. */
    if (weights) wanted *= FIRST / gain;
    for (int round = 0; ok && done < options->spp; round++) {
        int next = (int)ceil(fmin(wanted, MOST_GROWTH * (done ? done : 2 * PILOT_SAMPLES)));
        int stream = SEED_ROUND + 2 * round;
        if (next <= done) next = done + 1;
        if (next > options->spp) next = options->spp;
        add_samples(model, cached, next - done, weights, options->seed, stream, 1, progress, film);
        add_samples(model, cached, next - done, weights, options->seed, stream + 1, noise_stride(model),
                    progress, &other);
        done = next;
        noise = film_noise(film, &other);
        if (noise <= left) break;
        wanted = MARGIN * done * noise * noise / (left * left);
    }
    *spp = done;
    *estimate = sqrt(noise * noise + own * own);
    film_free(&other);
    free(weights);
    return ok;
}
