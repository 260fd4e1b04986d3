/* SPDX-License-Identifier: Apache-2.0 */
/* Polygons to triangles, as Blender cuts them: a quad along 0-2 unless that folds it, larger ones by clipping ears in
 * the plane of the polygon. */
#ifndef IMPORT_TRIANGULATE_H
#define IMPORT_TRIANGULATE_H

#include <stdbool.h>
#include <stdint.h>

/* Cuts a polygon of `size` >= 3 corners into size - 2 triangles that keep its sense of rotation, degenerate ones
 * included: 3 (size - 2) corner numbers 0 .. size - 1 in `triangles`. `corners` names a vertex each, `positions` has 3
 * numbers a vertex. False where memory runs out. */
bool triangulate_polygon(const float *positions, const uint32_t *corners, uint32_t size, uint32_t *triangles);

#endif
