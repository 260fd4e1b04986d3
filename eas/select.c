/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/select.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_TREES = 3, MOST_LOBES = 2 };
#define NO_ROW UINT32_MAX
/* Half-angle of the directions about the viewer's, rad. */
#define VIEW_SPREAD .1f

/* A node that is in the selection: its reference minus its own reflected luminance in each direction, and the sum of
 * squares (epsilon_2). */
struct candidate {
    uint32_t tree, node;
    float error;
    float difference[SELECT_DIRECTIONS];
};

struct selection {
    const struct sample_tree *trees;
    const struct select_options *options;
    struct select_scratch *scratch;
    struct mean_phong_lobe lobes[MOST_LOBES];
    rgb weights[MOST_LOBES];
    int lobe_count;
    float3 n;
    /* The directions by component: the point that each is judged at, its mirror direction. */
    float px[SELECT_DIRECTIONS], py[SELECT_DIRECTIONS], pz[SELECT_DIRECTIONS];
    float mx[SELECT_DIRECTIONS], my[SELECT_DIRECTIONS], mz[SELECT_DIRECTIONS], mirror_up[SELECT_DIRECTIONS];
    uint32_t first_row[MOST_TREES]; /* of each tree's nodes in scratch->rows */
    uint32_t row_count;
    /* Over the selection: reference minus selected reflected luminance in each direction, and the reference's mean. */
    double difference[SELECT_DIRECTIONS], mean;
};

/* Which groups suffice is decided with modified Phong, whose mean over a cap is a look-up: for GGX with the lobe that
 * is as wide, at normal incidence. */
static struct lobe stand_in(const struct lobe *lobe)
{
    if (lobe->type == LOBE_PHONG) return *lobe;
    float exponent = maxf((2 / (lobe->alpha_x * lobe->alpha_y) - 2) / 4, 1);
    return (struct lobe){.type = LOBE_PHONG, .weight = mul(lobe->weight, lobe->f0), .exponent = exponent};
}

/* Reflection directions, every other one spread over the hemisphere, the rest about the viewer's, each at a point
 * spread over the zone's disc: a 4-D R sequence (Roberts 2018). */
static void queries(struct selection *s, const struct mean_brdf *tables, const struct lobe *lobes,
                    const struct select_place *place)
{
    s->n = place->frame.n;
    for (int k = 0; k < s->lobe_count; k++) {
        struct lobe lobe = stand_in(&lobes[k]);
        s->lobes[k] = mean_lobe(tables, &lobe, s->n, place->wo).phong;
        s->weights[k] = lobe.weight;
    }
    const float steps[4] = {.8566749f, .7338919f, .6287067f, .5385972f};
    for (int i = 0; i < s->options->directions; i++) {
        float u[4];
        for (int k = 0; k < 4; k++) u[k] = (float)fmod(.5 + (double)steps[k] * (i + 1), 1);
        /* z of a cap of directions: the hemisphere's but its rim, or VIEW_SPREAD about the viewer. */
        float z = 1 - u[0] * (i & 1 ? 1 - cosf(minf(VIEW_SPREAD + 2 * place->turn, 1.5f)) : .97f),
              sine = sqrtf(1 - z * z), phi = 2 * PI * u[1];
        struct frame frame = i & 1 ? frame_about(place->wo) : place->frame;
        float3 wo = to_world(frame, vec3(sine * cosf(phi), sine * sinf(phi), z)), mirror = reflect(wo, s->n);
        float r = place->radius * sqrtf(u[2]), x = r * cosf(2 * PI * u[3]), y = r * sinf(2 * PI * u[3]);
        float3 point = add(place->origin, to_world(place->frame, vec3(x, y, 0)));
        s->px[i] = point.x, s->py[i] = point.y, s->pz[i] = point.z;
        s->mx[i] = mirror.x, s->my[i] = mirror.y, s->mz[i] = mirror.z, s->mirror_up[i] = dot(mirror, s->n);
    }
}

/* The EAS as each direction sees it. */
static void seen_by(const struct selection *s, const struct eas *eas, struct mean_phong_caps *caps)
{
    static_assert((int)SELECT_DIRECTIONS <= (int)MEAN_PHONG_BLOCK, "all directions are one block of caps");
    const struct eas here = *eas;
    const float3 n = s->n;
    const int count = s->options->directions;
#pragma omp simd
    for (int i = 0; i < count; i++) {
        struct cap cap = eas_translate(&here, vec3(s->px[i], s->py[i], s->pz[i]));
        caps->omega[i] = cap.omega;
        caps->cos_mirror[i] = dot(cap.axis, vec3(s->mx[i], s->my[i], s->mz[i]));
        caps->up[i] = dot(cap.axis, n);
        caps->mirror_up[i] = s->mirror_up[i];
    }
}

/* The row of reflected luminances of a node, computed when first asked for. */
static const float *node_values(struct selection *s, uint32_t tree, uint32_t node)
{
    struct select_scratch *scratch = s->scratch;
    uint32_t directions = (uint32_t)s->options->directions, *row = &scratch->rows[s->first_row[tree] + node];
    if (*row != NO_ROW) return scratch->values + (size_t)*row * directions;
    *row = s->row_count++;
    float *values = scratch->values + (size_t)*row * directions;
    const struct eas *eas = &s->trees[tree].nodes[node].eas;
    memset(values, 0, directions * sizeof *values);
    if (is_black(eas->radiance)) return values;
    struct mean_phong_caps caps;
    seen_by(s, eas, &caps);
    for (int k = 0; k < s->lobe_count; k++) {
        float brightness = luminance(mul(eas->radiance, s->weights[k]));
        int hits = mean_phong_caps(&s->lobes[k], &caps, (int)directions);
        for (int h = 0; h < hits; h++) values[caps.hit[h]] += brightness * caps.value[caps.hit[h]];
    }
    return values;
}

