/* SPDX-License-Identifier: Apache-2.0 */
/* The visibility gradient: how much of what a record sees comes out from behind nearer things, or goes behind them, as
 * one moves away from the record. The paper takes visibility as constant in a zone (6.4) and leaves this to the future.
 *
 * Where neighbouring strata lie at different depths and no surface leads from one to the other, the nearer hides the
 * farther, and a step s moves that edge against what lies behind it by s (1/near - 1/far). The solid angle of a far
 * sample so changes by s times
 *
 *     sum over its stratum's edges of  length * away * (1/near - 1/far),    away: unit, across the edge, off the nearer
 *
 * which is the stratified gradient of Ward and Heckbert 1992, and of Křivánek and Gautron 2009 (2.3.2), kept for each
 * direction instead of summed over all. World space, metres, rad; values only: any thread may call.
 */
#ifndef EAS_OCCLUSION_H
#define EAS_OCCLUSION_H

#include "eas/irradiance.h"

/* The edges about a stratum behind which it lies. All 0 where nothing hides it. */
struct occlusion {
    float3 length;   /* sum of length * away, rad */
    float3 nearness; /* the same over the distance of what hides, rad/m */
    float hider;     /* m, the farthest of those distances */
};

/* For each of grid.rows x grid.columns strata, from a sample in each about `frame`. */
void occlusion_of(const struct gather_sample *samples, struct gather_grid grid, struct frame frame,
                  struct occlusion *occlusions);

/* What a sample at `distance` in the stratum, whose solid angle is omega, has uncovered by a step: share of its solid
 * angle a metre. */
static inline float3 occlusion_uncovered(const struct occlusion *occlusion, float distance, float omega)
{
    if (!(distance > occlusion->hider)) return vec3(0, 0, 0); /* one of those that hide */
    return scale(mad(occlusion->nearness, occlusion->length, -1 / distance), 1 / omega);
}

#endif
