/* SPDX-License-Identifier: Apache-2.0 */
/* How often a cage is refined: as little as its picture allows.
 *
 *     int most = level_by_edges(mesh, transform, camera, LEVEL_EDGE_PIXELS);
 *     struct bends bends = {0};
 *     if (most > 1 && !bends_measure(mesh, &bends, error)) fail(error);
 *     int level = level_by_bends(mesh, &bends, transform, camera, most);
 *     bends_free(&bends);
 *
 * A mesh shared by several objects takes the highest of its levels.
 */
#ifndef IMPORT_LEVEL_H
#define IMPORT_LEVEL_H

#include "import/scene.h"

/* The longest edge that is refined no more, pixels; nine in ten are under half of it. At 2 the mean of a picture is
 * within 1e-4 of that at 1, with a quarter of the triangles. */
#define LEVEL_EDGE_PIXELS 2.0f
#define LEVEL_TRIANGLES 8000000 /* the most that a cage is refined to */

/* The level (0 .. 10) at which no edge of the cage, placed by `transform`, is longer than edge_pixels in the camera's
 * picture: one of length l whose middle is at distance d has l/d / 2^level times as many pixels as lie in a unit of the
 * camera's window (an orthographic one's: l / 2^level). An edge behind the camera or at its side counts too: it may be
 * seen in a mirror. Less where the cage would have more than LEVEL_TRIANGLES. 0 for a mesh that is no cage. */
int level_by_edges(const struct scene_mesh *mesh, const float transform[static 12], const struct scene_camera *camera,
                   float edge_pixels);

/* A quad of the cage's first refinement. */
struct bend {
    float middle[3], reach; /* object space, m: about a sphere that holds it */
    float depth;            /* how far the next refinement leaves it, m */
};

struct bends {
    uint32_t count;
    struct bend *quads; /* owned */
};

/* Refines a cage twice to see where it bends. Nothing for one that isn't smooth, whose facets are seen. False and a
 * sentence as tessellate. */
bool bends_measure(const struct scene_mesh *mesh, struct bends *bends, char error[static SCENE_ERROR]);
void bends_free(struct bends *bends);

/* The level, 1 .. `most`, from which on the surface lies within .1 pixels of its triangles (each level takes it to a
 * quarter); where the camera does not look, .4. Two levels more than the sharpness of its creases where `most` has
 * them: before that they look sharp. `most` where there are no bends. At .1 a picture of curved cages is as near to one
 * with edges of 1 pixel as with edges of 2, by a quarter of the triangles. */
int level_by_bends(const struct scene_mesh *mesh, const struct bends *bends, const float transform[static 12],
                   const struct scene_camera *camera, int most);

#endif
