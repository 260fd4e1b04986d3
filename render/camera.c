/* SPDX-License-Identifier: Apache-2.0 */
#include "render/camera.h"

#include "render/transform.h"

static float3 place(const struct scene_camera *camera) { return transform_column(camera->transform, 3); }

static float3 turned(const struct scene_camera *camera, float3 local)
{
    return sub(transform_point(camera->transform, local), place(camera));
}

/* Where in the window (x, y) is. */
static float2 in_window(const struct scene_camera *camera, float x, float y)
{
    const float *w = camera->window;
    return (float2){w[0] + (w[1] - w[0]) * x / (float)camera->width, w[3] + (w[2] - w[3]) * y / (float)camera->height};
}

struct ray camera_ray(const struct scene_camera *camera, float x, float y)
{
    float2 s = in_window(camera, x, y);
    float3 dir = {s.x, s.y, -1}, origin = place(camera);
    if (camera->type == CAMERA_ORTHOGRAPHIC) {
        origin = transform_point(camera->transform, vec3(s.x, s.y, 0));
        dir = vec3(0, 0, -1);
    } else if (camera->type == CAMERA_PANORAMIC) {
        dir = vec3(sinf(s.x) * cosf(s.y), sinf(s.y), -cosf(s.x) * cosf(s.y));
    }
    return (struct ray){origin, normalize(turned(camera, dir))};
}

/* A place of the opening, uniform, in units of its radius. As Cycles: of a polygon, a triangle between its middle and a
 * side, whose corner weights keep u compact. */
static float2 in_opening(const struct scene_lens *lens, float2 u)
{
    float x, y;
    if (lens->blades == 0) {
        float r = sqrtf(u.x), phi = 2 * PI * u.y;
        x = r * cosf(phi);
        y = r * sinf(phi);
    } else {
        float half = PI / (float)lens->blades, side = floorf(u.x * (float)lens->blades);
        float a = sqrtf(u.x * (float)lens->blades - side), b = u.y * a, turn = lens->rotation + 2 * half * side;
        float out = a * cosf(half), along = (2 * b - a) * sinf(half);
        x = out * cosf(turn) - along * sinf(turn);
        y = out * sinf(turn) + along * cosf(turn);
    }
    return (float2){x / lens->ratio, y};
}

struct ray camera_lens_ray(const struct scene_camera *camera, float x, float y, float2 u)
{
    const struct scene_lens *lens = &camera->lens;
    if (!camera_has_lens(camera)) return camera_ray(camera, x, y);
    float2 s = in_window(camera, x, y), on_lens = in_opening(lens, u);
    float3 from = {on_lens.x * lens->radius, on_lens.y * lens->radius, 0};
    float3 to = scale(vec3(s.x, s.y, -1), lens->focus);
    return (struct ray){transform_point(camera->transform, from), normalize(turned(camera, sub(to, from)))};
}

void camera_resize(struct scene_camera *camera, int width, int height)
{
    float *w = camera->window;
    float centre = (w[0] + w[1]) / 2, half = (w[3] - w[2]) / 2 * (float)width / (float)height;
    if (camera->type != CAMERA_PANORAMIC) {
        w[0] = centre - half;
        w[1] = centre + half;
    }
    camera->width = width;
    camera->height = height;
}

float camera_pixel_width(const struct scene_camera *camera, float3 p)
{
    const float *w = camera->window;
    float pixel = sqrtf((w[1] - w[0]) / (float)camera->width * ((w[3] - w[2]) / (float)camera->height));
    if (camera->type == CAMERA_ORTHOGRAPHIC) return pixel * length(transform_column(camera->transform, 0));
    return length(sub(p, place(camera))) * pixel;
}

float camera_pixel_step(const struct scene_camera *camera, float3 p)
{
    float width = camera_pixel_width(camera, p);
    if (camera->type != CAMERA_PERSPECTIVE) return width;
    float3 way = normalize(sub(p, place(camera))), axes[3];
    for (int i = 0; i < 3; i++) axes[i] = normalize(transform_column(camera->transform, i));
    float x = dot(way, axes[0]), y = dot(way, axes[1]);
    return width * fabsf(dot(way, axes[2])) * (sqrtf(maxf(1 - x * x, 0)) + sqrtf(maxf(1 - y * y, 0))) / 2;
}

float3 camera_way(const struct scene_camera *camera, float3 p, float *distance)
{
    float3 way = camera->type == CAMERA_ORTHOGRAPHIC ? turned(camera, vec3(0, 0, 1)) : sub(place(camera), p);
    *distance = camera->type == CAMERA_ORTHOGRAPHIC ? INFINITY : length(way);
    return normalize(way);
}
