/* SPDX-License-Identifier: Apache-2.0 */
/* Points spread evenly over all surfaces of a scene, on both sides, for a fill that serves any camera. */
#ifndef RENDER_SURFACES_H
#define RENDER_SURFACES_H

#include "render/shade.h"

struct surfaces {
    const struct model *model; /* borrowed */
    double *reach;             /* area of all triangles up to and with each, m2; objects in the scene's order */
    size_t *first;             /* triangle of each object in `reach`, and the count at the end */
};

/* The cross product of two sides of a triangle, world space: along its geometric normal, twice its area long. */
float3 surfaces_across(const struct trace_object *object, uint32_t triangle);

/* The first of `count` growing numbers that is beyond `at`, or the last. */
size_t surfaces_find(const double *reach, size_t count, double at);

/* False: no memory; nothing to free then. */
bool surfaces_build(const struct model *model, struct surfaces *surfaces);
void surfaces_free(struct surfaces *surfaces);

/* Place i / 2 of a sequence of low discrepancy by area, on its front (i even) or its back, seen along the normal. False
 * where there is nothing to choose from. Any thread may call. */
bool surfaces_point(const struct surfaces *surfaces, uint32_t i, struct point *point);

/* Whether somebody outside of closed bodies could see the point: random walks from there get out of the scene or where
 * the camera sees them. (seed, i) choose the random numbers. Any thread may call. */
bool surfaces_open(const struct surfaces *surfaces, const struct point *point, uint64_t seed, uint32_t i);

#endif
