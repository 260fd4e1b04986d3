/* SPDX-License-Identifier: Apache-2.0 */
#include "render/fill.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "render/direct.h"
#include "render/record.h"
#include "render/surfaces.h"

/* Places over all surfaces: no more than so many, and enough once less than UNCOVERED of a large round want records. */
enum { FIRST_ROUND = 64, LEAST_LAST_ROUND = 1024, MOST_PLACES = 1 << 24 };
#define UNCOVERED .001f

/* What stands for a pixel's width where there is no camera, in radii of the scene. */
#define SURFACE_PIXEL (1 / 256.0f)

/* Each round looks at this share more pixels than all before. */
#define ROUND_GROWTH .2f

static bool insert(struct record_cache *cache, const struct draft *draft)
{
    uint32_t index = cache->zones.count;
    if (index == cache->record_capacity) {
        uint32_t capacity = index ? 2 * index : 1024;
        struct record *grown = realloc(cache->records, capacity * sizeof *grown);
        if (!grown) return false;
        cache->records = grown;
        cache->record_capacity = capacity;
    }
    if (cache->eas_count + draft->eas_count > cache->eas_capacity) {
        uint32_t capacity = 2 * (cache->eas_count + draft->eas_count);
        struct eas *grown = realloc(cache->eas, capacity * sizeof *grown);
        if (!grown) return false;
        cache->eas = grown;
        cache->eas_capacity = capacity;
    }
    cache->records[index] = (struct record){draft->irradiance, cache->eas_count, draft->eas_count};
    for (uint32_t i = 0; i < draft->eas_count; i++) cache->eas[cache->eas_count++] = draft->eas[i];
    return cache_insert(&cache->zones, draft->zone, draft->least);
}

/* Where records may be wanted, in order: pixels, or points on all surfaces. */
struct places {
    uint32_t *pixels; /* or NULL */
    uint32_t count;
    struct surfaces surfaces;
};

/* The point at a place, seen by the camera or from anywhere, and whether a record is wanted there. */
static void look(const struct model *model, const struct fill *fill, const struct places *places, uint32_t place,
                 struct draft *draft)
{
    *draft = (struct draft){.lamps = fill->options.lamps, .anywhere = !places->pixels};
    if (places->pixels) {
        const struct scene_camera *camera = &model->scene->camera;
        uint32_t pixel = places->pixels[place];
        int x = (int)pixel % camera->width, y = (int)pixel / camera->width;
        struct ray ray = camera_ray(camera, (float)x + .5f, (float)y + .5f);
        struct hit hit;
        if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) return;
        shade_point(model, ray, &hit, &draft->point);
    } else if (!surfaces_point(&places->surfaces, place, &draft->point)) {
        return;
    }
    draft->glossy = fill->options.eas && draft->point.brdf.lobe_count > 0 && direct_resolves(&draft->point.brdf);
    if (!draft->glossy && is_black(draft->point.brdf.kd)) return;
    const struct record_cache *cache = draft->glossy ? &fill->glossy : &fill->diffuse;
    draft->wanted = !cache_covers(&cache->zones, draft->point.p, draft->point.n) &&
                    (places->pixels || surfaces_open(&places->surfaces, &draft->point, fill->options.seed, place));
}

/* Pixels from coarse to fine: x and y from the interleaved bits of a counter, the lowest bits first. */
static uint32_t *coarse_to_fine(int width, int height)
{
    uint32_t *order = malloc((size_t)width * (size_t)height * sizeof *order), count = 0;
    int bits = 0;
    while (1 << bits < width || 1 << bits < height) bits++;
    for (uint64_t i = 0; order && i < 1ull << (2 * bits); i++) {
        int x = 0, y = 0;
        for (int b = 0; b < bits; b++) {
            x |= (int)(i >> (2 * b) & 1) << (bits - 1 - b);
            y |= (int)(i >> (2 * b + 1) & 1) << (bits - 1 - b);
        }
        if (x < width && y < height) order[count++] = (uint32_t)(y * width + x);
    }
    return order;
}

static bool find_places(const struct model *model, bool surfaces, struct places *places)
{
    const struct scene_camera *camera = &model->scene->camera;
    *places = (struct places){.count = MOST_PLACES};
    if (surfaces) return surfaces_build(model, &places->surfaces);
    places->count = (uint32_t)(camera->width * camera->height);
    places->pixels = coarse_to_fine(camera->width, camera->height);
    return places->pixels != NULL;
}

