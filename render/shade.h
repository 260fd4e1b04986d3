/* SPDX-License-Identifier: Apache-2.0 */
/* What a ray finds: position, normals and material at a hit. */
#ifndef RENDER_SHADE_H
#define RENDER_SHADE_H

#include "eas/brdf.h"
#include "render/model.h"

struct point {
    float3 p;                  /* world, on the triangle */
    float3 origin;             /* p moved off the triangle: rays leave here, and lights are asked from here */
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

/* How the shading normal turns along the point's triangle, 1/m: the mean curvature, positive where the surface bulges
 * toward the viewer, and in *steepest the most along any of its edges. A flat triangle has none. */
float shade_curvature(const struct model *model, const struct point *point, float *steepest);

/* Direct light from lamps at a point by one lights_sample with its shadow ray, weighed against BRDF sampling where mis
 * is true: radiance toward wo. u: three numbers in [0, 1). */
rgb shade_direct(const struct model *model, const struct point *point, const float u[static 3], bool mis);

#endif
