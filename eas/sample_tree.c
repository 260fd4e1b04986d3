/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/sample_tree.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { SECTORS = 6, QUARTERS = 4, MAX_DEPTH = 24 };

/* A sample on its way through the tree: z = cos(theta) and phi in the record's frame. */
struct tree_entry {
    float z, phi;
    uint32_t sample, child;
};

/* Part of the hemisphere: z0 < z <= z1, phi0 <= phi < phi1. A cap where the whole circle and z1 = 1 are in it. */
struct cell {
    float z0, z1, phi0, phi1;
    bool cap;
};

static uint32_t child_of(struct cell cell, float z, float phi)
{
    if (cell.cap) {
        float inner = cell.z1 - (cell.z1 - cell.z0) / (SECTORS + 1); /* equal solid angles */
        if (z > inner) return 0;
        uint32_t sector = (uint32_t)(phi * (SECTORS / (2 * PI)));
        return 1 + (sector < SECTORS ? sector : SECTORS - 1);
    }
    return (z > .5f * (cell.z0 + cell.z1) ? 1 : 0) + (phi >= .5f * (cell.phi0 + cell.phi1) ? 2 : 0);
}

static struct cell child_cell(struct cell cell, uint32_t child)
{
    if (cell.cap) {
        float inner = cell.z1 - (cell.z1 - cell.z0) / (SECTORS + 1);
        if (child == 0) return (struct cell){inner, cell.z1, 0, 2 * PI, true};
        return (struct cell){cell.z0, inner, (float)(child - 1) * (2 * PI / SECTORS), (float)child * (2 * PI / SECTORS),
                             false};
    }
    float z = .5f * (cell.z0 + cell.z1), phi = .5f * (cell.phi0 + cell.phi1);
    return (struct cell){child & 1 ? z : cell.z0, child & 1 ? cell.z1 : z, child & 2 ? phi : cell.phi0,
                         child & 2 ? cell.phi1 : phi, false};
}

/* The EAS of a set of samples: means of position and normal weighed by luminance x solid angle, by solid angle where
 * all is black, or as good as. */
static struct eas summarise(const struct gather_sample *samples, const struct tree_entry *entries, uint32_t count,
                            float3 origin)
{
    rgb power = {0};
    float3 uncovered = {0};
    float3 position[2] = {{0}}, normal[2] = {{0}};
    float omega = 0, weight[2] = {0};
    bool infinite = isinf(samples[entries[0].sample].distance);
    for (uint32_t i = 0; i < count; i++) {
        const struct gather_sample *s = &samples[entries[i].sample];
        float3 p = infinite ? s->dir : mad(origin, s->dir, s->distance);
        float w[2] = {luminance(s->radiance) * s->omega, s->omega};
        for (int k = 0; k < 2; k++) {
            position[k] = mad(position[k], p, w[k]);
            normal[k] = mad(normal[k], s->normal, w[k]);
            weight[k] += w[k];
        }
        omega += s->omega;
        uncovered = mad(uncovered, s->uncovered, s->omega);
        power = mad(power, s->radiance, s->omega);
    }
    int k = weight[0] >= FLT_MIN ? 0 : 1; /* below it 1 / weight overflows */
    struct eas eas =
        eas_make(origin, scale(position[k], 1 / weight[k]), normal[k], scale(power, 1 / omega), omega, infinite);
    eas.uncovered = scale(uncovered, 1 / omega);
    eas.visible = 1 - dot(eas.uncovered, origin);
    return eas;
}

static bool reserve(struct sample_tree *tree, uint32_t more)
{
    uint32_t need = tree->node_count + more;
    if (need <= tree->node_capacity) return true;
    uint32_t capacity = need * 2;
    struct tree_node *nodes = realloc(tree->nodes, capacity * sizeof *nodes);
    if (!nodes) return false;
    tree->nodes = nodes;
    tree->node_capacity = capacity;
    return true;
}

/* Splits entries[0 .. count) of `cell` below `node`; cells with all samples in one child are passed through. */
static bool split(struct sample_tree *tree, uint32_t node, const struct gather_sample *samples,
                  struct tree_entry *entries, uint32_t count, float3 origin, struct cell cell, int depth)
{
    uint32_t counts[SECTORS + 2] = {0};
    uint32_t children = cell.cap ? SECTORS + 1 : QUARTERS;
    if (count <= 1) return true;
    for (; depth < MAX_DEPTH; depth++) {
        memset(counts, 0, sizeof counts);
        for (uint32_t i = 0; i < count; i++) counts[entries[i].child = child_of(cell, entries[i].z, entries[i].phi)]++;
        if (counts[entries[0].child] < count) break;
        cell = child_cell(cell, entries[0].child);
        children = cell.cap ? SECTORS + 1 : QUARTERS;
    }
    if (depth == MAX_DEPTH) return true; /* samples of one direction: a leaf of several */
    /* Bring each child's entries together, their order kept: an insertion of runs is cheap for so few children. */
    uint32_t begin = 0, occupied = 0;
    for (uint32_t c = 0; c < children; c++) {
        uint32_t at = begin;
        for (uint32_t i = begin; i < count; i++)
            if (entries[i].child == c) {
                struct tree_entry swap = entries[at];
                entries[at] = entries[i];
                entries[i] = swap;
                at++;
            }
        occupied += counts[c] > 0;
        begin = at;
    }
    if (!reserve(tree, occupied)) return false;
    uint32_t first = tree->node_count, next = first;
    tree->node_count += occupied;
    tree->nodes[node].first_child = first;
    tree->nodes[node].child_count = occupied;
    begin = 0;
    for (uint32_t c = 0; c < children; c++) {
        if (!counts[c]) continue;
        tree->nodes[next] = (struct tree_node){.eas = summarise(samples, entries + begin, counts[c], origin),
                                               .sample_count = counts[c]};
        if (!split(tree, next, samples, entries + begin, counts[c], origin, child_cell(cell, c), depth + 1))
            return false;
        begin += counts[c];
        next++;
    }
    return true;
}

bool sample_tree_build(struct sample_tree *tree, const struct gather_sample *samples, uint32_t count, float3 origin,
                       struct frame frame)
{
    tree->node_count = 0;
    if (!count) return true;
    if (count > tree->entry_capacity) {
        struct tree_entry *entries = realloc(tree->entries, count * sizeof *entries);
        if (!entries) return false;
        tree->entries = entries;
        tree->entry_capacity = count;
    }
    for (uint32_t i = 0; i < count; i++) {
        float3 local = to_local(frame, samples[i].dir);
        float phi = atan2f(local.y, local.x);
        tree->entries[i] = (struct tree_entry){local.z, phi < 0 ? phi + 2 * PI : phi, i, 0};
    }
    if (!reserve(tree, 1)) return false;
    tree->node_count = 1;
    tree->nodes[0] = (struct tree_node){.eas = summarise(samples, tree->entries, count, origin), .sample_count = count};
    return split(tree, 0, samples, tree->entries, count, origin, (struct cell){0, 1, 0, 2 * PI, true}, 0);
}

void sample_tree_free(struct sample_tree *tree)
{
    free(tree->nodes);
    free(tree->entries);
    *tree = (struct sample_tree){0};
}
