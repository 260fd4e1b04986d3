/* SPDX-License-Identifier: Apache-2.0 */
/* Rays against triangles: the one file that sees Embree.
 *
 * Built once by one thread; any number of threads may then trace. Meshes used by one object stand in world space;
 * shared ones are instanced. Ties are the same for any number of threads: the BVH is built on one thread.
 */
#ifndef RENDER_TRACE_H
#define RENDER_TRACE_H

#include <stdint.h>

#include "eas/vec.h"
#include "import/tessellate.h"

/* One object's triangles for tracing. */
struct trace_object {
    const struct triangles *triangles; /* borrowed: must outlive the trace */
    float transform[12];               /* object to world; identity where the triangles stand in world space */
    bool instanced;
    bool hidden;     /* camera rays pass it */
    bool shadowless; /* shadow rays pass it */
};

struct hit {
    float t;         /* distance along the unit ray */
    uint32_t object; /* index of the trace_object */
    uint32_t triangle;
    float u, v; /* barycentric: vertex 1, vertex 2 */
};

struct trace;

/* NULL and a sentence where memory runs out. */
struct trace *trace_build(const struct trace_object *objects, uint32_t count, char error[static SCENE_ERROR]);
void trace_free(struct trace *trace);

/* The nearest hit with t in (0, tfar); false where there is none. Rays leave surfaces through trace_offset. */
bool trace_closest(const struct trace *trace, float3 origin, float3 dir, float tfar, struct hit *hit);

/* The same for a ray from the camera, and for one that looks for what casts a shadow. */
bool trace_camera(const struct trace *trace, float3 origin, float3 dir, float tfar, struct hit *hit);
bool trace_caster(const struct trace *trace, float3 origin, float3 dir, float tfar, struct hit *hit);

/* Whether anything that casts a shadow lies in (0, tfar). */
bool trace_occluded(const struct trace *trace, float3 origin, float3 dir, float tfar);

/* A ray that asks for no more than whether anything lies in (0, tfar). */
struct shadow_ray {
    float3 origin, dir;
    float tfar;
};

/* trace_occluded for each of many rays, which cost far less together where neighbours in the array lie close. */
void trace_shadows(const struct trace *trace, const struct shadow_ray *rays, int count, bool *occluded);

/* p moved off its surface along the geometric normal ng (on the side where the ray leaves) by a few of its own ulps.
 * Wächter and Binder, Ray Tracing Gems, chapter 6. radius: trace_radius, by which it is less in scenes below 1 m. */
float3 trace_offset(float3 p, float3 ng, float radius);

/* Half the diagonal of the box about all objects, m; 0 for none. */
float trace_radius(const struct trace *trace);

/* Rays traced so far by all threads: closest + occluded. Call it when none is tracing. */
uint64_t trace_rays(const struct trace *trace);

#endif
