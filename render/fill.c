/* SPDX-License-Identifier: Apache-2.0 */
#include "render/fill.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "eas/ggx.h"
#include "render/direct.h"
#include "render/record.h"

enum { FIRST_ROUND = 64 };

/* Each round looks at this share more pixels than all before. */
#define ROUND_GROWTH .2f

/* Room for `more` after `count` of them. */
static bool grow(void *array, uint32_t *capacity, uint32_t count, uint32_t more, size_t bytes)
{
    if (more <= *capacity - count) return true;
    uint32_t larger = 2 * (count + more);
    void *grown = larger > count ? realloc(*(void **)array, larger * bytes) : NULL;
    if (!grown) return false;
    *(void **)array = grown;
    *capacity = larger;
    return true;
}

static bool insert(struct record_cache *cache, const struct draft *draft)
{
    uint32_t index = cache->zones.count, floats = hsh_floats(draft->hsh_order);
    if (!grow(&cache->records, &cache->record_capacity, index, 1, sizeof *cache->records) ||
        !grow(&cache->eas, &cache->eas_capacity, cache->eas_count, draft->eas_count, sizeof *cache->eas) ||
        !grow(&cache->hsh, &cache->hsh_capacity, cache->hsh_count, floats, sizeof *cache->hsh))
        return false;
    cache->records[index] =
        (struct record){draft->irradiance, cache->eas_count, draft->eas_count, cache->hsh_count, draft->hsh_order};
    for (uint32_t i = 0; i < draft->eas_count; i++) cache->eas[cache->eas_count++] = draft->eas[i];
    for (uint32_t i = 0; i < floats; i++) cache->hsh[cache->hsh_count++] = draft->hsh[i];
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
    draft->glossy =
        fill->kind != FILL_DIFFUSE && draft->point.brdf.lobe_count > 0 && direct_resolves(&draft->point.brdf);
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

static bool fill_records(const struct model *model, uint64_t seed, struct progress *progress, struct fill *fill)
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
            record_make(model, &fill->bounced, fill->tables, fill->hsh, pixel, seed, index,
                        &scratch[omp_get_thread_num()], &drafts[i]);
            uint32_t so_far;
#pragma omp atomic capture
            so_far = ++finished;
            if (omp_get_thread_num() == 0) progress_show(progress, (done + (double)so_far / wanted * count) / total);
        }
        for (uint32_t i = 0; i < wanted; i++) {
            ok = ok && !drafts[i].failed && insert(drafts[i].glossy ? &fill->glossy : &fill->diffuse, &drafts[i]);
            free(drafts[i].eas);
            free(drafts[i].hsh);
        }
    }
    for (int i = 0; scratch && i < threads; i++) record_scratch_free(&scratch[i]);
    free(scratch);
    free(drafts);
    free(order);
    return ok;
}

static struct lobe lobe_of(enum material_type type, float width)
{
    if (type == MATERIAL_PHONG) return (struct lobe){.type = LOBE_PHONG, .exponent = maxf(width, 0)};
    return (struct lobe){.type = LOBE_METAL, .alpha = maxf(sqr(clampf(width, 0, 1)), GGX_ALPHA_MIN)};
}

/* Tables for the scene's lobes; where a texture chooses the exponent or roughness, for a ladder from the widest to the
 * narrowest that records are made for. */
static struct hsh *build_hsh(const struct scene *scene)
{
    enum { RUNGS = 24 };
    struct lobe *lobes = malloc((size_t)(scene->material_count * RUNGS + 1) * sizeof *lobes);
    int count = 0;
    for (int i = 0; lobes && i < scene->material_count; i++) {
        const struct scene_material *material = &scene->materials[i];
        bool phong = material->type == MATERIAL_PHONG;
        const struct scene_scalar *width = phong ? &material->exponent : &material->roughness;
        if (material->type == MATERIAL_DIFFUSE) continue;
        for (int k = 0; k < (width->texture == SCENE_NONE ? 1 : RUNGS); k++) {
            float rung = powf(phong ? 300 : .2f, (float)k / (RUNGS - 1));
            struct lobe lobe = lobe_of(material->type, width->texture == SCENE_NONE ? width->value : rung);
            if (direct_resolves(&(struct brdf){.lobe_count = 1, .lobes = {lobe}})) lobes[count++] = lobe;
        }
    }
    struct hsh *hsh = lobes ? hsh_build(lobes, count, HSH_LOSS, HSH_ORDER) : NULL;
    free(lobes);
    return hsh;
}

bool fill_build(const struct model *model, enum fill_kind kind, uint64_t seed, struct progress *progress,
                struct fill *fill, char error[static SCENE_ERROR])
{
    *fill = (struct fill){
        .kind = kind, .diffuse.zones = cache_empty(RECORD_STRETCH), .glossy.zones = cache_empty(RECORD_STRETCH)};
    progress_begin(progress, "diffuse cache", trace_rays(model->trace));
    if (!diffuse_cache_build(model, seed, progress, &fill->bounced, error)) return false;
    progress_end(progress, trace_rays(model->trace));
    progress_begin(progress, "records", trace_rays(model->trace));
    fill->tables = mean_brdf_build();
    if (kind == FILL_HSH) fill->hsh = build_hsh(model->scene);
    if (!fill->tables || (kind == FILL_HSH && !fill->hsh) || !fill_records(model, seed, progress, fill)) {
        fill_free(fill);
        snprintf(error, SCENE_ERROR, "radiance cache: out of memory");
        return false;
    }
    progress_end(progress, trace_rays(model->trace));
    return true;
}

static void record_cache_free(struct record_cache *cache)
{
    cache_free(&cache->zones);
    free(cache->records);
    free(cache->eas);
    free(cache->hsh);
}

void fill_free(struct fill *fill)
{
    diffuse_cache_free(&fill->bounced);
    record_cache_free(&fill->diffuse);
    record_cache_free(&fill->glossy);
    mean_brdf_free(fill->tables);
    hsh_free(fill->hsh);
    *fill = (struct fill){0};
}

static size_t record_bytes(const struct record_cache *cache)
{
    return cache->zones.count * sizeof *cache->records + cache->eas_count * sizeof *cache->eas +
           cache->hsh_count * sizeof *cache->hsh;
}

size_t fill_bytes(const struct fill *fill)
{
    return diffuse_cache_bytes(&fill->bounced) + cache_bytes(&fill->diffuse.zones) + record_bytes(&fill->diffuse) +
           cache_bytes(&fill->glossy.zones) + record_bytes(&fill->glossy);
}

double fill_bytes_per_record(const struct fill *fill)
{
    uint32_t count = fill->glossy.zones.count;
    return count ? (double)record_bytes(&fill->glossy) / count + sizeof(struct zone) : 0;
}
