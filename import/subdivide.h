/* SPDX-License-Identifier: Apache-2.0 */
/* Cages to the limit surface; subdivide.cpp alone sees OpenSubdiv. */
#ifndef IMPORT_SUBDIVIDE_H
#define IMPORT_SUBDIVIDE_H

#include <stdbool.h>
#include <stdint.h>

#include "import/scene.h"

/* A refined cage: quads whose vertices are (position, normal, uv) triples. */
struct subdivided {
    uint32_t vertex_count, quad_count;
    float *positions; /* 3 a vertex, on the limit surface */
    float *normals;  /* 3 a vertex, unit, of the limit surface; NULL where the cage isn't smooth. Infinitely sharp edges
                        have a normal a side */
    float *uvs;      /* 2 a vertex, or NULL */
    uint32_t *quads; /* 4 vertices each */
    uint32_t *slots; /* material slot of each quad */
};

#ifdef __cplusplus
extern "C" {
#endif

/* Refines a cage `level` times, at least once where it has faces other than quads. False and a sentence that names the
 * mesh where memory runs out or OpenSubdiv refuses the cage; *out is then empty. */
bool subdivide(const struct scene_mesh *mesh, int level, struct subdivided *out, char error[SCENE_ERROR]);

/* The quads that `level` refinements make. */
double subdivide_quads(const struct scene_mesh *mesh, int level);

void subdivide_free(struct subdivided *subdivided);

#ifdef __cplusplus
}
#endif

#endif
