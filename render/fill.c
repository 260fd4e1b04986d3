/* SPDX-License-Identifier: Apache-2.0 */
#include "render/fill.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "render/direct.h"
#include "render/gather.h"

enum { GATHER_RAYS = 256, MOST_SPLIT = 4, HOT_SPLIT = 3, SEED_RECORD = 201, FIRST_ROUND = 64 };

/* Zones: half the distance to the nearest surface, at least and at most so many pixels in radius. */
#define ZONE_SHARE .5f
#define LEAST_PIXELS 1.5f
#define MOST_PIXELS 24.0f
/* Look-ups reach 1.5 radii, so that zones overlap. */
#define STRETCH 1.5f
/* Glossy records send about FOCUS_RAYS more rays within so many lobe widths, and a margin in rad, of the mirror
 * direction. */
#define FOCUS_RAYS 128.0f
#define FOCUS_WIDTHS 1.5f
#define FOCUS_MARGIN .05f
/* Records whose zone is this many times the least send four times the rays. */
#define FINE_ZONE 2.0f
/* Strata beside ones brighter than HOT times the mean get HOT_SPLIT x HOT_SPLIT rays. */
#define HOT 8.0f
/* Each round looks at this share more pixels than all before. */
#define ROUND_GROWTH .2f

/* A record on its way into the cache, and one thread's scratch for making it. */
struct draft {
    struct point point;
    bool wanted, glossy, failed;
    struct zone zone;
    float least;
    struct irradiance irradiance;
    struct eas *eas;
    uint32_t eas_count;
};

struct scratch {
    uint32_t strata, rays; /* room */
    struct gather_sample *all, *surface, *mirrored, *infinite;
    struct gathered *first; /* of each stratum */
    int *sides;             /* into how many parts a side each stratum is split */
    struct sample_tree trees[3];
    struct select_scratch select;
    struct eas *eas;
};

static const struct select_options SELECT = SELECT_DEFAULTS;

/* Room for `strata` strata and `rays` rays. */
static bool scratch_reserve(struct scratch *scratch, uint32_t strata, uint32_t rays)
{
    if (strata > scratch->strata) {
        free(scratch->all);
        free(scratch->first);
        free(scratch->sides);
        scratch->all = malloc(strata * sizeof *scratch->all);
        scratch->first = malloc(strata * sizeof *scratch->first);
        scratch->sides = malloc(strata * sizeof *scratch->sides);
        scratch->strata = strata;
    }
    if (rays > scratch->rays) {
        free(scratch->surface);
        free(scratch->mirrored);
        free(scratch->infinite);
        scratch->surface = malloc(rays * sizeof *scratch->surface);
        scratch->mirrored = malloc(rays * sizeof *scratch->mirrored);
        scratch->infinite = malloc(2 * (size_t)rays * sizeof *scratch->infinite);
        scratch->rays = rays;
    }
    if (!scratch->eas) scratch->eas = malloc((size_t)SELECT.most * sizeof *scratch->eas);
    return scratch->all && scratch->first && scratch->sides && scratch->surface && scratch->mirrored &&
           scratch->infinite && scratch->eas;
}

static void scratch_free(struct scratch *scratch)
{
    free(scratch->all);
    free(scratch->surface);
    free(scratch->mirrored);
    free(scratch->infinite);
    free(scratch->first);
    free(scratch->sides);
    for (int i = 0; i < 3; i++) sample_tree_free(&scratch->trees[i]);
    select_free(&scratch->select);
    free(scratch->eas);
}

