/* SPDX-License-Identifier: Apache-2.0 */
#include "render/fill.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "eas/ggx.h"
#include "render/direct.h"
#include "render/record.h"
#include "render/surfaces.h"

/* Places over all surfaces: no more than so many, and enough once less than UNCOVERED of a large round want records:
 * what is left open, by area, is traced. */
enum { FIRST_ROUND = 64, LEAST_LAST_ROUND = 1024, MOST_PLACES = 1 << 24 };
#define UNCOVERED .005f

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
    *draft = (struct draft){
        .lamps = fill->options.lamps, .anywhere = !places->pixels, .coarseness = fill->options.coarseness};
    if (places->pixels) {
        const struct scene_camera *camera = &model->scene->camera;
        uint32_t pixel = places->pixels[place];
        int x = (int)pixel % camera->width, y = (int)pixel / camera->width;
        struct ray ray = camera_ray(camera, (float)x + .5f, (float)y + .5f);
        struct hit hit;
        if (!trace_camera(model->trace, ray.origin, ray.dir, INFINITY, &hit)) return;
        shade_point(model, ray, &hit, &draft->point);
    } else if (!surfaces_point(&places->surfaces, place, &draft->point)) {
        return;
    }
    draft->point.brdf.lobe_count = direct_sort(&draft->point.brdf); /* the others are traced */
    draft->glossy = fill_has_glossy(fill) && draft->point.brdf.lobe_count > 0;
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

/* What stands for a pixel's width where there is no camera: that of a picture of the whole scene, m. */
static float surface_pixel(const struct model *model)
{
    const struct scene_camera *camera = &model->scene->camera;
    return 2 * model->radius / (float)(camera->width > camera->height ? camera->width : camera->height);
}

/* Makes the records of the first `wanted` drafts, and inserts them in their order; meanwhile progress goes from..to. */
static bool make_records(const struct model *model, struct draft *drafts, uint32_t wanted,
                         struct record_scratch *scratch, struct progress *progress, double from, double to,
                         struct fill *fill)
{
    bool ok = true;
    uint32_t finished = 0;
#pragma omp parallel for schedule(dynamic, 1)
    for (uint32_t i = 0; i < wanted; i++) {
        float pixel = drafts[i].anywhere ? surface_pixel(model)
                                         : camera_pixel_width(&model->scene->camera, drafts[i].point.p);
        record_make(model, &fill->bounced, fill->tables, fill->hsh, pixel, fill->options.seed, fill_records(fill) + i,
                    &scratch[omp_get_thread_num()], &drafts[i]);
        uint32_t so_far;
#pragma omp atomic capture
        so_far = ++finished;
        if (omp_get_thread_num() == 0) progress_show(progress, from + (to - from) * so_far / wanted);
    }
    for (uint32_t i = 0; i < wanted; i++) {
        ok = ok && !drafts[i].failed && insert(drafts[i].glossy ? &fill->glossy : &fill->diffuse, &drafts[i]);
        free(drafts[i].eas);
        free(drafts[i].hsh);
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
    double shown = 0;
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
        /* Over surfaces the share that is covered already stands for how far it is. */
        double now = places.pixels ? (double)(done + count) / places.count : 1 - (double)wanted / count;
        ok = ok && make_records(model, drafts, wanted, scratch, progress, shown, now, fill);
        shown = now;
        free(drafts);
        covered = !places.pixels && count >= LEAST_LAST_ROUND && (float)wanted < UNCOVERED * (float)count;
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
    if (fill->options.kind == FILL_NONE) return true;
    progress_begin(progress, "records", trace_rays(model->trace));
    if (!fill_places(model, progress, fill)) {
        snprintf(error, SCENE_ERROR, "radiance cache: out of memory");
        return false;
    }
    progress_end(progress, trace_rays(model->trace));
    return true;
}

static struct lobe lobe_of(enum closure_type type, float width)
{
    if (type == CLOSURE_PHONG) return (struct lobe){.type = LOBE_PHONG, .exponent = maxf(width, 0)};
    float2 alpha = ggx_alphas(clampf(width, 0, 1), 0);
    return (struct lobe){.type = LOBE_METAL, .alpha_x = alpha.x, .alpha_y = alpha.y};
}

/* Tables for the scene's lobes; where a texture chooses the exponent or roughness, for a ladder from the widest to the
 * narrowest that records are made for. */
static struct hsh *build_hsh(const struct scene *scene)
{
    enum { RUNGS = 24 };
    int closures = 0, count = 0;
    for (int i = 0; i < scene->material_count; i++) closures += scene->materials[i].closure_count;
    struct lobe *lobes = malloc((size_t)(closures * RUNGS + 1) * sizeof *lobes);
    for (int i = 0; lobes && i < scene->material_count; i++)
        for (int c = 0; c < scene->materials[i].closure_count; c++) {
            const struct scene_closure *closure = &scene->materials[i].closures[c];
            bool phong = closure->type == CLOSURE_PHONG;
            if (!phong && closure->type != CLOSURE_GLOSSY && closure->type != CLOSURE_PRINCIPLED) continue;
            const struct scene_scalar *width = phong ? &closure->exponent : &closure->roughness;
            for (int k = 0; k < (width->texture == SCENE_NONE ? 1 : RUNGS); k++) {
                float rung = powf(phong ? 300 : .2f, (float)k / (RUNGS - 1));
                struct lobe lobe = lobe_of(closure->type, width->texture == SCENE_NONE ? width->value : rung);
                if (direct_resolves(&lobe)) lobes[count++] = lobe;
            }
        }
    struct hsh *hsh = lobes ? hsh_build(lobes, count, HSH_LOSS, HSH_ORDER) : NULL;
    free(lobes);
    return hsh;
}

bool fill_tables(const struct scene *scene, struct fill *fill)
{
    fill->tables = mean_brdf_build();
    if (fill->options.kind == FILL_HSH) fill->hsh = build_hsh(scene);
    return fill->tables && (fill->options.kind != FILL_HSH || fill->hsh);
}

bool fill_build(const struct model *model, const struct fill_options *options, struct progress *progress,
                struct fill *fill, char error[static SCENE_ERROR])
{
    *fill = (struct fill){
        .options = *options, .diffuse.zones = cache_empty(RECORD_STRETCH), .glossy.zones = cache_empty(RECORD_STRETCH)};
    progress_begin(progress, "diffuse cache", trace_rays(model->trace));
    if (!diffuse_cache_build(model, options->coarseness, options->seed, progress, &fill->bounced, error)) return false;
    bool ok = fill_tables(model->scene, fill);
    progress_end(progress, trace_rays(model->trace));
    if (ok && fill_extend(model, progress, fill, error)) return true;
    fill_free(fill);
    snprintf(error, SCENE_ERROR, "radiance cache: out of memory");
    return false;
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

uint64_t fill_records(const struct fill *fill)
{
    return (uint64_t)fill->diffuse.zones.count + fill->glossy.zones.count;
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