/* Makes the records that are wanted among `drafts`, and inserts them in their order. */
static bool make_records(const struct model *model, struct draft *drafts, uint32_t wanted,
                         struct record_scratch *scratch, struct fill *fill)
{
    bool ok = true;
#pragma omp parallel for schedule(dynamic, 1)
    for (uint32_t i = 0; i < wanted; i++) {
        float pixel = drafts[i].anywhere ? model->radius * SURFACE_PIXEL
                                         : camera_pixel_width(&model->scene->camera, drafts[i].point.p);
        record_make(model, &fill->bounced, fill->tables, pixel, fill->options.seed, fill_records(fill) + i,
                    &scratch[omp_get_thread_num()], &drafts[i]);
    }
    for (uint32_t i = 0; i < wanted; i++) {
        ok = ok && !drafts[i].failed && insert(drafts[i].glossy ? &fill->glossy : &fill->diffuse, &drafts[i]);
        free(drafts[i].eas);
    }
    return ok;
}

/* In rounds, each of which looks at its places and makes records where they are wanted. */
static bool fill_places(const struct model *model, struct progress *progress, struct fill *fill)
{
    struct places places;
    int threads = omp_get_max_threads();
    struct record_scratch *scratch = calloc((size_t)threads, sizeof *scratch);
    bool ok = find_places(model, fill->options.surfaces, &places) && scratch, covered = false;
    for (uint32_t done = 0, count; ok && done < places.count && !covered; done += count) {
        count = FIRST_ROUND + (uint32_t)(ROUND_GROWTH * (float)done);
        count = count < places.count - done ? count : places.count - done;
        struct draft *drafts = malloc(count * sizeof *drafts);
        uint32_t wanted = 0;
        if (!drafts) ok = false;
#pragma omp parallel for schedule(dynamic, 64)
        for (uint32_t i = 0; i < (ok ? count : 0); i++) look(model, fill, &places, done + i, &drafts[i]);
        for (uint32_t i = 0; i < (ok ? count : 0); i++)
            if (drafts[i].wanted) drafts[wanted++] = drafts[i];
        ok = ok && make_records(model, drafts, wanted, scratch, fill);
        free(drafts);
        covered = !places.pixels && count >= LEAST_LAST_ROUND && (float)wanted < UNCOVERED * (float)count;
        progress_show(progress, places.pixels ? (double)(done + count) / places.count : 1 - (double)wanted / count);
    }
    ok = ok && cache_reindex(&fill->diffuse.zones) && cache_reindex(&fill->glossy.zones);
    for (int i = 0; scratch && i < threads; i++) record_scratch_free(&scratch[i]);
    free(scratch);
    free(places.pixels);
    surfaces_free(&places.surfaces);
    return ok;
}

bool fill_extend(const struct model *model, struct progress *progress, struct fill *fill,
                 char error[static SCENE_ERROR])
{
    progress_begin(progress, "records", trace_rays(model->trace));
    if (!fill_places(model, progress, fill)) {
        snprintf(error, SCENE_ERROR, "radiance cache: out of memory");
        return false;
    }
    progress_end(progress, trace_rays(model->trace));
    return true;
}

bool fill_build(const struct model *model, const struct fill_options *options, struct progress *progress,
                struct fill *fill, char error[static SCENE_ERROR])
{
    *fill = (struct fill){
        .options = *options, .diffuse.zones = cache_empty(RECORD_STRETCH), .glossy.zones = cache_empty(RECORD_STRETCH)};
    progress_begin(progress, "diffuse cache", trace_rays(model->trace));
    if (!diffuse_cache_build(model, options->seed, progress, &fill->bounced, error)) return false;
    progress_end(progress, trace_rays(model->trace));
    fill->tables = mean_brdf_build();
    if (fill->tables && fill_extend(model, progress, fill, error)) return true;
    fill_free(fill);
    snprintf(error, SCENE_ERROR, "radiance cache: out of memory");
    return false;
}

static void record_cache_free(struct record_cache *cache)
{
    cache_free(&cache->zones);
    free(cache->records);
    free(cache->eas);
}

void fill_free(struct fill *fill)
{
    diffuse_cache_free(&fill->bounced);
    record_cache_free(&fill->diffuse);
    record_cache_free(&fill->glossy);
    mean_brdf_free(fill->tables);
    *fill = (struct fill){0};
}

uint64_t fill_records(const struct fill *fill)
{
    return (uint64_t)fill->diffuse.zones.count + fill->glossy.zones.count;
}

static size_t record_bytes(const struct record_cache *cache)
{
    return cache_bytes(&cache->zones) + cache->zones.count * sizeof *cache->records +
           cache->eas_count * sizeof *cache->eas;
}

size_t fill_bytes(const struct fill *fill)
{
    return diffuse_cache_bytes(&fill->bounced) + record_bytes(&fill->diffuse) + record_bytes(&fill->glossy);
}
