/* SPDX-License-Identifier: Apache-2.0 */
#include "render/direct.h"

#include <stdlib.h>

/* Runs of cells over the lamps (and their triangles), a square grid of places each. Four neighbouring runs are shifted against each
 * other so that they interleave to a grid twice as fine: midpoints of equal cells, which integrate a smooth lobe far better than scattered points. */
enum { RUNS = 8, SIDE = 6, COARSE_SIDE = 3 /* where only the diffuse part asks */ };

/* Lobes narrower than this, rad, aren't resolved: n = 300. */
#define LEAST_WIDTH .08f

bool direct_resolves(const struct brdf *brdf)
{
    for (int i = 0; i < brdf->lobe_count; i++)
        if (lobe_width(&brdf->lobes[i]) < LEAST_WIDTH)
            return false;
    return true;
}

/* Cell i of RUNS * side * side. */
static bool cell(const struct lights *lights, float3 p, float3 n, int i, int side, struct light_sample *light)
{
    int run = i / (side * side), row = i / side % side, column = i % side;
    float u[3] = {((float)i + .5f) / (float)(RUNS * side * side), ((float)row + (run & 1 ? .75f : .25f)) / (float)side,
                  ((float)column + (run & 2 ? .75f : .25f)) / (float)side};
    return lights_sample(lights, p, n, u, light);
}

bool direct_prepare(const struct model *model, const struct mean_brdf *tables, int shadow_rays, struct direct *direct)
{
    *direct = (struct direct){model, tables, shadow_rays, NULL};
    if (!lights_any(model->lights) || !lights_environment_only(model->lights))
        return true;
    int count = RUNS * SIDE * SIDE;
    direct->cells = calloc((size_t)count, sizeof *direct->cells);
    for (int i = 0; direct->cells && i < count; i++)
        if (!cell(model->lights, vec3(0, 0, 0), vec3(0, 0, 1), i, SIDE, &direct->cells[i]))
            direct->cells[i].weight = vec3(0, 0, 0);
    return direct->cells != NULL;
}

void direct_free(struct direct *direct)
{
    free(direct->cells);
    direct->cells = NULL;
}

/* f cos of all lobes, each averaged over the solid angle that one of `count` samples stands for. */
static rgb lobes_over(const struct brdf *brdf, const struct mean_lobe *lobes, const struct light_sample *light, int count)
{
    rgb f_cos = {0};
    float omega = light->pdf > 0 ? minf(1 / (light->pdf * (float)count), 2 * PI) : 0;
    for (int i = 0; i < brdf->lobe_count; i++) {
        const struct mean_lobe *m = &lobes[i];
        if (omega > 1e-6f)
            f_cos = mad(f_cos, mean_lobe_cap(m, (struct cap){light->wi, omega}), 1 / omega);
        else
            f_cos = mad(f_cos, lobe_eval(m->lobe, m->n, m->wo, light->wi), maxf(dot(light->wi, m->n), 0));
    }
    return f_cos;
}

static void prepare_lobes(const struct direct *direct, const struct point *point, struct mean_lobe lobes[2])
{
    for (int i = 0; i < point->brdf.lobe_count; i++)
        lobes[i] = mean_lobe(direct->tables, &point->brdf.lobes[i], point->n, point->wo);
}

rgb direct_sample(const struct direct *direct, const struct point *point, const float u[static 3], struct direct_share *share)
{
    const struct brdf *brdf = &point->brdf;
    struct light_sample light;
    rgb parts[DIRECT_PARTS] = {{0}}, unresolved = {0};
    if (!lights_sample(direct->model->lights, point->origin, point->n, u, &light))
        return unresolved;
    float cosine = maxf(dot(light.wi, point->n), 0);
    parts[DIRECT_DIFFUSE] = scale(mul(light.weight, brdf->kd), cosine);
    if (brdf->lobe_count > 0 && direct_resolves(brdf)) {
        struct mean_lobe lobes[2];
        prepare_lobes(direct, point, lobes);
        parts[DIRECT_LOBES] = mul(light.weight, lobes_over(brdf, lobes, &light, direct->shadow_rays));
    } else {
        for (int i = 0; i < brdf->lobe_count; i++) {
            const struct lobe *lobe = &brdf->lobes[i];
            float mis = light.pdf > 0 ? mis_weight(light.pdf, lobe_pdf(lobe, point->n, point->wo, light.wi)) : 1;
            unresolved = mad(unresolved, mul(light.weight, lobe_eval(lobe, point->n, point->wo, light.wi)), cosine * mis);
        }
    }
    if (is_black(parts[DIRECT_DIFFUSE]) && is_black(parts[DIRECT_LOBES]) && is_black(unresolved))
        return unresolved;
    bool lit = cosine > 0 && dot(light.wi, point->ng) > 0 &&
               !trace_occluded(direct->model->trace, point->origin, light.wi, light.distance);
    for (int k = 0; k < DIRECT_PARTS; k++) {
        share->asked[k] = add(share->asked[k], parts[k]);
        if (lit)
            share->lit[k] = add(share->lit[k], parts[k]);
    }
    return lit ? unresolved : vec3(0, 0, 0);
}

static rgb ratio(rgb a, rgb b)
{
    return vec3(b.x > 0 ? a.x / b.x : 0, b.y > 0 ? a.y / b.y : 0, b.z > 0 ? a.z / b.z : 0);
}

rgb direct_light(const struct direct *direct, const struct point *point, const struct direct_share *share)
{
    bool lobes_lit = !is_black(share->lit[DIRECT_LOBES]);
    if (!lobes_lit && is_black(share->lit[DIRECT_DIFFUSE]))
        return vec3(0, 0, 0);
    struct mean_lobe lobes[2];
    rgb e = {0}, specular = {0};
    prepare_lobes(direct, point, lobes);
    int side = lobes_lit || direct->cells ? SIDE : COARSE_SIDE, count = RUNS * side * side;
    for (int i = 0; i < count; i++) {
        struct light_sample sampled;
        const struct light_sample *light = direct->cells ? &direct->cells[i] : &sampled;
        if (!direct->cells && !cell(direct->model->lights, point->origin, point->n, i, side, &sampled))
            continue;
        e = mad(e, light->weight, maxf(dot(light->wi, point->n), 0));
        if (lobes_lit)
            specular = add(specular, mul(light->weight, lobes_over(&point->brdf, lobes, light, count)));
    }
    rgb diffuse = mul(mul(point->brdf.kd, scale(e, 1 / (PI * (float)count))), ratio(share->lit[DIRECT_DIFFUSE], share->asked[DIRECT_DIFFUSE]));
    return add(diffuse, mul(scale(specular, 1 / (float)count), ratio(share->lit[DIRECT_LOBES], share->asked[DIRECT_LOBES])));
}
