/* SPDX-License-Identifier: Apache-2.0 */
#include "render/record.h"

#include <stdlib.h>

/* Strata of the first round; most rays a side of a stratum where lobes look, where they may look anywhere, and where
 * light is concentrated. */
enum { GATHER_RAYS = 256, MOST_SPLIT = 4, SPREAD_SPLIT = 2, HOT_SPLIT = 3, SEED_RECORD = 201 };

/* Zones: half the distance to the nearest surface, at least and at most so many pixels in radius. */
#define ZONE_SHARE .5f
#define LEAST_PIXELS 1.5f
#define MOST_PIXELS 24.0f
/* Glossy records send about FOCUS_RAYS more rays within so many lobe widths, and a margin in rad, of the mirror
 * direction. */
#define FOCUS_RAYS 128.0f
#define FOCUS_WIDTHS 1.5f
#define FOCUS_MARGIN .05f
/* On curved surfaces the normal turns by this share of the lobe's width at most within a zone. */
#define CURVED_ZONE 1.0f
/* Records whose zone is this many times the least send four times the rays. */
#define FINE_ZONE 2.0f
/* Strata beside ones brighter than HOT times the mean get HOT_SPLIT x HOT_SPLIT rays. */
#define HOT 8.0f

static const struct select_options SELECT = SELECT_DEFAULTS;

