/* SPDX-License-Identifier: Apache-2.0 */
/* The path tracer: the unbiased reference of everything else. */
#ifndef RENDER_PATH_H
#define RENDER_PATH_H

#include "render/sequence.h"
#include "render/shade.h"

/* A camera ray's radiance in the parts that the AOVs hold; Combined = emission + direct + indirect. Background counts
 * as emission. */
struct radiance {
    rgb emission; /* from what the camera sees itself */
    rgb direct;   /* lamps (mesh emitters and strong environment among them) lighting what it sees */
    rgb indirect; /* all else */
};

/* One path: next-event estimation and BRDF sampling with multiple importance sampling at each hit, Russian roulette
 * from the fourth bounce on. `first` is the hit of the camera ray, already shaded. `spread`: where the first bounces
 * take their directions from; NULL: all are independent. */
struct radiance path_radiance(const struct model *model, const struct point *first, struct picture_sequence *spread,
                              struct rng *rng);

/* What arrives along a ray from a surface point p with normal n by all but lamps directly (their direct light is the
 * caller's): used where the diffuse cache has nothing. */
rgb path_incident(const struct model *model, struct ray ray, struct rng *rng);

#endif
