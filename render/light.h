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
#include "render/environment.h"
#include "render/texture.h"
#include "render/trace.h"

/* One connection from a surface point to a light. */
struct light_sample {
    float3 wi;      /* unit, to the light */
    float distance; /* INFINITY for sun and environment */
    rgb weight;     /* radiance / pdf, the choice of the light included: what f cos V is multiplied by */
    float pdf;      /* per solid angle, the choice of the light included; 0: a point that no ray can hit (no MIS) */
    float reach;    /* how far its shadow ray goes: the distance, or 0 where nothing casts a shadow */
};

struct lights;

/* The power heuristic (Veach 1995, beta = 2) for a sample drawn with density a that b could have drawn too. */
static inline float mis_weight(float a, float b) { return a > 0 ? 1 / (1 + sqr(b / a)) : 0; }

/* `objects` and scene->objects share indices; radius is that of the scene, m. Borrows scene, textures and objects. NULL
 * and a sentence where memory runs out. */
struct lights *lights_build(const struct scene *scene, const struct textures *textures,
                            const struct trace_object *objects, float radius, char error[static SCENE_ERROR]);
void lights_free(struct lights *lights);

/* Whether there is anything to sample. */
bool lights_any(const struct lights *lights);

/* Whether the environment has a strong part: light that comes from many sides, and needs more shadow rays. */
bool lights_environment(const struct lights *lights);

/* Where all there is to sample is the environment: its strong light in at most `most` cells, the same for all points,
 * and places in them (environment_cells). 0 where there are other lights, -1 where memory runs out. */
int lights_cells(const struct lights *lights, int most, struct environment_cell *cells, float3 *places);

/* Whether some of them are points or single directions, which no ray can hit. */
bool lights_any_points(const struct lights *lights);

/* The solid angle at p, sr, of the largest of the lights that are sampled by area (meshes and area lamps), about: what
 * part of all that p sees a few samples have to stand for. */
float lights_widest(const struct lights *lights, float3 p);

/* In all that follows p is where the ray starts, already moved off its surface (trace_offset), so that a shadow ray of
 * sample.distance from p ends just before the light; n is the shading normal there: lights wholly below its horizon may
 * be left out. The same p and n must go into lights_sample and into what weighs against it. */

/* A connection from p to a light: u[0] chooses the light, u[1], u[2] the place on it. False: nothing arrives. The
 * caller traces the shadow ray. */
bool lights_sample(const struct lights *lights, float3 p, float3 n, const float u[static 3],
                   struct light_sample *sample);

/* The same for many samples at p: up to LIGHTS_WEIGHED lights are weighed there, once. */
enum { LIGHTS_WEIGHED = 64 };
struct light_weights {
    const struct lights *lights; /* borrowed */
    float3 p, n;
    float each[LIGHTS_WEIGHED], sum; /* unset where there is one light, or so many that their power chooses */
};
void lights_weigh(const struct lights *lights, float3 p, float3 n, struct light_weights *weights);
bool lights_sample_weighed(const struct light_weights *weights, const float u[static 3], struct light_sample *sample);

/* For a traced ray from p along dir that hit triangle hit->triangle of hit->object: the pdf with which lights_sample
 * would have chosen it, 0 where it does not emit. ng: the triangle's geometric normal. */
float lights_pdf_hit(const struct lights *lights, float3 p, float3 n, float3 dir, const struct hit *hit, float3 ng);

/* Lamps with an extent (area, sphere, disc, sun) are no triangles, but a traced ray meets them all the same, and they
 * hide nothing: the sum of the radiances that a ray, chosen with density pdf, meets before tmax, each weighed by
 * mis_weight against lights_sample (pdf INFINITY: in full). A lamp without shadows is met through everything. Not for
 * camera rays. *distance, where it isn't NULL: to the
 * brightest of them, unchanged where none is met. */
rgb lights_radiance_lamps(const struct lights *lights, float3 p, float3 n, float3 dir, float tmax, float pdf,
                          float *distance);

/* The radiance of the lamps that a camera ray sees before tmax. */
rgb lights_seen(const struct lights *lights, float3 eye, float3 dir, float tmax);

/* The environment seen along dir: its strong part with lights_sample's pdf, and the rest. */
rgb lights_strong(const struct lights *lights, float3 p, float3 n, float3 dir, float *pdf);
rgb lights_rest(const struct lights *lights, float3 dir);

#endif