/* Room for `strata` strata and `rays` rays. */
static bool reserve(struct record_scratch *scratch, uint32_t strata, uint32_t rays)
{
    if (strata > scratch->strata) {
        free(scratch->all);
        free(scratch->first);
        free(scratch->sides);
        free(scratch->occlusions);
        scratch->all = malloc(strata * sizeof *scratch->all);
        scratch->first = malloc(strata * sizeof *scratch->first);
        scratch->sides = malloc(strata * sizeof *scratch->sides);
        scratch->occlusions = malloc(strata * sizeof *scratch->occlusions);
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
    return scratch->all && scratch->first && scratch->occlusions && scratch->sides && scratch->surface &&
           scratch->mirrored && scratch->infinite && scratch->eas;
}

void record_scratch_free(struct record_scratch *scratch)
{
    free(scratch->all);
    free(scratch->surface);
    free(scratch->mirrored);
    free(scratch->infinite);
    free(scratch->first);
    free(scratch->sides);
    free(scratch->occlusions);
    for (int i = 0; i < 3; i++) sample_tree_free(&scratch->trees[i]);
    select_free(&scratch->select);
    free(scratch->eas);
}

/* How a record's hemisphere is sampled: a grid of strata, one ray each; then split x split rays in the strata within
 * `cone` of `mirror`, where the viewer's lobes look (Gassenbauer et al. 2009 gather by the views that will ask). */
struct plan {
    struct gather_grid grid;
    struct frame frame;
    float most;            /* radius of the zone, m */
    float bend;            /* how fast the normal turns, rad/m */
    float lobe;            /* half-angle of what a viewer's lobes look at, rad; 0: no lobes */
    float3 mirror;         /* of the viewer's direction */
    float turn, cone;      /* of the normal within the zone; half-angle of what all its viewers look at, rad */
    int split, everywhere; /* rays a side of strata within the cone; factor on those of all strata */
};

static struct plan plan_gather(const struct model *model, const struct draft *draft, float pixel)
{
    const struct brdf *brdf = &draft->point.brdf;
    struct plan plan = {.grid = gather_grid(GATHER_RAYS >> 2 * (draft->coarseness > 1 ? draft->coarseness - 1 : 0)),
                        .frame = frame_about(draft->point.n),
                        .mirror = reflect(draft->point.wo, draft->point.n),
                        .most = MOST_PIXELS * pixel};
    if (!draft->glossy) return plan;
    float widest = 0, narrowest = INFINITY;
    shade_curvature(model, &draft->point, &plan.bend);
    for (int i = 0; i < brdf->lobe_count; i++) {
        widest = maxf(widest, lobe_width(&brdf->lobes[i]));
        narrowest = minf(narrowest, lobe_width(&brdf->lobes[i]));
    }
    plan.lobe = FOCUS_WIDTHS * widest + FOCUS_MARGIN;
    plan.most = maxf(minf(plan.most, CURVED_ZONE * narrowest / maxf(plan.bend, 1e-6f)), draft->least);
    return plan;
}

/* Decides on the rays proper, the zone's radius being known but for what they find nearer. A zone of many pixels
 * deserves more rays than one of a few, whose neighbours average its noise away. */
static void plan_rays(const struct draft *draft, float radius, struct plan *plan)
{
    plan->everywhere = draft->coarseness == 0 && radius > FINE_ZONE * draft->least ? 2 : 1;
    plan->turn = plan->bend * radius;
    plan->cone = minf(plan->lobe + 2 * plan->turn, PI);
    plan->split = 1;
    if (draft->anywhere) plan->cone = plan->turn = PI;
    if (plan->lobe <= 0) return;
    float strata = (1 - cosf(plan->lobe)) * (float)(plan->grid.rows * plan->grid.columns);
    plan->split = (int)clampf(roundf(sqrtf(FOCUS_RAYS / strata)), 1, draft->anywhere ? SPREAD_SPLIT : MOST_SPLIT);
}

/* Sends a ray through a random point of part k of side x side of a stratum. */
static struct gathered send(const struct model *model, const struct diffuse_cache *bounced, const struct draft *draft,
                            const struct plan *plan, int stratum, int k, int side, struct rng *rng, float3 *dir)
{
    const struct point *point = &draft->point;
    int row = stratum / plan->grid.columns, column = stratum % plan->grid.columns;
    float u = ((float)(k / side) + rng_float(rng)) / (float)side,
          v = ((float)(k % side) + rng_float(rng)) / (float)side;
    *dir = to_world(plan->frame, gather_direction(plan->grid, row, column, u, v));
    if (dot(*dir, point->ng) <= 0) return (struct gathered){.distance = INFINITY};
    struct ray ray = {point->origin, *dir};
    return draft->lamps ? gather_all(model, bounced, ray, rng) : gather(model, bounced, ray, rng, NULL);
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

/* Sorts a gathered ray's light among the samples that EAS are made of: on surfaces, in mirrors, at infinity. `share`:
 * its part of the stratum's solid angle. */
static void sort_sample(const struct gathered *light, float3 dir, float omega, float share,
                        const struct occlusion *occlusion, struct record_scratch *scratch, uint32_t counts[3])
{
    struct gather_sample s = {dir,           light->distance,
                              light->normal, light->surface,
                              omega * share, occlusion_uncovered(occlusion, light->distance, omega)};
    struct gather_sample m = {dir,
                              light->mirrored_distance,
                              scale(dir, -1),
                              light->mirrored,
                              omega * share,
                              occlusion_uncovered(occlusion, light->mirrored_distance, omega)};
    if (isinf(s.distance)) scratch->infinite[counts[2]++] = s;
    else scratch->surface[counts[0]++] = s;
    if (is_black(m.radiance)) return;
    if (isinf(m.distance)) scratch->infinite[counts[2]++] = m;
    else scratch->mirrored[counts[1]++] = m;
}

/* Into how many parts a side each stratum is split for the rays proper. Returns the rays in all. */
static uint32_t choose_sides(const struct plan *plan, struct record_scratch *scratch)
{
    int strata = plan->grid.rows * plan->grid.columns;
    uint32_t rays = 0;
    float mean = 0;
    for (int i = 0; i < strata; i++) mean += luminance(scratch->all[i].radiance) / (float)strata;
    for (int i = 0; i < strata; i++) {
        int row = i / plan->grid.columns, column = i % plan->grid.columns, side = 1;
        float3 middle = to_world(plan->frame, gather_direction(plan->grid, row, column, .5f, .5f));
        if (plan->lobe > 0 && dot(middle, plan->mirror) > cosf(plan->cone)) side = plan->split;
        if (is_hot(scratch->all, plan, i, mean)) side = side > HOT_SPLIT ? side : HOT_SPLIT;
        side *= plan->everywhere;
        scratch->sides[i] = side;
        rays += (uint32_t)(side * side);
    }
    return rays;
}

/* Chooses the record's EAS from samples sorted by where they lie: on surfaces, in mirrors, at infinity. */
static void choose_eas(const struct mean_brdf *tables, struct draft *draft, const struct plan *plan,
                       const uint32_t counts[3], struct record_scratch *scratch)
{
    const struct gather_sample *samples[3] = {scratch->surface, scratch->mirrored, scratch->infinite};
    for (int i = 0; i < 3; i++)
        if (!sample_tree_build(&scratch->trees[i], samples[i], counts[i], draft->zone.p, plan->frame)) {
            draft->failed = true;
            return;
        }
    const struct brdf *brdf = &draft->point.brdf;
    struct select_place place = {draft->zone.p,      plan->frame, draft->point.wo,
                                 draft->zone.radius, plan->turn,  luminance(mul(brdf->kd, draft->irradiance.e)) / PI};
    uint32_t count = select_eas(scratch->trees, 3, tables, brdf->lobes, brdf->lobe_count, &place, &SELECT,
                                &scratch->select, scratch->eas);
    draft->failed = count == UINT32_MAX || (count && !(draft->eas = malloc(count * sizeof *draft->eas)));
    if (draft->failed) return;
    draft->eas_count = count;
    for (uint32_t i = 0; i < count; i++) draft->eas[i] = scratch->eas[i];
}

/* The same samples as HSH. */
static void project_hsh(const struct hsh *hsh, struct draft *draft, const uint32_t counts[3],
                        struct record_scratch *scratch)
{
    const struct gather_sample *samples[3] = {scratch->surface, scratch->mirrored, scratch->infinite};
    const struct brdf *brdf = &draft->point.brdf;
    for (int i = 0; i < brdf->lobe_count; i++) {
        int order = hsh_order(hsh, &brdf->lobes[i]);
        draft->hsh_order = order > draft->hsh_order ? order : draft->hsh_order;
    }
    draft->hsh = calloc(hsh_floats(draft->hsh_order), sizeof *draft->hsh);
    draft->failed = !draft->hsh;
    for (int i = 0; draft->hsh && i < 3; i++)
        hsh_add(hsh, samples[i], counts[i], draft->zone.n, draft->zone.radius * RECORD_STRETCH, draft->hsh_order,
                draft->hsh);
}

void record_make(const struct model *model, const struct diffuse_cache *bounced, const struct mean_brdf *tables,
                 const struct hsh *hsh, float pixel, uint64_t seed, uint64_t index, struct record_scratch *scratch,
                 struct draft *draft)
{
    const struct point *point = &draft->point;
    struct rng rng = rng_seed(seed, SEED_RECORD, index);
    draft->least = LEAST_PIXELS * pixel;
    struct plan plan = plan_gather(model, draft, pixel);
    int strata = plan.grid.rows * plan.grid.columns;
    float omega = 2 * PI / (float)strata, nearest = INFINITY;
    uint32_t counts[3] = {0};
    draft->failed = !reserve(scratch, (uint32_t)strata, (uint32_t)strata);
    for (int i = 0; !draft->failed && i < strata; i++) {
        struct gathered *first = &scratch->first[i];
        float3 dir;
        *first = send(model, bounced, draft, &plan, i, 0, 1, &rng, &dir);
        scratch->all[i] = (struct gather_sample){
            dir, first->distance, first->normal, add(first->surface, first->mirrored), omega, vec3(0, 0, 0)};
        if (!draft->glossy) scratch->all[i].radiance = gathered_diffuse(first, bounced);
        nearest = minf(nearest, first->distance);
    }
    plan_rays(draft, minf(ZONE_SHARE * nearest, plan.most), &plan);
    draft->failed = draft->failed || !reserve(scratch, (uint32_t)strata, choose_sides(&plan, scratch));
    if (draft->failed) return;
    occlusion_of(scratch->all, plan.grid, plan.frame, scratch->occlusions);
    struct gather_sample *all = scratch->all;
    for (int i = 0; i < strata; i++) {
        int side = scratch->sides[i];
        if (side == 1) {
            sort_sample(&scratch->first[i], all[i].dir, omega, 1, &scratch->occlusions[i], scratch, counts);
            all[i].radiance = gathered_diffuse(&scratch->first[i], bounced);
            continue;
        }
        float share = 1 / (float)(side * side);
        rgb sum = {0};
        float3 direction = {0};
        for (int k = 0; k < side * side; k++) {
            float3 dir;
            struct gathered light = send(model, bounced, draft, &plan, i, k, side, &rng, &dir);
            all[i].distance = minf(all[i].distance, light.distance);
            sum = add(sum, gathered_diffuse(&light, bounced));
            direction = add(direction, dir);
            sort_sample(&light, dir, omega, share, &scratch->occlusions[i], scratch, counts);
        }
        all[i].radiance = scale(sum, share);
        all[i].dir = normalize(direction);
        nearest = minf(nearest, all[i].distance);
    }
    draft->irradiance = irradiance_of(all, plan.grid, plan.frame);
    float radius = minf(ZONE_SHARE * nearest, irradiance_reach(&draft->irradiance));
    draft->zone = (struct zone){point->p, point->n, clampf(radius, draft->least, plan.most)};
    irradiance_limit(&draft->irradiance, draft->zone.radius * RECORD_STRETCH);
    if (draft->glossy && hsh) project_hsh(hsh, draft, counts, scratch);
    else if (draft->glossy) choose_eas(tables, draft, &plan, counts, scratch);
}
