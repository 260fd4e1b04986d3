/* SPDX-License-Identifier: Apache-2.0 */
#include "render/direct.h"

#include <stdlib.h>

/* Runs of cells over the lamps (and their triangles), a square grid of places each. Four neighbouring runs are shifted
 * against each other so that they interleave to a grid twice as fine: midpoints of equal cells, which integrate a
 * smooth lobe far better than scattered points. */
enum { RUNS = 8, SIDE = 6, CELLS = RUNS * SIDE * SIDE };

/* An environment alone has the same cells everywhere. */
enum { SKY_CELLS = 512 };

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

/* Part of the lamps, as a point sees it. */
struct cell {
    float3 wi;   /* unit, its mean direction */
    float omega; /* solid angle, sr; 0: a point */
    rgb weight;  /* radiance x omega, W/m2 before the cosine */
};

/* A light sample as a cell, one of `count`. */
static struct cell cell_of(const struct light_sample *light, int count)
{
    float omega = light->pdf > 0 ? minf(1 / (light->pdf * (float)count), 2 * PI) : 0;
    return (struct cell){light->wi, omega, scale(light->weight, 1 / (float)count)};
}

/* Cell i of CELLS. */
static bool lamp_cell(const struct lights *lights, float3 p, float3 n, int i, struct cell *cell)
{
    int run = i / (SIDE * SIDE), row = i / SIDE % SIDE, column = i % SIDE;
    float u[3] = {((float)i + .5f) / (float)CELLS, ((float)row + (run & 1 ? .75f : .25f)) / (float)SIDE,
                  ((float)column + (run & 2 ? .75f : .25f)) / (float)SIDE};
    struct light_sample light;
    if (!lights_sample(lights, p, n, u, &light)) return false;
    *cell = cell_of(&light, CELLS);
    return true;
}

bool direct_prepare(const struct model *model, const struct mean_brdf *tables, int shadow_rays, struct direct *direct)
{
    *direct = (struct direct){.model = model, .tables = tables, .shadow_rays = shadow_rays};
    struct environment_cell *sky = malloc(SKY_CELLS * sizeof *sky);
    direct->sky_count = sky ? lights_cells(model->lights, SKY_CELLS, sky) : -1;
    if (direct->sky_count > 0) direct->sky = sky;
    else free(sky);
    return direct->sky_count >= 0;
}

void direct_free(struct direct *direct)
{
    free(direct->sky);
    direct->sky = NULL;
}

/* The mean over the cell of f cos, all lobes together. */
static rgb lobes_over(const struct brdf *brdf, const struct mean_lobe *lobes, const struct cell *cell)
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
        struct cell cell = cell_of(&light, direct->shadow_rays);
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
    int count = direct->sky ? direct->sky_count : CELLS;
    for (int i = 0; i < count; i++) {
        struct cell cell;
        if (direct->sky) {
            const struct environment_cell *sky = &direct->sky[i];
            e = mad(e, sky->flux, sky->spread * maxf(dot(sky->wi, point->n), 0));
            /* The cap whose directions are spread as much: the mean cosine to its axis is 1 - omega/4pi. */
            cell = (struct cell){sky->wi, 4 * PI * (1 - sky->spread), sky->flux};
        } else if (!lamp_cell(direct->model->lights, point->origin, point->n, i, &cell)) {
            continue;
        }
        if (lobes_lit) specular = add(specular, mul(cell.weight, lobes_over(&point->brdf, lobes, &cell)));
    }
    rgb diffuse = mul(scale(point->brdf.kd, 1 / PI), e);
    return add(mul(diffuse, ratio(share->lit[DIRECT_DIFFUSE], share->asked[DIRECT_DIFFUSE])),
               mul(specular, ratio(share->lit[DIRECT_LOBES], share->asked[DIRECT_LOBES])));
}
