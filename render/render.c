/* SPDX-License-Identifier: Apache-2.0 */
#include "render/render.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "render/accuracy.h"
#include "render/adaptive.h"
#include "render/path.h"
#include "render/primary.h"

enum { SEED_PATH = 301, SEED_COUNT = 302 };

static void path_pixel(const struct model *model, int spp, uint64_t seed, int x, int y, struct pixel *pixel)
{
    uint64_t index = (uint64_t)(y * model->scene->camera.width + x);
    for (int i = 0; i < spp; i++) {
        struct rng rng = rng_seed(seed ^ (uint64_t)SEED_PATH << 32, index, (uint64_t)i);
        struct picture_sequence spread = sequence_picture(seed, x, y, i, spp);
        float2 place = sequence_next(&spread);
        float2 lens = {0, 0};
        if (camera_has_lens(&model->scene->camera)) lens = sequence_next(&spread);
        struct point point;
        if (!primary(model, (float)x + place.x, (float)y + place.y, lens, &rng, pixel, &point)) continue;
        struct radiance radiance = path_radiance(model, &point, &spread, &rng);
        pixel->direct = add(pixel->direct, radiance.direct);
        pixel->indirect = add(pixel->indirect, radiance.indirect);
    }
}

/* Powers of two, which a sequence spreads best; as many as wanted in the mean, but one at least. */
static int samples_at(const struct render_pass *pass, int i)
{
    if (!pass->weights) return pass->spp;
    float wanted = (float)pass->spp * pass->weights[i];
    int few = 1;
    while (2 * few <= wanted) few *= 2;
    struct rng rng = rng_seed(pass->seed ^ (uint64_t)SEED_COUNT << 32, (uint64_t)i, 0);
    return (float)few * (1 + rng_float(&rng)) < wanted ? 2 * few : few;
}

void render_samples(const struct model *model, const struct cached *cached, const struct render_pass *pass,
                    struct progress *progress, struct film *film)
{
    const int stride = pass->stride;
    int finished = 0;
#pragma omp parallel for schedule(dynamic, 1)
    for (int y = 0; y < film->height; y++) {
        struct shadow_memory memory; /* of the row: the same for any number of threads */
        direct_forget(&memory);
        for (int x = (int)(rng_mix((uint64_t)y) % (uint64_t)stride); x < film->width; x += stride) {
            int i = y * film->width + x;
            struct pixel *pixel = &film->pixels[i];
            if (cached) cached_pixel(cached, x, y, samples_at(pass, i), pass->seed, &memory, pixel);
            else path_pixel(model, pass->spp, pass->seed, x, y, pixel);
        }
        int so_far;
#pragma omp atomic capture
        so_far = ++finished;
        if (omp_get_thread_num() == 0) progress_show(progress, (double)so_far / film->height);
    }
}

bool render_halves(const struct model *model, const struct cached *cached, int spp, uint64_t seed, int stream,
                   int stride, struct progress *progress, struct film halves[static 2])
{
    const struct scene_camera *camera = &model->scene->camera;
    halves[1] = (struct film){0};
    if (!film_alloc(&halves[0], camera->width, camera->height, cached) ||
        !film_alloc(&halves[1], camera->width, camera->height, cached))
        return false;
    for (int half = 0; half < 2; half++) {
        struct render_pass pass = {spp, NULL, rng_mix(seed ^ (uint64_t)(stream + half) << 32), stride};
        render_samples(model, cached, &pass, progress, &halves[half]);
    }
    return true;
}

/* As many samples as are asked for. False: no memory. */
static bool plain(const struct model *model, const struct cached *cached, const struct render_options *options,
                  struct progress *progress, struct film *film)
{
    struct render_pass pass = {options->spp, NULL, options->seed, 1};
    float *weights = NULL;
    double gain;
    bool ok = !cached || options->spp < ADAPTIVE_LEAST ||
              adaptive_weights(model, cached, options->seed, progress, &weights, &gain);
    pass.weights = weights;
    if (ok) render_samples(model, cached, &pass, progress, film);
    free(weights);
    return ok;
}

static void report(const struct model *model, const struct fill *fill, uint64_t seed, struct progress *progress,
                   struct render_stats *stats)
{
    stats->records = fill_records(fill);
    stats->glossy_records = fill->glossy.zones.count;
    stats->eas_per_record = stats->glossy_records ? (double)fill->glossy.eas_count / (double)stats->glossy_records : 0;
    stats->bytes_per_record = fill_bytes_per_record(fill);
    stats->cache_bytes = fill_bytes(fill);
    stats->diffuse_records = fill->bounced.zones.count;
    progress_begin(progress, "diffuse cache's error", trace_rays(model->trace));
    stats->diffuse_cv = diffuse_cache_error(model, &fill->bounced, seed);
    progress_end(progress, trace_rays(model->trace));
}

struct fill_options render_fill(const struct render_options *options)
{
    static const enum fill_kind kinds[] = {[RENDER_GATHER] = FILL_NONE,  [RENDER_HYBRID] = FILL_DIFFUSE,
                                           [RENDER_EAS] = FILL_EAS,      [RENDER_HSH] = FILL_HSH,
                                           [RENDER_AUTO] = FILL_DIFFUSE, [RENDER_PATH] = FILL_NONE};
    return (struct fill_options){.kind = kinds[options->method],
                                 .lamps = options->lamps_in_records,
                                 .surfaces = options->over_surfaces,
                                 .seed = options->seed,
                                 .coarseness = options->method == RENDER_GATHER ? FILL_COARSEST : 0};
}

bool render(const struct model *model, const struct render_options *options, const struct fill *fill,
            struct progress *progress, struct film *film, struct render_stats *stats, char error[static SCENE_ERROR])
{
    struct cached cached = {0};
    *stats = (struct render_stats){0};
    progress_begin(progress, "pixels", trace_rays(model->trace));
    if (!film_alloc(film, model->scene->camera.width, model->scene->camera.height, fill) ||
        (fill && !cached_prepare(model, fill, &cached))) {
        snprintf(error, SCENE_ERROR, "picture: out of memory");
        film_free(film);
        return false;
    }
    stats->spp = options->spp;
    bool ok = options->error > 0 ? accuracy_render(model, fill ? &cached : NULL, options, progress, film,
                                                   &stats->error, &stats->spp)
                                 : plain(model, fill ? &cached : NULL, options, progress, film);
    progress_end(progress, trace_rays(model->trace));
    if (!ok) {
        snprintf(error, SCENE_ERROR, "picture: out of memory");
        film_free(film);
        cached_free(&cached);
        return false;
    }
    if (fill) {
        report(model, fill, options->seed, progress, stats);
        cached_free(&cached);
    }
    return true;
}
