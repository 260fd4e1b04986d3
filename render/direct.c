/* SPDX-License-Identifier: Apache-2.0 */
#include "render/direct.h"

#include <stdlib.h>

/* Runs of cells over the lamps (and their triangles), a square grid of places each. Four neighbouring runs are shifted
 * against each other so that they interleave to a grid twice as fine: midpoints of equal cells, which integrate a
 * smooth lobe far better than scattered points. */
enum { RUNS = 8, SIDE = 6, CELLS = RUNS * SIDE * SIDE };

/* An environment alone has the same cells everywhere: a grid over its importance, each the mean of a finer grid. */
enum { SKY_SIDE = 24, SKY_PARTS = 12 };

/* Lobes narrower than this, rad, aren't resolved: n = 300. */
#define LEAST_WIDTH .08f
/* A lamp that fills more of what a point sees, sr, has cells that are too wide. */
#define MOST_SOLID_ANGLE 1.0f

bool direct_resolves(const struct brdf *brdf)
{
    for (int i = 0; i < brdf->lobe_count; i++)
        if (lobe_width(&brdf->lobes[i]) < LEAST_WIDTH) return false;
    return true;
}

bool direct_averages(const struct direct *direct, const struct point *point)
{
    if (point->brdf.lobe_count == 0) return true; /* nothing to average, and no lamp to look at for it */
    return direct_resolves(&point->brdf) && lights_widest(direct->model->lights, point->origin) < MOST_SOLID_ANGLE;
}

/* A light sample as a cell, one of `count`. */
static struct direct_cell cell_of(const struct light_sample *light, int count)
{
    float omega = light->pdf > 0 ? minf(1 / (light->pdf * (float)count), 2 * PI) : 0;
    return (struct direct_cell){light->wi, 1, omega, scale(light->weight, 1 / (float)count)};
}

/* Cell i of CELLS. */
static bool lamp_cell(const struct lights *lights, float3 p, float3 n, int i, struct direct_cell *cell)
{
    int run = i / (SIDE * SIDE), row = i / SIDE % SIDE, column = i % SIDE;
    float u[3] = {((float)i + .5f) / (float)CELLS, ((float)row + (run & 1 ? .75f : .25f)) / (float)SIDE,
                  ((float)column + (run & 2 ? .75f : .25f)) / (float)SIDE};
    struct light_sample light;
    if (!lights_sample(lights, p, n, u, &light)) return false;
    *cell = cell_of(&light, CELLS);
    return true;
}

static struct direct_cell sky_cell(const struct lights *lights, int row, int column)
{
    struct direct_cell cell = {.omega = 0};
    float luminances = 0;
    for (int k = 0; k < SKY_PARTS * SKY_PARTS; k++) {
        struct light_sample part;
        float u[3] = {.5f, ((float)row + ((float)(k / SKY_PARTS) + .5f) / SKY_PARTS) / SKY_SIDE,
                      ((float)column + ((float)(k % SKY_PARTS) + .5f) / SKY_PARTS) / SKY_SIDE};
        if (!lights_sample(lights, vec3(0, 0, 0), vec3(0, 0, 1), u, &part)) continue;
        struct direct_cell one = cell_of(&part, SKY_SIDE * SKY_SIDE * SKY_PARTS * SKY_PARTS);
        cell.weight = add(cell.weight, one.weight);
        cell.omega += one.omega;
        cell.wi = mad(cell.wi, one.wi, luminance(one.weight));
        luminances += luminance(one.weight);
    }
    cell.spread = luminances > 0 ? length(cell.wi) / luminances : 0;
    cell.wi = normalize(cell.wi);
    return cell;
}

bool direct_prepare(const struct model *model, const struct mean_brdf *tables, int shadow_rays, struct direct *direct)
{
    *direct = (struct direct){model, tables, shadow_rays, NULL};
    if (!lights_environment_only(model->lights)) return true;
    direct->sky = malloc(SKY_SIDE * SKY_SIDE * sizeof *direct->sky);
    for (int i = 0; direct->sky && i < SKY_SIDE * SKY_SIDE; i++)
        direct->sky[i] = sky_cell(model->lights, i / SKY_SIDE, i % SKY_SIDE);
    return direct->sky != NULL;
}

void direct_free(struct direct *direct)
{
    free(direct->sky);
    direct->sky = NULL;
}

