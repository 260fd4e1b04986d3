/* SPDX-License-Identifier: Apache-2.0 */
#include "render/fill.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "render/direct.h"
#include "render/record.h"

enum { FIRST_ROUND = 64 };

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

/* What the camera sees at a pixel's centre, and whether a record is wanted there. */
static void look(const struct model *model, const struct fill *fill, uint32_t pixel, struct draft *draft)
{
    const struct scene_camera *camera = &model->scene->camera;
    int x = (int)pixel % camera->width, y = (int)pixel / camera->width;
    struct ray ray = camera_ray(camera, (float)x + .5f, (float)y + .5f);
    struct hit hit;
    *draft = (struct draft){0};
    if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) return;
    shade_point(model, ray, &hit, &draft->point);
    draft->lamps = fill->options.lamps;
    draft->glossy = fill->options.eas && draft->point.brdf.lobe_count > 0 && direct_resolves(&draft->point.brdf);
    if (!draft->glossy && is_black(draft->point.brdf.kd)) return;
    const struct record_cache *cache = draft->glossy ? &fill->glossy : &fill->diffuse;
    draft->wanted = !cache_covers(&cache->zones, draft->point.p, draft->point.n);
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

static bool make_records(const struct model *model, struct progress *progress, struct fill *fill)
{
    const struct scene_camera *camera = &model->scene->camera;
    uint32_t total = (uint32_t)(camera->width * camera->height);
    uint32_t *order = coarse_to_fine(camera->width, camera->height);
    uint32_t largest = FIRST_ROUND + (uint32_t)(ROUND_GROWTH * (float)total);
    struct draft *drafts = malloc(largest * sizeof *drafts);
    int threads = omp_get_max_threads();
    struct record_scratch *scratch = calloc((size_t)threads, sizeof *scratch);
    bool ok = order && drafts && scratch;
    for (uint32_t done = 0, count; ok && done < total; done += count) {
        count = FIRST_ROUND + (uint32_t)(ROUND_GROWTH * (float)done);
        count = count < total - done ? count : total - done;
#pragma omp parallel for schedule(dynamic, 64)
        for (uint32_t i = 0; i < count; i++) look(model, fill, order[done + i], &drafts[i]);
        uint32_t wanted = 0, finished = 0;
        for (uint32_t i = 0; i < count; i++)
            if (drafts[i].wanted) drafts[wanted++] = drafts[i];
#pragma omp parallel for schedule(dynamic, 1)
        for (uint32_t i = 0; i < wanted; i++) {
            float pixel = camera_pixel_width(camera, drafts[i].point.p);
            uint64_t index = fill->diffuse.zones.count + fill->glossy.zones.count + i;
            record_make(model, &fill->bounced, fill->tables, pixel, fill->options.seed, index,
                        &scratch[omp_get_thread_num()], &drafts[i]);
            uint32_t so_far;
#pragma omp atomic capture
            so_far = ++finished;
            if (omp_get_thread_num() == 0) progress_show(progress, (done + (double)so_far / wanted * count) / total);
        }
        for (uint32_t i = 0; i < wanted; i++) {
            ok = ok && !drafts[i].failed && insert(drafts[i].glossy ? &fill->glossy : &fill->diffuse, &drafts[i]);
            free(drafts[i].eas);
        }
    }
    ok = ok && cache_reindex(&fill->diffuse.zones) && cache_reindex(&fill->glossy.zones);
    for (int i = 0; scratch && i < threads; i++) record_scratch_free(&scratch[i]);
    free(scratch);
    free(drafts);
    free(order);
    return ok;
}

bool fill_extend(const struct model *model, struct progress *progress, struct fill *fill,
                 char error[static SCENE_ERROR])
{
    progress_begin(progress, "records", trace_rays(model->trace));
    if (!make_records(model, progress, fill)) {
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
