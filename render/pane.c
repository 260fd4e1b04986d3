/* SPDX-License-Identifier: Apache-2.0 */
#include "render/pane.h"

/* Panes in a row; what lies behind more is dark. */
enum { MOST_PANES = 256 };

rgb pane_transmittance(const struct model *model, float3 origin, float3 dir, float tfar)
{
    const rgb black = {0};
    rgb passed = {1, 1, 1};
    if (!model->panes) return trace_occluded(model->trace, origin, dir, tfar) ? black : passed;
    const float3 end = mad(origin, dir, isinf(tfar) ? 0 : tfar);
    for (int i = 0; i < MOST_PANES; i++) {
        struct hit hit;
        struct point point;
        if (!trace_caster(model->trace, origin, dir, tfar, &hit)) return passed;
        if (!shade_may_pass(model, &hit)) return black;
        shade_point(model, (struct ray){origin, dir}, &hit, &point);
        passed = mul(passed, point.brdf.through);
        if (is_black(passed)) return black;
        origin = shade_origin(&point, dir);
        /* The way that is left, and by a hair less: rounding must not carry it to the light's own surface. */
        if (!isinf(tfar)) tfar = dot(sub(end, origin), dir) * (1 - 1e-5f);
    }
    return black;
}

void pane_transmittances(const struct model *model, const struct shadow_ray *rays, int count, rgb *through)
{
    if (count == 0) return;
    bool occluded[count];
    if (!model->panes) trace_shadows(model->trace, rays, count, occluded);
    for (int i = 0; i < count; i++) {
        if (model->panes) through[i] = pane_transmittance(model, rays[i].origin, rays[i].dir, rays[i].tfar);
        else through[i] = occluded[i] ? vec3(0, 0, 0) : vec3(1, 1, 1);
    }
}
