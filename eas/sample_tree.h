/* SPDX-License-Identifier: Apache-2.0 */
/* The tree over a record's gather samples (paper, 6.1): the hemisphere splits into a central cap and six sectors, the
 * cap again into a cap and six sectors, a sector into four, down to single samples. Each node is an equivalent area
 * source.
 *
 * Departures: a group of black samples has its position weighed by solid angle (the paper's is 0/0); samples at
 * infinity are not mixed with others, the caller gives them a tree of their own; radiance and solid angle are kept
 * instead of irradiance, which is singular at the horizon.
 */
#ifndef EAS_SAMPLE_TREE_H
#define EAS_SAMPLE_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "eas/eas.h"

/* What one gather ray brought. */
struct gather_sample {
    float3 dir;       /* unit, from the record */
    float distance;   /* m, to what sends the light; INFINITY: from the environment */
    float3 normal;    /* of what sends it, unit, on the record's side; unused at infinity */
    rgb radiance;     /* W/m2/sr */
    float omega;      /* the solid angle it stands for, sr */
    float3 uncovered; /* share of it that a step uncovers, 1/m (occlusion.h) */
};

struct tree_node {
    struct eas eas;
    uint32_t first_child, child_count; /* children are neighbours in `nodes`; none: a leaf */
    uint32_t sample_count;
};

/* Zero-initialise, build any number of times, free once. nodes[0] is the root; no node: no samples. */
struct sample_tree {
    struct tree_node *nodes;
    uint32_t node_count, node_capacity;
    struct tree_entry *entries; /* scratch */
    uint32_t entry_capacity;
};

/* All samples finite or all at infinity. `frame` is about the record's normal, `origin` its position. False: no memory.
 */
bool sample_tree_build(struct sample_tree *tree, const struct gather_sample *samples, uint32_t count, float3 origin,
                       struct frame frame);
void sample_tree_free(struct sample_tree *tree);

#endif
