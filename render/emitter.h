/* SPDX-License-Identifier: Apache-2.0 */
/* The emitting triangles of one object as a lamp: sampled by area times radiance, those near by by their solid
 * angle. Read-only once built. */
#ifndef RENDER_EMITTER_H
#define RENDER_EMITTER_H

#include "render/texture.h"
#include "render/trace.h"

struct emitter_triangle {
    float3 a, ab, ac; /* a corner and two edges, world, m */
    float3 normal;    /* unit, to the front */
    float area;       /* m2 */
    float edge2;      /* the square of its longest edge, m2 */
    rgb radiance;     /* W/m2/sr; the mean where it varies */
    uint32_t index;   /* among the object's triangles */
    const struct scene_material *material;
    bool front, back; /* the sides that shine */
};

enum { EMITTER_SLABS = 13 };

struct emitter {
    struct emitter_triangle *triangles;
    double *cumulative; /* chances, [count + 1] */
    uint32_t count;
    struct textures textures; /* borrowed */
    const struct trace_object *placed;
    bool mirrored;   /* ab and ac have changed places */
    uint32_t *own;   /* of each of the object's triangles: its place here, UINT32_MAX for none */
    float strength;  /* luminance of radiance x area summed, W/sr */
    bool closed;     /* a closed surface, all of which shines */
    bool front, back; /* some triangle shines from that side */
    float3 centre;   /* of a sphere about it */
    float radius, scene_radius; /* m; the scene's: trace_radius */
    float low[EMITTER_SLABS], high[EMITTER_SLABS]; /* its extents along 13 directions (a k-DOP), world */
    bool flat;                                     /* all face the same way: */
    float3 normal;                                 /* that way, and */
    float height;                                  /* the least of dot(normal, corner), m */
};

/* Gathers the emitting triangles of an object; count 0 where it has none. Borrows all that it is given. False where
 * memory runs out. */
bool emitter_build(const struct scene *scene, const struct textures *textures, const struct scene_object *object,
                   const struct trace_object *placed, float scene_radius, struct emitter *emitter);
void emitter_free(struct emitter *emitter);

/* About the irradiance (luminance) at p on a surface with normal n, shadows apart; 0 only where none can arrive. */
float emitter_irradiance(const struct emitter *emitter, float3 p, float3 n);

/* A point on the emitter seen from p: wi, distance to just before it, radiance and pdf per solid angle. False where it
 * shines the other way. u[0] chooses the triangle. */
bool emitter_sample(const struct emitter *emitter, float3 p, const float u[static 3], float3 *wi, float *distance,
                    rgb *radiance, float *pdf);

/* The pdf per solid angle with which emitter_sample chooses, seen from p, the place on a triangle (its index in the
 * object) at this distance, where rays meet it with this cosine; 0 where it does not shine. */
float emitter_pdf(const struct emitter *emitter, float3 p, uint32_t triangle, float distance, float cosine);

#endif