/* Chooses the record's EAS from samples sorted by where they lie: on surfaces, in mirrors, at infinity. */
static void choose_eas(const struct fill *fill, struct draft *draft, struct frame frame, const uint32_t counts[3],
                       struct scratch *scratch)
{
    const struct gather_sample *samples[3] = {scratch->surface, scratch->mirrored, scratch->infinite};
    for (int i = 0; i < 3; i++)
        if (!sample_tree_build(&scratch->trees[i], samples[i], counts[i], draft->zone.p, frame)) {
            draft->failed = true;
            return;
        }
    const struct brdf *brdf = &draft->point.brdf;
    struct select_place place = {draft->zone.p, frame, draft->point.wo, draft->zone.radius,
                                 luminance(mul(brdf->kd, draft->irradiance.e)) / PI};
    uint32_t count = select_eas(scratch->trees, 3, fill->tables, brdf->lobes, brdf->lobe_count, &place, &SELECT,
                                &scratch->select, scratch->eas);
    draft->failed = count == UINT32_MAX || (count && !(draft->eas = malloc(count * sizeof *draft->eas)));
    if (draft->failed) return;
    draft->eas_count = count;
    for (uint32_t i = 0; i < count; i++) draft->eas[i] = scratch->eas[i];
}

/* How a record's hemisphere is sampled: a grid of strata, one ray each; split x split rays in the strata within `cone`
 * of `mirror`, where the viewer's lobes look (Gassenbauer et al. 2009 gather by the views that will ask). */
struct plan {
    struct gather_grid grid;
    struct frame frame;
    float3 mirror;
    float cone;
    int split; /* within the cone, to begin with */
};

static struct plan plan_gather(const struct draft *draft)
{
    struct plan plan = {.grid = gather_grid(GATHER_RAYS), .frame = frame_about(draft->point.n), .split = 1};
    float width = 0;
    for (int i = 0; draft->glossy && i < draft->point.brdf.lobe_count; i++)
        width = maxf(width, lobe_width(&draft->point.brdf.lobes[i]));
    plan.mirror = reflect(draft->point.wo, draft->point.n);
    plan.cone = minf(FOCUS_WIDTHS * width + FOCUS_MARGIN, PI);
    if (width > 0) {
        float strata = (1 - cosf(plan.cone)) * (float)(plan.grid.rows * plan.grid.columns);
        plan.split = (int)clampf(roundf(sqrtf(FOCUS_RAYS / strata)), 1, MOST_SPLIT);
    }
    return plan;
}

/* Sends a ray through a random point of part k of side x side of a stratum. */
static struct gathered send(const struct model *model, const struct fill *fill, const struct point *point,
                            const struct plan *plan, int stratum, int k, int side, struct rng *rng, float3 *dir)
{
    int row = stratum / plan->grid.columns, column = stratum % plan->grid.columns;
    float u = ((float)(k / side) + rng_float(rng)) / (float)side,
          v = ((float)(k % side) + rng_float(rng)) / (float)side;
    *dir = to_world(plan->frame, gather_direction(plan->grid, row, column, u, v));
    if (dot(*dir, point->ng) <= 0) return (struct gathered){.distance = INFINITY};
    return gather(model, &fill->bounced, (struct ray){point->origin, *dir}, rng, NULL);
}

/* Whether a stratum's neighbours are so bright that one ray would be a gamble: a share HOT of what all strata bring.
 * Its own ray has no say, which would bias the mean. */
static bool is_hot(const struct gather_sample *all, const struct plan *plan, int stratum, float mean)
{
    int columns = plan->grid.columns, row = stratum / columns, column = stratum % columns;
    for (int j = row > 0 ? row - 1 : 0; j <= row + 1 && j < plan->grid.rows; j++)
        for (int i = -1; i <= 1; i++) {
            int other = j * columns + (column + i + columns) % columns;
            if (other != stratum && luminance(all[other].radiance) > HOT * mean) return true;
        }
    return false;
}

/* Sorts a gathered ray's light among the samples that EAS are made of: on surfaces, in mirrors, at infinity. */
static void sort_sample(const struct gathered *light, float3 dir, float omega, struct scratch *scratch,
                        uint32_t counts[3])
{
    struct gather_sample s = {dir, light->distance, light->normal, light->surface, omega};
    struct gather_sample m = {dir, light->mirrored_distance, scale(dir, -1), light->mirrored, omega};
    if (isinf(s.distance)) scratch->infinite[counts[2]++] = s;
    else scratch->surface[counts[0]++] = s;
    if (is_black(m.radiance)) return;
    if (isinf(m.distance)) scratch->infinite[counts[2]++] = m;
    else scratch->mirrored[counts[1]++] = m;
}

