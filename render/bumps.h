/* SPDX-License-Identifier: Apache-2.0 */
/* Shading normals bent by a texture: tangent-space normal maps and heights, as Cycles 4.5's Normal Map and Bump. */
#ifndef RENDER_BUMPS_H
#define RENDER_BUMPS_H

#include "render/texture.h"

/* How a triangle's uv lie on it, world space: p moves by du x (change of u) + dv x (change of v). All 0 where uv are no
 * map of the triangle. */
struct uv_axes {
    float3 du, dv;
};

struct uv_axes uv_axes(const float3 corners[static 3], const float2 uvs[static 3]);

/* The bent normal, unit, at a place where the mesh's is n (unit, on the viewer's side). step: m, over which heights are
 * compared. n itself where uv are no map. */
float3 bumps_normal(const struct textures *textures, const struct scene_normal *bumps,
                    const struct texture_place *place, const struct uv_axes *axes, float3 n, float step);

#endif
