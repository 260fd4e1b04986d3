/* SPDX-License-Identifier: Apache-2.0 */
#include "render/direct.h"

#include <stdlib.h>

/* Runs of cells over the lamps (and their triangles), a square grid of places each. Four neighbouring runs are shifted
 * against each other so that they interleave to a grid twice as fine: midpoints of equal cells, which integrate a
 * smooth lobe far better than scattered points. */
enum { RUNS = 8, SIDE = 6, CELLS = RUNS * SIDE * SIDE };

/* An environment alone has the same cells everywhere. */
enum { SKY_CELLS = 512 };
#define MOST_CELLS SKY_CELLS /* of the two */

/* Shadow rays where light comes from one side of an edge. */
enum { MOST_RAYS = 128, REFINE = 4 };

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

/* Cell i of CELLS by the light sample at the place (x, y) in it, .5 each: its middle. */
static bool lamp_sample_in(const struct lights *lights, const struct point *point, int i, float x, float y,
                           struct light_sample *light)
{
    int run = i / (SIDE * SIDE), row = i / SIDE % SIDE, column = i % SIDE;
    /* The runs' shifts interleave their middles; jittered places wrap within the run's square. */
    float v = ((float)row + y + (run & 1 ? .25f : -.25f)) / (float)SIDE,
          w = ((float)column + x + (run & 2 ? .25f : -.25f)) / (float)SIDE;
    float u[3] = {((float)i + .5f) / (float)CELLS, v - floorf(v), w - floorf(w)};
    return lights_sample(lights, point->origin, point->n, u, light);
}

static struct cell lamp_cell(const struct lights *lights, const struct point *point, int i)
{
    struct light_sample light;
    if (!lamp_sample_in(lights, point, i, .5f, .5f, &light)) return (struct cell){.omega = 0};
    float omega = light.pdf > 0 ? minf(1 / (light.pdf * (float)CELLS), 2 * PI) : 0;
    return (struct cell){light.wi, omega, scale(light.weight, 1 / (float)CELLS)};
}

bool direct_prepare(const struct model *model, const struct mean_brdf *tables, struct direct *direct)
{
    *direct = (struct direct){.model = model, .tables = tables};
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

rgb direct_sample(const struct direct *direct, const struct point *point, const float u[static 3], bool averages)
{
    const struct brdf *brdf = &point->brdf;
    struct light_sample light;
    rgb sum = {0};
    if ((direct->sky || is_black(brdf->kd)) && (averages || brdf->lobe_count == 0)) return sum;
    if (!lights_sample(direct->model->lights, point->origin, point->n, u, &light)) return sum;
    float cosine = dot(light.wi, point->n);
    if (cosine <= 0 || dot(light.wi, point->ng) <= 0) return sum;
    if (!direct->sky) sum = scale(mul(light.weight, brdf->kd), cosine / PI);
    for (int i = 0; !averages && i < brdf->lobe_count; i++) {
        const struct lobe *lobe = &brdf->lobes[i];
        float mis = light.pdf > 0 ? mis_weight(light.pdf, lobe_pdf(lobe, point->n, point->wo, light.wi)) : 1;
        rgb f = lobe_eval(lobe, point->n, point->wo, light.wi);
        sum = mad(sum, mul(light.weight, f), cosine * mis);
    }
    bool lit = !is_black(sum) && !trace_occluded(direct->model->trace, point->origin, light.wi, light.distance);
    return lit ? sum : vec3(0, 0, 0);
}

static rgb ratio(rgb a, rgb b)
{
    return vec3(b.x > 0 ? a.x / b.x : 0, b.y > 0 ? a.y / b.y : 0, b.z > 0 ? a.z / b.z : 0);
}

/* Whether light comes through from a random place in cell i. */
static bool cell_lit(const struct direct *direct, const struct point *point, float3 origin, int i,
                     const struct cell *cell, struct rng *rng)
{
    float3 wi = cell->wi;
    float distance = INFINITY, x = rng_float(rng), y = rng_float(rng);
    if (direct->sky) { /* in the cell's cap */
        float z = 1 - x * cell->omega * (1 / (2 * PI)), r = sqrtf(maxf(1 - z * z, 0));
        wi = to_world(frame_about(wi), vec3(r * cosf(2 * PI * y), r * sinf(2 * PI * y), z));
    } else {
        struct light_sample light;
        if (!lamp_sample_in(direct->model->lights, point, i, x, y, &light) &&
            !lamp_sample_in(direct->model->lights, point, i, .5f, .5f, &light))
            return false;
        /* Sampled from the mean point: the same place from this origin. */
        float3 to = isinf(light.distance) ? light.wi : sub(mad(point->origin, light.wi, light.distance), origin);
        distance = isinf(light.distance) ? INFINITY : length(to);
        wi = normalize(to);
    }
    return dot(wi, point->ng) > 0 && !trace_occluded(direct->model->trace, origin, wi, distance);
}

/* The light of cells at a point of `origins` by turns, and the shadow rays that find what of it comes through. */
struct shadow {
    const struct direct *direct;
    const struct point *point;
    const float3 *origins;
    int origin_count, cell_count;
    const struct cell *cells;
    const rgb *light;
    const float *passed; /* luminance of the light of all cells before each */
    struct rng *rng;
};

/* A shadow ray to where the light of all cells, in a row, has reached `at`; its light is counted with `weight`. */
static bool probe(const struct shadow *s, float at, int origin, float weight, rgb *asked, rgb *lit)
{
    int low = 0, high = s->cell_count;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (s->passed[middle] <= at) low = middle;
        else high = middle;
    }
    float own = luminance(s->light[low]);
    if (own <= 1e-30f) return false; /* beyond the last, by rounding; or its reciprocal might be no number */
    rgb share = scale(s->light[low], weight / own);
    bool through = cell_lit(s->direct, s->point, s->origins[origin % s->origin_count], low, &s->cells[low], s->rng);
    *asked = add(*asked, share);
    if (through) *lit = add(*lit, share);
    return through;
}

