/* SPDX-License-Identifier: Apache-2.0 */
/* From polygons and cages to triangles.
 *
 * Cages are refined uniformly with OpenSubdiv until no edge, seen from the camera, is longer than edge_pixels, and
 * every vertex is then moved to the limit surface (positions, normals, face-varying UVs). Polygons of any size are cut
 * into triangles as Blender cuts them, so that folded quads look alike in both renderers.
 */
#ifndef IMPORT_TESSELLATE_H
#define IMPORT_TESSELLATE_H

#include "import/scene.h"

/* The default length of the longest edge, pixels; nine in ten are under half of it. At 2 the mean of a picture is
 * within 1e-4 of that at 1, with a quarter of the triangles. */
#define TESSELLATE_EDGE_PIXELS 2.0f
#define TESSELLATE_TRIANGLES 8000000 /* the most that a cage is refined to */

/* Triangles of one mesh, object space. A vertex is a (position, normal, uv) triple: corners that agree share it. */
struct triangles {
    uint32_t vertex_count, triangle_count;
    float *positions;  /* 3 a vertex */
    float *normals;    /* 3 a vertex, unit; a flat face's own normal where the mesh is flat */
    float *uvs;        /* 2 a vertex, or NULL where the mesh has none */
    uint32_t *indices; /* 3 a triangle, counter-clockwise from the front */
    uint32_t *slots;   /* material slot of each triangle */
};

/* The refinement level (0 ..  10) at which no edge of the cage, placed by `transform`, is longer than edge_pixels in
 * the camera's picture: one of length l whose middle is at distance d has l/d / 2^level times as many pixels as lie in
 * a unit of the camera's window. An edge behind the camera or at its side counts too: it may be seen in a mirror. Less
 * where the cage would have more than TESSELLATE_TRIANGLES. A mesh shared by several objects takes the highest of its
 * levels. 0 for a mesh that is no cage. */
int tessellate_level(const struct scene_mesh *mesh, const float transform[static 12], const struct scene_camera *camera,
                     float edge_pixels);

/* Fills *out, which the caller frees. A cage with faces other than quads is refined once at least. False and a sentence
 * that names the mesh where memory runs out or OpenSubdiv refuses the cage; *out is then empty. Thread-safe for
 * different `out`. */
bool tessellate(const struct scene_mesh *mesh, int level, struct triangles *out, char error[static SCENE_ERROR]);

void triangles_free(struct triangles *triangles);

#endif
