/* SPDX-License-Identifier: Apache-2.0 */
#include "render/camera.h"

struct ray camera_ray(const struct scene_camera *camera, float x, float y)
{
    const float *w = camera->window, *m = camera->transform;
    float sx = w[0] + (w[1] - w[0]) * x / (float)camera->width;
    float sy = w[3] + (w[2] - w[3]) * y / (float)camera->height;
    float3 dir = {m[0] * sx + m[1] * sy - m[2], m[4] * sx + m[5] * sy - m[6], m[8] * sx + m[9] * sy - m[10]};
    return (struct ray){{m[3], m[7], m[11]}, normalize(dir)};
}

void camera_resize(struct scene_camera *camera, int width, int height)
{
    float *w = camera->window;
    float centre = (w[0] + w[1]) / 2, half = (w[3] - w[2]) / 2 * (float)width / (float)height;
    w[0] = centre - half;
    w[1] = centre + half;
    camera->width = width;
    camera->height = height;
}

float camera_pixel_angle(const struct scene_camera *camera)
{
    const float *w = camera->window;
    return (w[1] - w[0]) / (float)camera->width * ((w[3] - w[2]) / (float)camera->height);
}

float camera_pixel_width(const struct scene_camera *camera, float3 p)
{
    float3 eye = vec3(camera->transform[3], camera->transform[7], camera->transform[11]);
    return length(sub(p, eye)) * sqrtf(camera_pixel_angle(camera));
}
