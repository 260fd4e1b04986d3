/* SPDX-License-Identifier: Apache-2.0 */
/* From polygons and cages to triangles.
 *
 * Cages are refined uniformly with OpenSubdiv (import/level.h: how often), and every vertex is then moved to the limit
 * surface (positions, normals, face-varying UVs). Polygons of any size are cut
 * into triangles as Blender cuts them, so that folded quads look alike in both renderers.
 */
#ifndef IMPORT_TESSELLATE_H
#define IMPORT_TESSELLATE_H

#include "import/scene.h"

/* Triangles of one mesh, object space. A vertex is a (position, normal, uv) triple: corners that agree share it. */
struct triangles {
    uint32_t vertex_count, triangle_count;
    float *positions;  /* 3 a vertex */
    float *normals;    /* 3 a vertex, unit; a flat face's own normal where the mesh is flat */
    float *uvs;        /* 2 a vertex, or NULL where the mesh has none */
    uint32_t *indices; /* 3 a triangle, counter-clockwise from the front */
    uint32_t *slots;   /* material slot of each triangle */
};

/* Fills *out, which the caller frees. level: refinements of a cage; one with faces other than quads is refined once at
 * least. False and a sentence that names the mesh where memory runs out or OpenSubdiv refuses the cage; *out is then
 * empty. Thread-safe for different `out`. */
bool tessellate(const struct scene_mesh *mesh, int level, struct triangles *out, char error[static SCENE_ERROR]);

void triangles_free(struct triangles *triangles);

#endif