/* The share that comes through: a ray for each of `rays` equal strata of the light, whose sum is `sum`; where a
 * stratum's neighbours disagree, REFINE rays instead. Its own first ray has no say in that, which would bias the mean.
 */
static rgb lit_share(const struct shadow *s, float sum, int rays)
{
    rgb asked[MOST_RAYS] = {{0}}, lit[MOST_RAYS] = {{0}}, asked_sum = {0}, lit_sum = {0};
    bool through[MOST_RAYS];
    float step = sum / (float)rays;
    for (int k = 0; k < rays; k++)
        through[k] = probe(s, ((float)k + rng_float(s->rng)) * step, k, 1, &asked[k], &lit[k]);
    for (int k = 0; k < rays; k++) {
        int near = 0, of = 0;
        for (int j = k - 2; j <= k + 2; j++)
            if (j != k && j >= 0 && j < rays) near += through[j], of++;
        if (near != 0 && near != of) {
            asked[k] = lit[k] = vec3(0, 0, 0);
            for (int j = 0; j < REFINE; j++)
                probe(s, ((float)k + ((float)j + rng_float(s->rng)) / REFINE) * step, k + j, 1.0f / REFINE, &asked[k],
                      &lit[k]);
        }
        asked_sum = add(asked_sum, asked[k]);
        lit_sum = add(lit_sum, lit[k]);
    }
    return ratio(lit_sum, asked_sum);
}

rgb direct_light(const struct direct *direct, const struct point *point, bool averages, const float3 *origins,
                 int count, int rays, struct rng *rng)
{
    struct mean_lobe lobes[2];
    struct cell cells[MOST_CELLS];
    rgb light[MOST_CELLS], total = {0}, diffuse = direct->sky ? scale(point->brdf.kd, 1 / PI) : vec3(0, 0, 0);
    float sum = 0, passed[MOST_CELLS + 1];
    int cell_count = direct->sky ? direct->sky_count : CELLS;
    averages = averages && point->brdf.lobe_count > 0;
    if (!averages && is_black(diffuse)) return total;
    prepare_lobes(direct, point, lobes);
    for (int i = 0; i < cell_count; i++) {
        rgb f_cos = {0};
        if (direct->sky) {
            const struct environment_cell *sky = &direct->sky[i];
            f_cos = scale(diffuse, sky->spread * maxf(dot(sky->wi, point->n), 0));
            /* The cap whose directions are spread as much: the mean cosine to its axis is 1 - omega/4pi. */
            cells[i] = (struct cell){sky->wi, 4 * PI * (1 - sky->spread), sky->flux};
        } else {
            cells[i] = lamp_cell(direct->model->lights, point, i);
        }
        light[i] = vec3(0, 0, 0);
        passed[i] = sum;
        if (is_black(cells[i].weight)) continue;
        if (averages) f_cos = add(f_cos, lobes_over(&point->brdf, lobes, &cells[i]));
        light[i] = mul(cells[i].weight, f_cos);
        total = add(total, light[i]);
        sum += luminance(light[i]);
    }
    if (sum <= 0) return total;
    struct shadow shadow = {direct, point, origins, count, cell_count, cells, light, passed, rng};
    return mul(total, lit_share(&shadow, sum, rays));
}
