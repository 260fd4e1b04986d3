/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles as a point sees them. By area, a point beside a large lamp gets most of its light from few of its samples;
 * by solid angle each brings the same. */
#ifndef RENDER_SOLID_ANGLE_H
#define RENDER_SOLID_ANGLE_H

#include "eas/vec.h"

/* A triangle from the point where it is seen from: a corner and two edges. */
struct seen_triangle {
    float3 a, ab, ac;
};

/* Its solid angle, sr; from either side. */
float solid_angle(const struct seen_triangle *t);

/* Chooses a place on it, how far along ab and ac, so that its direction is spread evenly over `omega`, the triangle's
 * solid angle, > 0; u: two numbers in [0, 1). */
float2 solid_angle_place(const struct seen_triangle *t, float omega, const float u[static 2]);

#endif
