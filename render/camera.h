/* SPDX-License-Identifier: Apache-2.0 */
/* From picture to rays: a pinhole camera, Blender's conventions (looks along -Z, +Y up). */
#ifndef RENDER_CAMERA_H
#define RENDER_CAMERA_H

#include "eas/vec.h"
#include "import/scene.h"

struct ray {
    float3 origin, dir;
}; /* dir is unit */

/* The ray through (x, y) of a width x height picture, in pixels: (0, 0) is the corner of the top left pixel, pixel
 * (i, j) covers [i, i+1) x [j, j+1). */
struct ray camera_ray(const struct scene_camera *camera, float x, float y);

/* Sets the picture's size; the vertical field of view stays, the horizontal one follows the new aspect. */
void camera_resize(struct scene_camera *camera, int width, int height);

/* Solid angle of a pixel near the picture's centre, sr. */
float camera_pixel_angle(const struct scene_camera *camera);

/* Width of a pixel at the distance of p, m. */
float camera_pixel_width(const struct scene_camera *camera, float3 p);

#endif
