/* SPDX-License-Identifier: Apache-2.0 */
/* The lamps of import/FORMAT.md as radiance on simple shapes: how one lights a point, how a ray meets it.
 *
 * Points and spots are spheres (sampled by the cone they subtend) or discs turned to whoever looks, or single points;
 * area lamps are rectangles or ellipses that shine from one side (sampled by area); suns are cones of directions.
 * Pure functions of a struct that never changes once made.
 */
#ifndef RENDER_LAMP_H
#define RENDER_LAMP_H

#include "eas/vec.h"
#include "import/scene.h"

struct lamp {
    enum light_type type;
    enum light_shape shape;
    float3 centre;     /* m */
    float3 axis;       /* unit; SPOT, AREA: where it shines; SUN: toward the sun */
    float3 u, v;       /* AREA: half its extents, m */
    rgb radiance;      /* W/m2/sr; of a point W/sr; of a sun without an angle its irradiance, W/m2 */
    float radius;      /* POINT, SPOT: m, 0: a point; AREA: of the circle about it */
    float area;        /* AREA: m2 */
    float cos_cone;    /* SPOT: cosine of half the opening */
    float soft;        /* SPOT: 1 / width of the soft border, in cosines */
    float tan_spread;  /* AREA: tangent of half the spread; INFINITY: all directions */
    float spread_norm; /* AREA: keeps the power under a spread */
    float cone;        /* SUN: 1 - cos of half the angle; 0: a single direction */
    bool seen;         /* by camera rays */
    bool shadowless;   /* nothing casts a shadow in its light */
};

/* One connection: wi unit, distance (INFINITY for a sun), pdf per solid angle; 0 marks a point or a single direction,
 * whose `radiance` is then irradiance on a surface that faces it. */
struct lamp_sample {
    float3 wi;
    float distance, pdf;
    rgb radiance;
};

/* False where the lamp gives no light (no power, no area). */
bool lamp_make(const struct scene_light *light, struct lamp *lamp);

/* Whether it has no extent: no ray can hit it. */
bool lamp_is_point(const struct lamp *lamp);

/* About the irradiance (luminance) at p on a surface with normal n, shadows apart; 0 only where none can arrive. */
float lamp_irradiance(const struct lamp *lamp, float3 p, float3 n);

/* Luminous power, W; a sun's through a disc of the given radius. */
float lamp_power(const struct lamp *lamp, float radius);

/* False where nothing arrives at p by this sample. */
bool lamp_sample(const struct lamp *lamp, float3 p, float3 n, const float u[static 2], struct lamp_sample *sample);

/* Whether the ray from p meets the lamp before *t: radiance and lamp_sample's pdf, and in *t where it does. */
bool lamp_meet(const struct lamp *lamp, float3 p, float3 n, float3 dir, float *t, rgb *radiance, float *pdf);

#endif
