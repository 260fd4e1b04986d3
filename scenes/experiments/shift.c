/* SPDX-License-Identifier: Apache-2.0 */
#include "scenes/experiments/shift.h"

#include <stdlib.h>

#include "eas/hsh.h"
#include "eas/occlusion.h"
#include "eas/select.h"
#include "scenes/experiments/gathering.h"

enum { RECORD_RAYS = 4000, TRUTH_RAYS = 16000, POINTS = 24, VIEWERS = 128, SEED_TRUTH = 100, SEED_FRESH = 200 };

static const float3 RECORD = {.35f, 1, .9f}, NORMAL = {0, -1, 0};
#define DISTANCE .1f

const char *const SHIFT_NAMES[SHIFT_WAYS] = {"not moved",
                                             "pinned to what was hit (the paper)",
                                             "mirrors' images apart",
                                             "with the visibility gradient",
                                             "HSH with gradients",
                                             "noise of as many rays"};
const float SHIFT_EXPONENT[SHIFT_EXPONENTS] = {100, 200};

/* A record for one lobe. */
struct seen {
    struct lobe lobe;
    struct eas *eas[SHIFT_HSH]; /* one list a way */
    uint32_t counts[SHIFT_HSH];
    struct hsh *hsh;
    float *harmonics;
    int order;
};

static void seen_free(struct seen *seen)
{
    for (int way = 0; way < SHIFT_HSH; way++) free(seen->eas[way]);
    hsh_free(seen->hsh);
    free(seen->harmonics);
}

/* Viewers over the hemisphere but its rim. */
static float3 viewer(int i)
{
    float z = 1 - .95f * ((float)i + .5f) / VIEWERS, r = sqrtf(1 - z * z), phi = 2.3999632f * (float)i;
    return to_world(frame_about(NORMAL), vec3(r * cosf(phi), r * sinf(phi), z));
}

/* Points in a ring about the record. */
static float3 shifted(int i)
{
    float phi = 2 * PI * ((float)i + .3f) / POINTS;
    return add(RECORD, vec3(DISTANCE * cosf(phi), 0, DISTANCE * sinf(phi)));
}

/* The samples as a way sees them: `samples` and, where the way keeps them apart, the mirrored ones after them. Returns
 * how many are mirrored. */
static uint32_t arrange(const struct gathering *g, enum shift_way way, const struct occlusion *occlusions,
                        struct gather_sample *samples)
{
    struct gather_sample *mirrored = samples + g->count;
    bool apart = way >= SHIFT_IMAGES, uncovers = way == SHIFT_TRANSLATED;
    uint32_t count = 0;
    for (uint32_t i = 0; i < g->count; i++) {
        struct gather_sample s = g->surface[i], m = g->mirrored[i];
        if (!apart) s.radiance = add(s.radiance, m.radiance);
        if (way == SHIFT_STAY) s.distance = INFINITY;
        if (uncovers) {
            s.uncovered = occlusion_uncovered(&occlusions[i], s.distance, s.omega);
            m.uncovered = occlusion_uncovered(&occlusions[i], m.distance, m.omega);
        }
        samples[i] = s;
        if (apart && !is_black(m.radiance)) mirrored[count++] = m;
    }
    return count;
}

static bool choose_eas(const struct gathering *g, const struct occlusion *occlusions, const struct mean_brdf *tables,
                       enum shift_way way, struct gather_sample *samples, struct seen *seen)
{
    static const struct select_options options = SELECT_DEFAULTS;
    struct select_place place = {
        .origin = RECORD, .frame = g->frame, .wo = viewer(40), .radius = way == SHIFT_STAY ? 0 : DISTANCE};
    struct select_scratch scratch = {0};
    struct sample_tree trees[2] = {{0}};
    uint32_t mirrored = arrange(g, way, occlusions, samples);
    seen->eas[way] = malloc((size_t)options.most * sizeof **seen->eas);
    bool good = seen->eas[way] && sample_tree_build(&trees[0], samples, g->count, g->p, g->frame) &&
                sample_tree_build(&trees[1], samples + g->count, mirrored, g->p, g->frame);
    if (good)
        seen->counts[way] = select_eas(trees, 2, tables, &seen->lobe, 1, &place, &options, &scratch, seen->eas[way]);
    select_free(&scratch);
    for (int i = 0; i < 2; i++) sample_tree_free(&trees[i]);
    return good && seen->counts[way] < UINT32_MAX;
}

