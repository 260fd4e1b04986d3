/* SPDX-License-Identifier: Apache-2.0 */
/* What a ray finds: position, normals and material at a hit. */
#ifndef RENDER_SHADE_H
#define RENDER_SHADE_H

#include "eas/brdf.h"
#include "render/model.h"

struct point {
    float3 p;                  /* world, on the triangle */
    float3 origin;             /* p moved off the triangle: rays leave here, and lights are asked from here */
    float3 beyond;             /* the same on the other side */
    float3 n;                  /* shading normal, on ng's side; n.wo > 0 unless the surface is diffuse alone */
    float3 ng;                 /* geometric normal, on the viewer's side */
    float3 wo;                 /* to the viewer */
    rgb emission;              /* radiance toward the viewer, W/m2/sr */
    int material;              /* index of the scene's material, SCENE_NONE: the default one */
    uint32_t object, triangle; /* their indices */
    bool front;                /* the viewer is on the triangle's front */
    struct brdf brdf;
};

/* The point where `ray` hit. As Cycles: on a glossy surface a smooth normal whose mirror direction would go into the
 * surface is pulled toward ng until it does not (there Cycles leaves the diffuse part its own normal; here it shares).
 */
void shade_point(const struct model *model, struct ray ray, const struct hit *hit, struct point *point);

/* Whether light may pass straight through the surface that was hit; much cheaper than shade_point. */
bool shade_may_pass(const struct model *model, const struct hit *hit);

/* Where a ray leaves a point along dir, on either side of the surface. */
static inline float3 shade_origin(const struct point *point, float3 dir)
{
    return dot(point->ng, dir) >= 0 ? point->origin : point->beyond;
}

/* How the shading normal turns along the point's triangle, 1/m: the mean curvature, positive where the surface bulges
 * toward the viewer, and in *steepest the most along any of its edges. A flat triangle has none. */
float shade_curvature(const struct model *model, const struct point *point, float *steepest);

/* A side of a surface: where rays leave it, its normals. */
struct side {
    float3 origin, n, ng;
};

/* The viewer's side, or the one beyond. */
static inline struct side shade_side(const struct point *point, bool beyond)
{
    if (!beyond) return (struct side){point->origin, point->n, point->ng};
    float3 ng = scale(point->ng, -1);
    return (struct side){point->beyond, scale(point->n, -1), ng};
}

/* Direct light from lamps at a point by one lights_sample with its shadow ray on the viewer's side and, where the
 * surface transmits, one beyond; weighed against BRDF sampling where mis is true: radiance toward wo. u: three numbers
 * in [0, 1). */
rgb shade_direct(const struct model *model, const struct point *point, const float u[static 3], bool mis);

#endif
