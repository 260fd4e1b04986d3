/* SPDX-License-Identifier: Apache-2.0 */
#include "render/primary.h"

bool primary(const struct model *model, float x, float y, struct pixel *pixel, struct point *point)
{
    struct ray ray = camera_ray(&model->scene->camera, x, y);
    struct hit hit;
    float pdf;
    pixel->samples += 1;
    if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) {
        rgb strong = lights_strong(model->lights, ray.origin, ray.dir, ray.dir, &pdf);
        pixel->emission = add(pixel->emission, add(strong, lights_rest(model->lights, ray.dir)));
        return false;
    }
    shade_point(model, ray, &hit, point);
    pixel->albedo = add(pixel->albedo, point->brdf.kd);
    for (int i = 0; i < point->brdf.lobe_count; i++) pixel->albedo = add(pixel->albedo, point->brdf.lobes[i].weight);
    pixel->normal = add(pixel->normal, point->n);
    pixel->depth += hit.t;
    pixel->hits += 1;
    pixel->emission = add(pixel->emission, point->emission);
    return true;
}
