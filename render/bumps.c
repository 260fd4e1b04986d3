/* SPDX-License-Identifier: Apache-2.0 */
#include "render/bumps.h"

/* The least change of uv that heights are compared over: less would drown in rounding. */
#define LEAST_CHANGE 1e-4f

struct uv_axes uv_axes(const float3 corners[static 3], const float2 uvs[static 3])
{
    float3 ab = sub(corners[1], corners[0]), ac = sub(corners[2], corners[0]);
    float2 b = {uvs[1].x - uvs[0].x, uvs[1].y - uvs[0].y}, c = {uvs[2].x - uvs[0].x, uvs[2].y - uvs[0].y};
    float determinant = b.x * c.y - c.x * b.y;
    if (!(fabsf(determinant) > 1e-20f)) return (struct uv_axes){0};
    return (struct uv_axes){scale(mad(scale(ab, c.y), ac, -b.y), 1 / determinant),
                            scale(mad(scale(ac, b.x), ab, -c.x), 1 / determinant)};
}

/* Tangent, bitangent and normal of the mesh's own front; the map's blue is kept from below as Cycles mixes it. */
static float3 mapped(rgb c, const struct scene_normal *bumps, const struct texture_place *place,
                     const struct uv_axes *axes, float3 n)
{
    float3 own = place->front ? n : scale(n, -1), tangent = mad(axes->du, own, -dot(axes->du, own));
    if (!(dot(tangent, tangent) > 0)) return n;
    tangent = normalize(tangent);
    float3 across = cross(own, tangent);
    if (dot(across, axes->dv) < 0) across = scale(across, -1); /* mirrored uv */
    float x = (2 * c.x - 1) * bumps->strength, y = (2 * c.y - 1) * bumps->strength, z = 2 * c.z - 1;
    z = 1 + (z - 1) * minf(bumps->strength, 1);
    float3 bent = mad(mad(scale(tangent, x), across, y), own, z);
    if (!(dot(bent, bent) > 0)) return n;
    return scale(normalize(bent), place->front ? 1 : -1);
}

static float height(const struct textures *textures, const struct scene_normal *bumps, struct texture_place place,
                    float du, float dv)
{
    place.uv.x += du;
    place.uv.y += dv;
    rgb c = texture_lookup(textures, bumps->texture, &place);
    return (c.x + c.y + c.z) / 3;
}

/* How fast the height grows along a direction in the surface, per metre. */
static float slope(const struct textures *textures, const struct scene_normal *bumps, const struct texture_place *place,
                   const struct uv_axes *axes, float3 along, float step, float here)
{
    /* The changes a, b of uv with a du + b dv = along, by least squares: along may leave the triangle's plane. */
    float uu = dot(axes->du, axes->du), uv = dot(axes->du, axes->dv), vv = dot(axes->dv, axes->dv);
    float determinant = uu * vv - uv * uv, u = dot(along, axes->du), v = dot(along, axes->dv);
    if (!(determinant > 0)) return 0;
    float a = (vv * u - uv * v) / determinant, b = (uu * v - uv * u) / determinant, size = sqrtf(a * a + b * b);
    if (!(size > 0)) return 0;
    step = maxf(step, LEAST_CHANGE / size);
    return (height(textures, bumps, *place, a * step, b * step) - here) / step;
}

/* The directions that Cycles compares heights along, in the triangle's plane: where pictures are coarse, or not
 * interpolated, the bend depends on them. */
static struct frame directions(const struct uv_axes *axes, float3 n)
{
    float3 ng = normalize(cross(axes->du, axes->dv)), along;
    if (dot(ng, n) < 0) ng = scale(ng, -1);
    along = cross(vec3(1, 1, 1), ng);
    if (!(dot(along, along) > 1e-12f)) along = cross(vec3(1, 1, -1), ng);
    along = normalize(along);
    return (struct frame){along, cross(ng, along), ng};
}

/* The normal of the surface moved along n by the height (Mikkelsen 2010), mixed with n. */
static float3 raised(const struct textures *textures, const struct scene_normal *bumps,
                     const struct texture_place *place, const struct uv_axes *axes, float3 n, float step)
{
    float3 area = cross(axes->du, axes->dv);
    if (!(dot(area, area) > 0)) return n;
    struct frame frame = directions(axes, n);
    float here = height(textures, bumps, *place, 0, 0), distance = bumps->invert ? -bumps->distance : bumps->distance;
    float x = slope(textures, bumps, place, axes, frame.t, step, here);
    float y = slope(textures, bumps, place, axes, frame.b, step, here);
    float3 gradient = mad(scale(cross(frame.b, n), x), cross(n, frame.t), y);
    float3 bent = normalize(mad(scale(n, dot(n, frame.n)), gradient, -distance));
    bent = mad(scale(bent, bumps->strength), n, 1 - bumps->strength);
    return dot(bent, bent) > 0 ? normalize(bent) : n;
}

float3 bumps_normal(const struct textures *textures, const struct scene_normal *bumps,
                    const struct texture_place *place, const struct uv_axes *axes, float3 n, float step)
{
    if (bumps->type == NORMAL_MAP)
        return mapped(texture_lookup(textures, bumps->texture, place), bumps, place, axes, n);
    return raised(textures, bumps, place, axes, n, step);
}
