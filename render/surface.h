/* SPDX-License-Identifier: Apache-2.0 */
/* What a material is at a place of a surface: its closures as one reflectance, its emission. Any thread may ask. */
#ifndef RENDER_SURFACE_H
#define RENDER_SURFACE_H

#include "eas/brdf.h"
#include "render/texture.h"
#include "render/trace.h"

/* uv of a place of a triangle, 0 where the mesh has none; u, v: barycentric. */
float2 surface_uv(const struct triangles *triangles, uint32_t triangle, float u, float v);

/* The mesh's shading normal there, unit, world space; 0 where it has none. */
float3 surface_normal(const struct trace_object *placed, uint32_t triangle, float u, float v);

/* *brdf: the sum of the closures on the viewer's side. n: shading normal; wo: to the viewer, n.wo > 0 where the material
 * is glossy; tangent: along increasing u, of any length, 0 where there is none. */
void surface_brdf(const struct textures *textures, const struct scene_material *material,
                  const struct texture_place *place, float3 n, float3 wo, float3 tangent, struct brdf *brdf);

/* Radiance toward the viewer, W/m2/sr. */
static inline rgb surface_emission(const struct textures *textures, const struct scene_material *material,
                                   const struct texture_place *place)
{
    if (place->front ? !material->emission_front : !material->emission_back) return (rgb){0};
    return texture_colour(textures, &material->emission, place);
}

/* Whether some closure needs a shading normal that wo sees: any but a diffuse or transparent one. */
bool surface_is_glossy(const struct scene_material *material);

/* Whether some closure has a direction along the surface. */
bool surface_has_tangent(const struct scene_material *material);

/* Whether light may go straight through somewhere: without it `through` is 0 everywhere. */
bool surface_may_pass(const struct scene_material *material);

#endif
