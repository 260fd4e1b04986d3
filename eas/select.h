/* SPDX-License-Identifier: Apache-2.0 */
/* Which nodes of a record's trees become its EAS (paper, 6.2): from the roots down, the node of the largest error is
 * replaced by its children until the whole errs by less than tau.
 *
 * Departure: each error is measured at a point of the record's zone of its own instead of at the record alone, so that
 * a group whose samples lie at different depths, on different objects or on an edge is split where that shows from the
 * zone. It stands for the rule "clusters don't mix objects or depths" without knowing objects.
 */
#ifndef EAS_SELECT_H
#define EAS_SELECT_H

#include "eas/sample_tree.h"

struct select_options {
    float tau;      /* the grouping error epsilon_1 to go below: CV(RMSE) of reflected radiance */
    int levels;     /* K: the reference of a node is its light this many levels down */
    int directions; /* m: reflection directions (each at a point of the zone), at most SELECT_DIRECTIONS */
    int most;       /* no more EAS than this */
};

enum { SELECT_DIRECTIONS = 128 };
#define SELECT_DEFAULTS                                                                                                \
    {                                                                                                                  \
        .tau = .015f, .levels = 2, .directions = 96, .most = 600                                                       \
    }

/* Scratch; zero-initialise, use by one thread at a time, free once. */
struct select_scratch {
    float *values;  /* reflected luminance: a row of directions for each node met */
    uint32_t *rows; /* the row of each node, or none */
    uint32_t value_capacity, row_capacity;
    struct candidate *chosen;
    uint32_t chosen_capacity;
};

/* Where a record stands. */
struct select_place {
    float3 origin;
    struct frame frame; /* about its normal */
    float3 wo;          /* to the viewer that asked for the record: half of the directions lie about it */
    float radius;       /* of its zone, m */
    float turn;         /* of the normal within the zone, rad: on a curved surface the mirror directions spread */
    float base;         /* luminance that it reflects besides (its diffuse part), which the error is relative to, too */
};

/* Chooses from `count` trees for a record under `lobes`. Writes at most options->most EAS to `out` and returns how
 * many; none where all is black. UINT32_MAX: no memory. */
uint32_t select_eas(const struct sample_tree *trees, int count, const struct mean_brdf *tables,
                    const struct lobe *lobes, int lobe_count, const struct select_place *place,
                    const struct select_options *options, struct select_scratch *scratch, struct eas *out);

void select_free(struct select_scratch *scratch);

#endif
