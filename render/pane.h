/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces that let a share of light pass straight on (brdf.through): panes, veils, cut-outs. Any thread may call. */
#ifndef RENDER_PANE_H
#define RENDER_PANE_H

#include "render/rng.h"
#include "render/shade.h"

/* The share of light that comes through from (0, tfar) along a ray: white where nothing lies there, black where
 * anything opaque does, or glass. */
rgb pane_transmittance(const struct model *model, float3 origin, float3 dir, float tfar);

/* The same for up to a thousand rays, which cost far less together. */
void pane_transmittances(const struct model *model, const struct shadow_ray *rays, int count, rgb *through);

/* Whether a path that has met a surface goes straight on, by chance; if not, it meets the rest of the surface. *weight
 * is multiplied by what the choice is worth. No random number is drawn at opaque ones. */
static inline bool pane_pass(const struct point *point, struct rng *rng, rgb *weight)
{
    if (is_black(point->brdf.through)) return false;
    float chance = brdf_pass_chance(&point->brdf, dot(point->n, point->wo));
    bool passes = rng_float(rng) < chance;
    *weight = passes ? mul(*weight, scale(point->brdf.through, 1 / chance)) : scale(*weight, 1 / (1 - chance));
    return passes;
}

#endif