/* Adds the luminances of `node`'s light `levels` down. */
static void add_reference(struct selection *s, uint32_t tree, uint32_t node, int levels, float *sum)
{
    const struct tree_node *n = &s->trees[tree].nodes[node];
    if (levels == 0 || n->child_count == 0) {
        const float *values = node_values(s, tree, node);
        for (int i = 0; i < s->options->directions; i++) sum[i] += values[i];
        return;
    }
    for (uint32_t c = 0; c < n->child_count; c++) add_reference(s, tree, n->first_child + c, levels - 1, sum);
}

/* Takes a candidate into the sums of the selection, its error (eq. 14) computed. */
static void include(struct selection *s, struct candidate *c)
{
    memset(c->difference, 0, sizeof c->difference);
    c->error = 0;
    const float *values = node_values(s, c->tree, c->node);
    add_reference(s, c->tree, c->node, s->options->levels, c->difference);
    for (int i = 0; i < s->options->directions; i++) {
        s->mean += (double)c->difference[i] / s->options->directions;
        c->difference[i] -= values[i];
        s->difference[i] += c->difference[i];
        c->error += sqr(c->difference[i]);
    }
}

static void exclude(struct selection *s, const struct candidate *c)
{
    const float *values = node_values(s, c->tree, c->node);
    for (int i = 0; i < s->options->directions; i++) {
        s->difference[i] -= c->difference[i];
        s->mean -= (double)(c->difference[i] + values[i]) / s->options->directions;
    }
}

/* Eq. 12's numerator, with the 1/m that the paper's print lacks. */
static double grouping_error(const struct selection *s)
{
    double squares = 0;
    for (int i = 0; i < s->options->directions; i++) squares += s->difference[i] * s->difference[i];
    return sqrt(squares / s->options->directions);
}

static bool grow(void **array, uint32_t *capacity, size_t count, size_t bytes)
{
    if (count <= *capacity) return true;
    void *grown = realloc(*array, count * bytes);
    if (!grown) return false;
    *array = grown;
    *capacity = (uint32_t)count;
    return true;
}

static bool prepare(struct selection *s, int tree_count)
{
    struct select_scratch *scratch = s->scratch;
    uint32_t nodes = 0;
    for (int t = 0; t < tree_count; t++) {
        s->first_row[t] = nodes;
        nodes += s->trees[t].node_count;
    }
    if (!grow((void **)&scratch->rows, &scratch->row_capacity, nodes, sizeof *scratch->rows) ||
        !grow((void **)&scratch->values, &scratch->value_capacity, (size_t)nodes * (size_t)s->options->directions,
              sizeof *scratch->values) ||
        !grow((void **)&scratch->chosen, &scratch->chosen_capacity, (size_t)s->options->most + 8,
              sizeof *scratch->chosen))
        return false;
    for (uint32_t i = 0; i < nodes; i++) scratch->rows[i] = NO_ROW;
    return true;
}

uint32_t select_eas(const struct sample_tree *trees, int count, const struct mean_brdf *tables,
                    const struct lobe *lobes, int lobe_count, const struct select_place *place,
                    const struct select_options *options, struct select_scratch *scratch, struct eas *out)
{
    struct selection s = {.trees = trees, .options = options, .scratch = scratch, .lobe_count = lobe_count};
    if (!prepare(&s, count)) return UINT32_MAX;
    queries(&s, tables, lobes, place);

    struct candidate *chosen = scratch->chosen;
    uint32_t chosen_count = 0;
    for (int t = 0; t < count; t++)
        if (trees[t].node_count) {
            chosen[chosen_count] = (struct candidate){.tree = (uint32_t)t};
            include(&s, &chosen[chosen_count++]);
        }
    while (chosen_count && grouping_error(&s) > options->tau * (place->base + s.mean)) {
        uint32_t worst = 0;
        for (uint32_t i = 1; i < chosen_count; i++)
            if (chosen[i].error > chosen[worst].error) worst = i;
        const struct tree_node *node = &trees[chosen[worst].tree].nodes[chosen[worst].node];
        if (!(chosen[worst].error > 0) || chosen_count + node->child_count - 1 > (uint32_t)options->most) break;
        uint32_t tree = chosen[worst].tree;
        exclude(&s, &chosen[worst]);
        for (uint32_t c = 0; c < node->child_count; c++) {
            struct candidate *child = c == 0 ? &chosen[worst] : &chosen[chosen_count++];
            child->tree = tree;
            child->node = node->first_child + c;
            include(&s, child);
        }
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < chosen_count; i++) {
        const struct eas *eas = &trees[chosen[i].tree].nodes[chosen[i].node].eas;
        if (!is_black(eas->radiance)) out[kept++] = *eas;
    }
    return kept;
}

void select_free(struct select_scratch *scratch)
{
    free(scratch->values);
    free(scratch->rows);
    free(scratch->chosen);
    *scratch = (struct select_scratch){0};
}
