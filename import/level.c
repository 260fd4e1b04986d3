/* SPDX-License-Identifier: Apache-2.0 */
#include "import/level.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "import/subdivide.h"

#define LEVEL_MAX 10
#define DEPTH_PIXELS .1   /* the surface's distance from its triangles */
#define UNSEEN 4          /* times as much where the camera does not look: shadows, mirrors */
#define SHARPNESS_MAX 10  /* this and above is infinite */
#define ROUNDING_LEVELS 2 /* that a crease's rounding takes beyond its sharpness */

/* An edge nearer to the camera than this part of its length counts as if it were so far: else one that passes through
 * the camera would ask for infinitely many. */
#define NEAREST .25

static void transform_point(const float m[static 12], const float *p, double out[static 3])
{
    for (int row = 0; row < 3; row++)
        out[row] =
            (double)m[4 * row] * p[0] + (double)m[4 * row + 1] * p[1] + (double)m[4 * row + 2] * p[2] + m[4 * row + 3];
}

/* The length of the transform's axis `column`. */
static double axis_length(const float m[static 12], int column)
{
    return sqrt((double)m[column] * m[column] + (double)m[4 + column] * m[4 + column] +
                (double)m[8 + column] * m[8 + column]);
}

/* Pixels of a length, m, at a distance of the camera. */
static double pixels_of(const struct scene_camera *camera, double length, double distance)
{
    double unit = camera->height / ((double)camera->window[3] - camera->window[2]);
    if (camera->type == CAMERA_ORTHOGRAPHIC) return length * unit / axis_length(camera->transform, 1);
    return length * unit / fmax(distance, 1e-30);
}

int level_by_edges(const struct scene_mesh *mesh, const float transform[static 12], const struct scene_camera *camera,
                   float edge_pixels)
{
    if (!mesh->subdivided) return 0;
    const double eye[3] = {camera->transform[3], camera->transform[7], camera->transform[11]};
    double longest = 0; /* pixels */
    for (uint32_t f = 0, corner = 0; f < mesh->face_count; corner += mesh->face_sizes[f++]) {
        double a[3], b[3];
        transform_point(transform, mesh->positions + 3 * (size_t)mesh->corners[corner + mesh->face_sizes[f] - 1], a);
        for (uint32_t i = 0; i < mesh->face_sizes[f]; i++) {
            transform_point(transform, mesh->positions + 3 * (size_t)mesh->corners[corner + i], b);
            double length = 0, distance = 0;
            for (int axis = 0; axis < 3; axis++) {
                length += (b[axis] - a[axis]) * (b[axis] - a[axis]);
                distance += (.5 * (a[axis] + b[axis]) - eye[axis]) * (.5 * (a[axis] + b[axis]) - eye[axis]);
                a[axis] = b[axis];
            }
            length = sqrt(length);
            longest = fmax(longest, pixels_of(camera, length, fmax(sqrt(distance), NEAREST * length)));
        }
    }
    int level = 0;
    while (level < LEVEL_MAX && ldexp(longest, -level) > edge_pixels) level++;
    while (level > 0 && 2 * subdivide_quads(mesh, level) > LEVEL_TRIANGLES) level--;
    return level;
}

