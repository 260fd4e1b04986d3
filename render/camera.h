/* SPDX-License-Identifier: Apache-2.0 */
/* From picture to rays: pinhole or thin lens, orthographic, panoramic; Blender's conventions (looks along -Z, +Y). */
#ifndef RENDER_CAMERA_H
#define RENDER_CAMERA_H

#include "eas/vec.h"
#include "import/scene.h"

struct ray {
    float3 origin, dir;
}; /* dir is unit */

/* The ray through (x, y) of a width x height picture, in pixels: (0, 0) is the corner of the top left pixel, pixel
 * (i, j) covers [i, i+1) x [j, j+1). Through the lens' middle. */
struct ray camera_ray(const struct scene_camera *camera, float x, float y);

/* The same through a place of the lens that u chooses, two numbers in [0, 1); camera_ray's where there is no lens. */
struct ray camera_lens_ray(const struct scene_camera *camera, float x, float y, float2 u);

static inline bool camera_has_lens(const struct scene_camera *camera) { return camera->lens.radius > 0; }

/* Sets the picture's size. Its height keeps what it showed, and so does a panorama's width; any other width follows the
 * new aspect. */
void camera_resize(struct scene_camera *camera, int width, int height);

/* Width of a pixel near the picture's centre at the distance of p, m. */
float camera_pixel_width(const struct scene_camera *camera, float3 p);

/* How far apart rays through neighbouring pixels are there, m, as Cycles takes it: less away from the centre, where a
 * pixel is a smaller angle. */
float camera_pixel_step(const struct scene_camera *camera, float3 p);

/* The way from p to the camera, unit, and how far it is: INFINITY for an orthographic one. */
float3 camera_way(const struct scene_camera *camera, float3 p, float *distance);

#endif
