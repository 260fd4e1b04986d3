/* SPDX-License-Identifier: Apache-2.0 */
#include "render/direct.h"

#include <stdlib.h>

#include "render/pane.h"

/* Runs of cells over the lamps (and their triangles), a square grid of places each. Four neighbouring runs are shifted
 * against each other so that they interleave to a grid twice as fine: midpoints of equal cells, which integrate a
 * smooth lobe far better than scattered points. */
enum { RUNS = 8, SIDE = 6, CELLS = RUNS * SIDE * SIDE };

/* An environment alone has the same cells everywhere. */
enum { SKY_CELLS = 512 };
#define MOST_CELLS SKY_CELLS /* of the two */

/* Shadow rays where light comes from one side of an edge. */
enum { MOST_RAYS = 128, REFINE = 6 };

/* Lobes narrower than this, rad, aren't resolved: n = 300. */
#define LEAST_WIDTH .08f
/* A lamp that fills more of what a point sees, sr, has cells that are too wide. */
#define MOST_SOLID_ANGLE 1.0f

/* Light that is as good as none, W/m2/sr: it has no reciprocal. */
#define DARK 1e-20f

bool direct_resolves(const struct lobe *lobe)
{
    bool known = lobe->type <= LOBE_METAL && !lobe->beckmann;
    return known && lobe_width(lobe) >= LEAST_WIDTH;
}

int direct_sort(struct brdf *brdf)
{
    int count = 0;
    for (int i = 0; i < brdf->lobe_count; i++) {
        if (!direct_resolves(&brdf->lobes[i])) continue;
        if (i > count) {
            struct lobe lobe = brdf->lobes[count];
            brdf->lobes[count] = brdf->lobes[i];
            brdf->lobes[i] = lobe;
        }
        count++;
    }
    return count;
}

