/* SPDX-License-Identifier: Apache-2.0 */
/* The scene format's 3 x 4 transforms, row by row, applied to points, directions and normals. */
#ifndef RENDER_TRANSFORM_H
#define RENDER_TRANSFORM_H

#include "eas/vec.h"

static inline float3 transform_point(const float m[static 12], float3 p)
{
    return vec3(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}

/* Column i: where the transform takes the local axis i; 3: where it takes the origin. */
static inline float3 transform_column(const float m[static 12], int i) { return vec3(m[i], m[4 + i], m[8 + i]); }

/* The rows of the cofactors; their product with row 0 is the determinant. */
static inline void transform_cofactors(const float m[static 12], float3 rows[static 3])
{
    float3 a = vec_from(m), b = vec_from(m + 4), c = vec_from(m + 8);
    rows[0] = cross(b, c);
    rows[1] = cross(c, a);
    rows[2] = cross(a, b);
}

static inline float transform_determinant(const float m[static 12])
{
    float3 rows[3];
    transform_cofactors(m, rows);
    return dot(vec_from(m), rows[0]);
}

/* By the inverse transpose, not unit any more. Under mirroring it stays on the side that the local normal shows, which
 * is where Cycles sees a face's front. */
static inline float3 transform_normal(const float m[static 12], float3 n)
{
    float3 rows[3];
    transform_cofactors(m, rows);
    return scale(vec3(dot(rows[0], n), dot(rows[1], n), dot(rows[2], n)), copysignf(1, dot(vec_from(m), rows[0])));
}

#endif