/* Into how many parts a side each stratum is split for the rays proper. A zone of many pixels deserves more rays than
 * one of a few, whose neighbours average its noise away. Returns the rays in all. */
static uint32_t choose_sides(const struct draft *draft, const struct plan *plan, float radius, struct scratch *scratch)
{
    int strata = plan->grid.rows * plan->grid.columns, everywhere = radius > FINE_ZONE * draft->least ? 2 : 1;
    uint32_t rays = 0;
    float mean = 0;
    for (int i = 0; i < strata; i++) mean += luminance(scratch->all[i].radiance) / (float)strata;
    for (int i = 0; i < strata; i++) {
        int row = i / plan->grid.columns, column = i % plan->grid.columns, side = 1;
        float3 middle = to_world(plan->frame, gather_direction(plan->grid, row, column, .5f, .5f));
        if (dot(middle, plan->mirror) > cosf(plan->cone)) side = plan->split;
        if (is_hot(scratch->all, plan, i, mean)) side = side > HOT_SPLIT ? side : HOT_SPLIT;
        side *= everywhere;
        scratch->sides[i] = side;
        rays += (uint32_t)(side * side);
    }
    return rays;
}

/* Gathers a record at draft->point: first a ray a stratum, then more where the lobes look, where the light is
 * concentrated and where the zone is large. */
static void make_record(const struct model *model, const struct fill *fill, struct draft *draft, float pixel,
                        uint64_t seed, uint64_t index, struct scratch *scratch)
{
    const struct point *point = &draft->point;
    struct rng rng = rng_seed(seed, SEED_RECORD, index);
    struct plan plan = plan_gather(draft);
    int strata = plan.grid.rows * plan.grid.columns;
    float omega = 2 * PI / (float)strata, nearest = INFINITY;
    uint32_t counts[3] = {0};
    draft->least = LEAST_PIXELS * pixel;
    draft->failed = !scratch_reserve(scratch, (uint32_t)strata, (uint32_t)strata);
    for (int i = 0; !draft->failed && i < strata; i++) {
        struct gathered *first = &scratch->first[i];
        float3 dir;
        *first = send(model, fill, point, &plan, i, 0, 1, &rng, &dir);
        scratch->all[i] =
            (struct gather_sample){dir, first->distance, first->normal, add(first->surface, first->mirrored), omega};
        nearest = minf(nearest, first->distance);
    }
    draft->failed = draft->failed || !scratch_reserve(scratch, (uint32_t)strata,
                                                      choose_sides(draft, &plan, ZONE_SHARE * nearest, scratch));
    if (draft->failed) return;
    struct gather_sample *all = scratch->all;
    for (int i = 0; i < strata; i++) {
        int side = scratch->sides[i];
        if (side == 1) {
            sort_sample(&scratch->first[i], all[i].dir, omega, scratch, counts);
            continue;
        }
        float share = 1 / (float)(side * side);
        rgb sum = {0};
        float3 direction = {0};
        for (int k = 0; k < side * side; k++) {
            float3 dir;
            struct gathered light = send(model, fill, point, &plan, i, k, side, &rng, &dir);
            all[i].distance = minf(all[i].distance, light.distance);
            sum = add(sum, add(light.surface, light.mirrored));
            direction = add(direction, dir);
            sort_sample(&light, dir, omega * share, scratch, counts);
        }
        all[i].radiance = scale(sum, share);
        all[i].dir = normalize(direction);
        nearest = minf(nearest, all[i].distance);
    }
    draft->irradiance = irradiance_of(all, plan.grid, plan.frame);
    float radius = minf(ZONE_SHARE * nearest, irradiance_reach(&draft->irradiance));
    draft->zone = (struct zone){point->p, point->n, clampf(radius, draft->least, MOST_PIXELS * pixel)};
    irradiance_limit(&draft->irradiance, draft->zone.radius * STRETCH);
    if (draft->glossy) choose_eas(fill, draft, plan.frame, counts, scratch);
}

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
static void look(const struct model *model, const struct fill *fill, bool eas, uint32_t pixel, struct draft *draft)
{
    const struct scene_camera *camera = &model->scene->camera;
    int x = (int)pixel % camera->width, y = (int)pixel / camera->width;
    struct ray ray = camera_ray(camera, (float)x + .5f, (float)y + .5f);
    struct hit hit;
    *draft = (struct draft){0};
    if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) return;
    shade_point(model, ray, &hit, &draft->point);
    draft->glossy = eas && draft->point.brdf.lobe_count > 0 && direct_resolves(&draft->point.brdf);
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