bool direct_averages(const struct direct *direct, const struct point *point)
{
    if (point->brdf.lobe_count == 0) return true; /* nothing to average, and no lamp to look at for it */
    if (direct->points_only) return true;
    return lights_widest(direct->model->lights, point->origin) < MOST_SOLID_ANGLE;
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

bool direct_prepare(const struct model *model, const struct mean_brdf *tables, bool points_only, struct direct *direct)
{
    *direct = (struct direct){.model = model, .tables = tables, .points_only = points_only};
    direct->idle = points_only && !lights_any_points(model->lights);
    if (points_only) return true;
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

/* Adds to f_cos, one a cell, the mean over the cell of all lobes' f cos. */
static void add_lobes(const struct brdf *brdf, const struct mean_lobe *lobes, const struct cell *cells, int count,
                      rgb *f_cos)
{
    struct cap caps[MOST_CELLS];
    rgb values[MOST_CELLS];
    for (int i = 0; i < count; i++) caps[i] = (struct cap){cells[i].wi, cells[i].omega};
    for (int k = 0; k < brdf->lobe_count; k++) {
        const struct mean_lobe *m = &lobes[k];
        mean_lobe_caps(m, caps, count, values);
        for (int i = 0; i < count; i++) {
            if (caps[i].omega > 1e-6f) f_cos[i] = mad(f_cos[i], values[i], 1 / caps[i].omega);
            else
                f_cos[i] =
                    mad(f_cos[i], lobe_eval(m->lobe, m->n, m->wo, caps[i].axis), maxf(dot(caps[i].axis, m->n), 0));
        }
    }
}

static void prepare_lobes(const struct direct *direct, const struct point *point, struct mean_lobe lobes[BRDF_LOBES])
{
    for (int i = 0; i < point->brdf.lobe_count; i++)
        lobes[i] = mean_lobe(direct->tables, &point->brdf.lobes[i], point->n, point->wo);
}

/* direct_sample on one side. */
static rgb sample_side(const struct direct *direct, const struct point *point, bool beyond, const float u[static 3],
                       int averaged)
{
    const struct brdf *brdf = &point->brdf;
    const struct side side = shade_side(point, beyond);
    struct light_sample light;
    rgb sum = {0};
    if (!lights_sample(direct->model->lights, side.origin, side.n, u, &light)) return sum;
    if (direct->points_only && light.pdf > 0) return sum;
    float cosine = dot(light.wi, side.n);
    if (cosine <= 0 || dot(light.wi, side.ng) <= 0) return sum;
    if (beyond || !direct->sky) sum = scale(mul(light.weight, beyond ? brdf->kt : brdf->kd), cosine / PI);
    for (int i = averaged; i < brdf->lobe_count; i++) {
        const struct lobe *lobe = &brdf->lobes[i];
        float pdf = lobe_pdf(lobe, point->n, point->wo, light.wi);
        float mis = light.pdf > 0 ? mis_weight(light.pdf, pdf) : 1;
        rgb f = lobe_eval(lobe, point->n, point->wo, light.wi);
        sum = mad(sum, mul(light.weight, f), cosine * mis);
    }
    if (is_black(sum)) return sum;
    return mul(sum, pane_transmittance(direct->model, side.origin, light.wi, light.reach));
}

rgb direct_sample(const struct direct *direct, const struct point *point, const float u[static 3], int averaged)
{
    const struct brdf *brdf = &point->brdf;
    rgb sum = {0};
    if (direct->idle) return sum;
    if (averaged < brdf->lobe_count || (!direct->sky && !is_black(brdf->kd)))
        sum = sample_side(direct, point, false, u, averaged);
    return brdf_spreads(brdf) ? add(sum, sample_side(direct, point, true, u, averaged)) : sum;
}

static rgb ratio(rgb a, rgb b)
{
    return vec3(b.x > 0 ? a.x / b.x : 0, b.y > 0 ? a.y / b.y : 0, b.z > 0 ? a.z / b.z : 0);
}

/* The share of light that comes through from a random place in cell i. */
static rgb cell_lit(const struct direct *direct, const struct point *point, float3 origin, int i,
                     const struct cell *cell, struct rng *rng)
{
    float3 wi = cell->wi;
    float distance = INFINITY, x = rng_float(rng), y = rng_float(rng);
    if (direct->sky) { /* in a square as wide as the cell's cap: of the same second moment */
        float half = .8660254f * sqrtf(cell->omega * (1 / PI));
        struct frame frame = frame_about(wi);
        wi = normalize(mad(mad(wi, frame.t, half * (2 * x - 1)), frame.b, half * (2 * y - 1)));
    } else {
        struct light_sample light;
        if (!lamp_sample_in(direct->model->lights, point, i, x, y, &light) &&
            !lamp_sample_in(direct->model->lights, point, i, .5f, .5f, &light))
            return vec3(0, 0, 0);
        /* Sampled from the mean point: the same place from this origin. */
        float3 to = isinf(light.distance) ? light.wi : sub(mad(point->origin, light.wi, light.distance), origin);
        distance = isinf(light.distance) ? INFINITY : length(to);
        if (light.reach == 0) distance = 0;
        wi = normalize(to);
    }
    return dot(wi, point->ng) > 0 ? pane_transmittance(direct->model, origin, wi, distance) : vec3(0, 0, 0);
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

/* A shadow ray to where the light of all cells, in a row, has reached `at`, in cell `from` or later; its light is
 * counted with `weight`. */
static bool probe(const struct shadow *s, float at, int from, int origin, float weight, rgb *asked, rgb *lit)
{
    while (from + 1 < s->cell_count && s->passed[from + 1] <= at) from++;
    float own = luminance(s->light[from]);
    if (own <= 0) return false; /* rounding: beyond the last */
    rgb share = scale(s->light[from], weight / own);
    rgb through = cell_lit(s->direct, s->point, s->origins[origin % s->origin_count], from, &s->cells[from], s->rng);
    *asked = add(*asked, share);
    *lit = add(*lit, mul(share, through));
    return !is_black(through);
}

/* The share that comes through: a ray for each of `rays` equal strata of the light, whose sum is `sum`; where a
 * stratum's neighbours disagree, REFINE rays instead. Its own first ray has no say in that, which would bias the mean.
 */
static rgb lit_share(const struct shadow *s, float sum, int rays)
{
    rgb asked[MOST_RAYS] = {{0}}, lit[MOST_RAYS] = {{0}}, asked_sum = {0}, lit_sum = {0};
    bool through[MOST_RAYS];
    float step = sum / (float)rays;
    int count = 0, half = rays / 2, from[MOST_RAYS];
    for (int k = 0, cell = 0; k < rays; k++) {
        while (cell + 1 < s->cell_count && s->passed[cell + 1] <= (float)k * step) cell++;
        from[k] = cell;
    }
    for (int i = 0; i < rays; i++) { /* every other stratum first; where those agree the rest would */
        int k = i < half ? 2 * i + 1 : 2 * (i - half);
        if (i == half && !s->direct->model->panes && (count == 0 || count == half)) return scale(vec3(1, 1, 1), count ? 1 : 0);
        through[k] = probe(s, ((float)k + rng_float(s->rng)) * step, from[k], k, 1, &asked[k], &lit[k]);
        count += through[k];
    }
    for (int k = 0; k < rays; k++) {
        int near = 0, of = 0;
        for (int j = k - 4; j <= k + 4; j++)
            if (j != k && j >= 0 && j < rays) near += through[j], of++;
        if (near != 0 && near != of) {
            asked[k] = lit[k] = vec3(0, 0, 0);
            for (int j = 0; j < REFINE; j++)
                probe(s, ((float)k + ((float)j + rng_float(s->rng)) / REFINE) * step, from[k], k + j, 1.0f / REFINE,
                      &asked[k], &lit[k]);
        }
        asked_sum = add(asked_sum, asked[k]);
        lit_sum = add(lit_sum, lit[k]);
    }
    return ratio(lit_sum, asked_sum);
}

rgb direct_light(const struct direct *direct, const struct point *point, bool averages, const float3 *origins,
                 int count, int rays, struct rng *rng)
{
    struct mean_lobe lobes[BRDF_LOBES];
    struct cell cells[MOST_CELLS];
    rgb f_cos[MOST_CELLS], light[MOST_CELLS], total = {0},
                                              diffuse = direct->sky ? scale(point->brdf.kd, 1 / PI) : vec3(0, 0, 0);
    float sum = 0, passed[MOST_CELLS + 1];
    int cell_count = direct->sky ? direct->sky_count : CELLS;
    averages = averages && point->brdf.lobe_count > 0;
    if (direct->idle || (!averages && is_black(diffuse))) return total;
    prepare_lobes(direct, point, lobes);
    for (int i = 0; i < cell_count; i++) {
        f_cos[i] = vec3(0, 0, 0);
        if (direct->sky) {
            const struct environment_cell *sky = &direct->sky[i];
            f_cos[i] = scale(diffuse, sky->spread * maxf(dot(sky->wi, point->n), 0));
            /* The cap whose directions are spread as much: the mean cosine to its axis is 1 - omega/4pi. */
            cells[i] = (struct cell){sky->wi, 4 * PI * (1 - sky->spread), sky->flux};
        } else {
            cells[i] = lamp_cell(direct->model->lights, point, i);
            if (direct->points_only && cells[i].omega > 0) cells[i].weight = vec3(0, 0, 0);
        }
    }
    if (averages) add_lobes(&point->brdf, lobes, cells, cell_count, f_cos);
    for (int i = 0; i < cell_count; i++) {
        light[i] = mul(cells[i].weight, f_cos[i]);
        passed[i] = sum;
        total = add(total, light[i]);
        sum += luminance(light[i]);
    }
    if (sum <= 0) return total;
    struct shadow shadow = {direct, point, origins, count, cell_count, cells, light, passed, rng};
    return mul(total, lit_share(&shadow, sum, rays));
}
