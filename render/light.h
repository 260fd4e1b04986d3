/* SPDX-License-Identifier: Apache-2.0 */
/* All that lights directly: lamps, emitting triangles and the strong part of the environment, behind one sampler.
 *
 * The environment's radiance is split: strong = max(L - threshold, 0) a channel, sampled by importance and counted as a
 * lamp; rest = L - strong, which is met by escaping rays only. A constant environment has no strong part.
 * Everything is read-only after lights_build: any thread may call.
 */
#ifndef RENDER_LIGHT_H
#define RENDER_LIGHT_H

#include "import/scene.h"
#include "render/texture.h"
#include "render/trace.h"

/* One connection from a surface point to a light. */
struct light_sample {
    float3 wi;      /* unit, to the light */
    float distance; /* INFINITY for sun and environment */
    rgb weight;     /* radiance / pdf, the choice of the light included: what f cos V is multiplied by */
    float pdf;      /* per solid angle, the choice of the light included; 0: a point that no ray can hit (no MIS) */
};

struct lights;

/* `objects` and scene->objects share indices. Borrows scene, textures and objects. */
struct lights *lights_build(const struct scene *scene, const struct textures *textures,
                            const struct trace_object *objects, char error[static SCENE_ERROR]);
void lights_free(struct lights *lights);

/* Whether there is anything to sample. */
bool lights_any(const struct lights *lights);

/* A connection from p (shading normal n; lights wholly below its horizon may be left out): u[0] chooses the light, u[1],
 * u[2] the place on it. False: nothing arrives. The caller traces the shadow ray. */
bool lights_sample(const struct lights *lights, float3 p, float3 n, const float u[static 3], struct light_sample *sample);

/* For a traced ray (from p with normal n, direction dir) that hit emitting triangle hit->triangle of hit->object: the pdf
 * with which lights_sample would have chosen it. ng: the triangle's geometric normal. */
float lights_pdf_hit(const struct lights *lights, float3 p, float3 n, float3 dir, const struct hit *hit, float3 ng);

/* Lamps with an extent (area, sphere, disc, sun) are no triangles, but a traced ray meets them all the same: radiance of
 * the nearest met before tmax by the ray, with its pdf in *pdf; 0 where none. Not for camera rays. */
rgb lights_radiance_lamps(const struct lights *lights, float3 p, float3 n, float3 dir, float tmax, float *pdf);

/* The environment seen along dir: its strong part with lights_sample's pdf, and the rest. */
rgb lights_strong(const struct lights *lights, float3 p, float3 n, float3 dir, float *pdf);
rgb lights_rest(const struct lights *lights, float3 dir);

#endif