static bool fill_records(const struct model *model, bool eas, uint64_t seed, struct progress *progress,
                         struct fill *fill)
{
    const struct scene_camera *camera = &model->scene->camera;
    float pixel_angle = sqrtf(camera_pixel_angle(camera));
    float3 eye = vec3(camera->transform[3], camera->transform[7], camera->transform[11]);
    uint32_t total = (uint32_t)(camera->width * camera->height);
    uint32_t *order = coarse_to_fine(camera->width, camera->height);
    uint32_t largest = FIRST_ROUND + (uint32_t)(ROUND_GROWTH * (float)total);
    struct draft *drafts = malloc(largest * sizeof *drafts);
    int threads = omp_get_max_threads();
    struct scratch *scratch = calloc((size_t)threads, sizeof *scratch);
    bool ok = order && drafts && scratch;
    for (uint32_t done = 0, count; ok && done < total; done += count) {
        count = FIRST_ROUND + (uint32_t)(ROUND_GROWTH * (float)done);
        count = count < total - done ? count : total - done;
#pragma omp parallel for schedule(dynamic, 64)
        for (uint32_t i = 0; i < count; i++) look(model, fill, eas, order[done + i], &drafts[i]);
        uint32_t wanted = 0, finished = 0;
        for (uint32_t i = 0; i < count; i++)
            if (drafts[i].wanted) drafts[wanted++] = drafts[i];
#pragma omp parallel for schedule(dynamic, 1)
        for (uint32_t i = 0; i < wanted; i++) {
            float pixel = length(sub(drafts[i].point.p, eye)) * pixel_angle;
            make_record(model, fill, &drafts[i], pixel, seed, fill->diffuse.zones.count + fill->glossy.zones.count + i,
                        &scratch[omp_get_thread_num()]);
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
    for (int i = 0; scratch && i < threads; i++) scratch_free(&scratch[i]);
    free(scratch);
    free(drafts);
    free(order);
    return ok;
}

bool fill_build(const struct model *model, bool eas, uint64_t seed, struct progress *progress, struct fill *fill,
                char error[static SCENE_ERROR])
{
    *fill = (struct fill){.diffuse.zones = cache_empty(STRETCH), .glossy.zones = cache_empty(STRETCH)};
    progress_begin(progress, "diffuse cache", trace_rays(model->trace));
    if (!diffuse_cache_build(model, seed, progress, &fill->bounced, error)) return false;
    progress_end(progress, trace_rays(model->trace));
    progress_begin(progress, "records", trace_rays(model->trace));
    fill->tables = mean_brdf_build();
    if (!fill->tables || !fill_records(model, eas, seed, progress, fill)) {
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
}

void fill_free(struct fill *fill)
{
    diffuse_cache_free(&fill->bounced);
    record_cache_free(&fill->diffuse);
    record_cache_free(&fill->glossy);
    mean_brdf_free(fill->tables);
    *fill = (struct fill){0};
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