static bool choose_hsh(const struct gathering *g, struct gather_sample *samples, struct seen *seen)
{
    uint32_t count = g->count + arrange(g, SHIFT_HSH, NULL, samples);
    seen->hsh = hsh_build(&seen->lobe, 1, HSH_LOSS, HARMONICS_ORDER);
    if (!seen->hsh) return false;
    seen->order = hsh_order(seen->hsh, &seen->lobe);
    seen->harmonics = calloc(hsh_floats(seen->order), sizeof *seen->harmonics);
    if (seen->harmonics) hsh_add(seen->hsh, samples, count, NORMAL, .5f * DISTANCE, seen->order, seen->harmonics);
    return seen->harmonics;
}

/* Makes the record for a lobe in every way. */
static bool see(const struct gathering *g, const struct mean_brdf *tables, struct seen *seen)
{
    struct gather_sample *samples = malloc(2 * (size_t)g->count * sizeof *samples);
    struct occlusion *occlusions = malloc(g->count * sizeof *occlusions);
    bool good = samples && occlusions;
    if (good) occlusion_of(g->surface, g->grid, g->frame, occlusions);
    for (int way = 0; good && way < SHIFT_HSH; way++)
        good = choose_eas(g, occlusions, tables, (enum shift_way)way, samples, seen);
    good = good && choose_hsh(g, samples, seen);
    free(samples);
    free(occlusions);
    return good;
}

/* Reflected luminance at x by each way. */
static void reflect_all(const struct seen *seen, const struct mean_brdf *tables, const struct gathering *fresh,
                        float3 x, float3 wo, double out[static SHIFT_WAYS])
{
    struct mean_lobe mean = mean_lobe(tables, &seen->lobe, NORMAL, wo);
    for (int way = 0; way < SHIFT_HSH; way++)
        out[way] = luminance(eas_reflect(seen->eas[way], seen->counts[way], &mean, x));
    struct hsh_view view = hsh_view(seen->hsh, &seen->lobe, NORMAL, wo);
    out[SHIFT_HSH] = luminance(hsh_reflect(seen->hsh, &view, seen->harmonics, seen->order, NORMAL, sub(x, RECORD)));
    out[SHIFT_FRESH] = luminance(gathering_reflect(fresh, &seen->lobe, wo));
}

/* What a lobe's errors add up to. */
struct sums {
    double squares[SHIFT_WAYS], exact;
};

static void add_errors(const struct seen *seen, const struct mean_brdf *tables, const struct gathering *truth,
                       const struct gathering *fresh, struct sums *sums)
{
    for (int j = 0; j < VIEWERS; j++) {
        double values[SHIFT_WAYS], exact = luminance(gathering_reflect(truth, &seen->lobe, viewer(j)));
        reflect_all(seen, tables, fresh, truth->p, viewer(j), values);
        sums->exact += exact;
        for (int way = 0; way < SHIFT_WAYS; way++) sums->squares[way] += (values[way] - exact) * (values[way] - exact);
    }
}

bool shift_measure(const struct model *model, const struct diffuse_cache *bounced,
                   struct shift_result results[static SHIFT_EXPONENTS])
{
    struct mean_brdf *tables = mean_brdf_build();
    struct gathering record, truth, fresh;
    struct seen seen[SHIFT_EXPONENTS] = {0};
    struct sums sums[SHIFT_EXPONENTS] = {0};
    bool good = gathering_make(model, bounced, RECORD, NORMAL, RECORD_RAYS, 1, &record) && tables;
    for (int k = 0; good && k < SHIFT_EXPONENTS; k++) {
        seen[k].lobe = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), SHIFT_EXPONENT[k]).lobes[0];
        good = see(&record, tables, &seen[k]);
    }
    for (uint64_t i = 0; good && i < POINTS; i++) {
        float3 x = shifted((int)i);
        good = gathering_make(model, bounced, x, NORMAL, TRUTH_RAYS, SEED_TRUTH + i, &truth);
        good = gathering_make(model, bounced, x, NORMAL, RECORD_RAYS, SEED_FRESH + i, &fresh) && good;
        for (int k = 0; good && k < SHIFT_EXPONENTS; k++) add_errors(&seen[k], tables, &truth, &fresh, &sums[k]);
        gathering_free(&truth);
        gathering_free(&fresh);
    }
    for (int k = 0; k < SHIFT_EXPONENTS; k++) {
        results[k] = (struct shift_result){0};
        for (int way = 0; way < SHIFT_WAYS; way++)
            results[k].cv[way] = sqrt(sums[k].squares[way] * POINTS * VIEWERS) / sums[k].exact;
        for (int way = 0; way < SHIFT_HSH; way++)
            results[k].bytes[way] = seen[k].counts[way] * (uint32_t)sizeof(struct eas);
        results[k].bytes[SHIFT_HSH] = hsh_floats(seen[k].order) * (uint32_t)sizeof(float);
        seen_free(&seen[k]);
    }
    gathering_free(&record);
    mean_brdf_free(tables);
    return good;
}