static double distance_of(const double a[static 3], const double b[static 3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* A quad from its four children, child j at corner j and turned as its parent is: from there on its own corner, the
 * middle of the next edge, the quad's middle, that of the edge before. */
static struct bend bend_of(const float *positions, const uint32_t *children)
{
    double corners[4][3], middles[4][3], middle[3], mean[3] = {0};
    struct bend bend = {0};
    for (int j = 0; j < 4; j++)
        for (int axis = 0; axis < 3; axis++) {
            corners[j][axis] = positions[3 * (size_t)children[4 * j + j] + axis];
            middles[j][axis] = positions[3 * (size_t)children[4 * j + (j + 1) % 4] + axis];
            mean[axis] += corners[j][axis] / 4;
        }
    for (int axis = 0; axis < 3; axis++) {
        middle[axis] = positions[3 * (size_t)children[2] + axis];
        bend.middle[axis] = (float)middle[axis];
    }
    double depth = distance_of(middle, mean), reach = 0;
    for (int j = 0; j < 4; j++) {
        double between[3];
        for (int axis = 0; axis < 3; axis++) between[axis] = (corners[j][axis] + corners[(j + 1) % 4][axis]) / 2;
        depth = fmax(depth, distance_of(middles[j], between));
        reach = fmax(reach, distance_of(corners[j], middle));
    }
    bend.depth = (float)depth;
    bend.reach = (float)reach;
    return bend;
}

bool bends_measure(const struct scene_mesh *mesh, struct bends *bends, char error[static SCENE_ERROR])
{
    *bends = (struct bends){0};
    if (!mesh->subdivided || !mesh->smooth || mesh->scheme != SUBDIVISION_CATMULL_CLARK) return true;
    struct subdivided fine;
    if (!subdivide(mesh, 2, &fine, error)) return false;
    bends->quads = malloc((fine.quad_count / 4 + (size_t)1) * sizeof *bends->quads);
    if (!bends->quads) {
        snprintf(error, SCENE_ERROR, "mesh \"%s\": out of memory", mesh->name);
        subdivide_free(&fine);
        return false;
    }
    bends->count = fine.quad_count / 4;
    for (uint32_t q = 0; q < bends->count; q++) bends->quads[q] = bend_of(fine.positions, fine.quads + 16 * (size_t)q);
    subdivide_free(&fine);
    return true;
}

void bends_free(struct bends *bends)
{
    free(bends->quads);
    *bends = (struct bends){0};
}

/* Whether the camera may see something of a ball. */
static bool is_in_view(const struct scene_camera *camera, const double middle[static 3], double radius)
{
    if (camera->type == CAMERA_PANORAMIC) return true;
    const float *m = camera->transform, *w = camera->window;
    double at[3] = {0}; /* in the camera's axes, m */
    for (int axis = 0; axis < 3; axis++)
        for (int row = 0; row < 3; row++)
            at[axis] += (middle[row] - m[4 * row + 3]) * m[4 * row + axis] / axis_length(m, axis);
    double depth = -at[2], scale = camera->type == CAMERA_ORTHOGRAPHIC ? axis_length(m, 0) : depth;
    if (depth < -radius) return false;
    for (int axis = 0; axis < 2; axis++) {
        double low = w[2 * axis], high = w[2 * axis + 1], most = fmax(fabs(low), fabs(high));
        double margin = radius * (camera->type == CAMERA_ORTHOGRAPHIC ? 1 : sqrt(1 + most * most));
        if (at[axis] < low * scale - margin || at[axis] > high * scale + margin) return false;
    }
    return true;
}

int level_by_bends(const struct scene_mesh *mesh, const struct bends *bends, const float transform[static 12],
                   const struct scene_camera *camera, int most)
{
    if (bends->count == 0) return most;
    const double eye[3] = {camera->transform[3], camera->transform[7], camera->transform[11]};
    double deepest = 0, size = 0; /* pixels */
    for (int axis = 0; axis < 3; axis++) size = fmax(size, axis_length(transform, axis));
    for (uint32_t q = 0; q < bends->count; q++) {
        const struct bend *bend = &bends->quads[q];
        double middle[3], reach = size * bend->reach;
        transform_point(transform, bend->middle, middle);
        double distance = fmax(distance_of(middle, eye) - reach, 2 * NEAREST * reach);
        double depth = pixels_of(camera, size * bend->depth, distance);
        deepest = fmax(deepest, is_in_view(camera, middle, reach) ? depth : depth / UNSEEN);
    }
    int level = 1;
    while (level < most && ldexp(deepest, -2 * (level - 1)) > DEPTH_PIXELS) level++;
    double sharpest = 0;
    for (uint32_t i = 0; i < mesh->crease_count; i++)
        if (mesh->crease_sharpness[i] < SHARPNESS_MAX) sharpest = fmax(sharpest, mesh->crease_sharpness[i]);
    for (uint32_t i = 0; i < mesh->sharp_corner_count; i++)
        if (mesh->corner_sharpness[i] < SHARPNESS_MAX) sharpest = fmax(sharpest, mesh->corner_sharpness[i]);
    if (sharpest > 0 && sharpest < most) level = (int)fmax(level, ceil(sharpest) + ROUNDING_LEVELS);
    return level < most ? level : most;
}