/* The mean over the cell of f cos, all lobes together. */
static rgb lobes_over(const struct brdf *brdf, const struct mean_lobe *lobes, const struct direct_cell *cell)
{
    rgb f_cos = {0};
    for (int i = 0; i < brdf->lobe_count; i++) {
        const struct mean_lobe *m = &lobes[i];
        if (cell->omega > 1e-6f)
            f_cos = mad(f_cos, mean_lobe_cap(m, (struct cap){cell->wi, cell->omega}), 1 / cell->omega);
        else f_cos = mad(f_cos, lobe_eval(m->lobe, m->n, m->wo, cell->wi), maxf(dot(cell->wi, m->n), 0));
    }
    return f_cos;
}

static void prepare_lobes(const struct direct *direct, const struct point *point, struct mean_lobe lobes[2])
{
    for (int i = 0; i < point->brdf.lobe_count; i++)
        lobes[i] = mean_lobe(direct->tables, &point->brdf.lobes[i], point->n, point->wo);
}

rgb direct_sample(const struct direct *direct, const struct point *point, const float u[static 3], bool averages,
                  struct direct_share *share)
{
    const struct brdf *brdf = &point->brdf;
    struct light_sample light;
    rgb averaged[DIRECT_PARTS] = {{0}}, sampled = {0};
    if (!lights_sample(direct->model->lights, point->origin, point->n, u, &light)) return sampled;
    float cosine = maxf(dot(light.wi, point->n), 0);
    rgb diffuse = scale(mul(light.weight, brdf->kd), cosine / PI);
    if (direct->sky) averaged[DIRECT_DIFFUSE] = diffuse;
    else sampled = diffuse;
    if (averages) {
        struct mean_lobe lobes[2];
        prepare_lobes(direct, point, lobes);
        struct direct_cell cell = cell_of(&light, direct->shadow_rays);
        averaged[DIRECT_LOBES] = mul(light.weight, lobes_over(brdf, lobes, &cell));
    } else {
        for (int i = 0; i < brdf->lobe_count; i++) {
            const struct lobe *lobe = &brdf->lobes[i];
            float mis = light.pdf > 0 ? mis_weight(light.pdf, lobe_pdf(lobe, point->n, point->wo, light.wi)) : 1;
            rgb f = lobe_eval(lobe, point->n, point->wo, light.wi);
            sampled = mad(sampled, mul(light.weight, f), cosine * mis);
        }
    }
    if (is_black(averaged[DIRECT_DIFFUSE]) && is_black(averaged[DIRECT_LOBES]) && is_black(sampled)) return sampled;
    bool lit = cosine > 0 && dot(light.wi, point->ng) > 0 &&
               !trace_occluded(direct->model->trace, point->origin, light.wi, light.distance);
    for (int k = 0; k < DIRECT_PARTS; k++) {
        share->asked[k] = add(share->asked[k], averaged[k]);
        if (lit) share->lit[k] = add(share->lit[k], averaged[k]);
    }
    return lit ? sampled : vec3(0, 0, 0);
}

static rgb ratio(rgb a, rgb b)
{
    return vec3(b.x > 0 ? a.x / b.x : 0, b.y > 0 ? a.y / b.y : 0, b.z > 0 ? a.z / b.z : 0);
}

rgb direct_light(const struct direct *direct, const struct point *point, const struct direct_share *share)
{
    bool lobes_lit = !is_black(share->lit[DIRECT_LOBES]);
    if (!lobes_lit && is_black(share->lit[DIRECT_DIFFUSE])) return vec3(0, 0, 0);
    struct mean_lobe lobes[2];
    rgb e = {0}, specular = {0};
    prepare_lobes(direct, point, lobes);
    int count = direct->sky ? SKY_SIDE * SKY_SIDE : CELLS;
    for (int i = 0; i < count; i++) {
        struct direct_cell cell;
        if (direct->sky) cell = direct->sky[i];
        else if (!lamp_cell(direct->model->lights, point->origin, point->n, i, &cell)) continue;
        e = mad(e, cell.weight, cell.spread * maxf(dot(cell.wi, point->n), 0));
        if (lobes_lit) specular = add(specular, mul(cell.weight, lobes_over(&point->brdf, lobes, &cell)));
    }
    rgb diffuse = mul(scale(point->brdf.kd, 1 / PI), e);
    return add(mul(diffuse, ratio(share->lit[DIRECT_DIFFUSE], share->asked[DIRECT_DIFFUSE])),
               mul(specular, ratio(share->lit[DIRECT_LOBES], share->asked[DIRECT_LOBES])));
}
