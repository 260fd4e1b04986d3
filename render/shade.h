/* SPDX-License-Identifier: Apache-2.0 */
/* What a ray finds: position, normals and material at a hit. */
#ifndef RENDER_SHADE_H
#define RENDER_SHADE_H

#include "eas/brdf.h"
#include "render/model.h"

struct point {
    float3 p;        /* world, on the triangle */
    float3 n;        /* shading normal, on the viewer's side (n.wo > 0) */
    float3 ng;       /* geometric normal, on the viewer's side */
    float3 wo;       /* to the viewer */
    rgb emission;    /* radiance toward the viewer, W/m2/sr */
    int material;    /* index of the scene's material, SCENE_NONE: the default one */
    uint32_t object; /* index of the object */
    bool front;      /* the viewer is on the triangle's front */
    struct brdf brdf;
};

/* The point where `ray` hit. As Cycles: a smooth normal that faces away from the viewer is pulled to its horizon. */
void shade_point(const struct model *model, struct ray ray, const struct hit *hit, struct point *point);

/* Direct light from lamps at a point by one lights_sample with the shadow ray, weighed against BRDF sampling where mis is true. rgb
 * radiance toward wo. u: three numbers. */
rgb shade_direct(const struct model *model, const struct point *point, const float u[static 3], bool mis);

/* The power heuristic (Veach 1995, beta = 2). */
static inline float mis_weight(float a, float b) { return a * a / (a * a + b * b); }

#endif
