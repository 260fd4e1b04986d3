/* SPDX-License-Identifier: Apache-2.0 */
#include "render/primary.h"

#include "render/pane.h"

bool primary(const struct model *model, float x, float y, struct rng *rng, struct pixel *pixel, struct point *point)
{
    struct ray ray = camera_ray(&model->scene->camera, x, y);
    struct hit hit;
    float pdf, travelled = 0;
    rgb passed = {1, 1, 1};
    pixel->samples += 1;
    for (;;) {
        if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) {
            rgb strong = lights_strong(model->lights, ray.origin, ray.dir, ray.dir, &pdf);
            rgb sky = add(strong, lights_rest(model->lights, ray.dir));
            pixel->emission = add(pixel->emission, mul(passed, sky));
            return false;
        }
        shade_point(model, ray, &hit, point);
        travelled += hit.t;
        pixel->emission = add(pixel->emission, mul(passed, point->emission));
        if (!pane_pass(point, rng, &passed)) break;
        ray.origin = shade_origin(point, ray.dir);
    }
    if (travelled > hit.t || !is_black(point->brdf.through)) { /* what is left of it after panes */
        struct brdf rest = {0};
        brdf_add(&rest, &point->brdf, passed);
        point->brdf = rest;
    }
    pixel->albedo = add(pixel->albedo, point->brdf.kd);
    for (int i = 0; i < point->brdf.lobe_count; i++) pixel->albedo = add(pixel->albedo, point->brdf.lobes[i].weight);
    pixel->normal = add(pixel->normal, point->n);
    pixel->depth += travelled;
    pixel->hits += 1;
    return true;
}
