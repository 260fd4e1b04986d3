/* SPDX-License-Identifier: Apache-2.0 */
#include "render/primary.h"

#include "render/pane.h"

bool primary(const struct model *model, float x, float y, float2 lens, struct rng *rng, struct pixel *pixel,
             struct point *point)
{
    struct ray ray = camera_lens_ray(&model->scene->camera, x, y, lens);
    const float3 eye = ray.origin;
    struct hit hit;
    float pdf, travelled = 0;
    rgb passed = {1, 1, 1}, nearer = {0};
    pixel->samples += 1;
    for (;;) {
        bool found = trace_camera(model->trace, ray.origin, ray.dir, INFINITY, &hit);
        rgb lamps = lights_seen(model->lights, eye, ray.dir, found ? travelled + hit.t : INFINITY);
        pixel->emission = add(pixel->emission, mul(passed, sub(lamps, nearer))); /* those before panes are counted */
        nearer = lamps;
        if (!found) {
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
