/* SPDX-License-Identifier: Apache-2.0 */
#include "render/direct.h"

#include <stdlib.h>

#include "render/pane.h"

/* Runs of cells over the lamps (and their triangles), a square grid of places each. Four neighbouring runs are shifted
 * against each other so that they interleave to a grid twice as fine: midpoints of equal cells, which integrate a
 * smooth lobe far better than scattered points. */
enum { RUNS = 8, SIDE = 6, LAMP_CELLS = RUNS * SIDE * SIDE };

enum { MOST_RAYS = 1024 }; /* shadow rays of a look-up */

/* Under a sky points whose light is bright get more of them, up to BRIGHT times as many, since it is their noise that a
 * picture shows: by light over the sky's flux times DIM. */
#define BRIGHT 6.0f
#define DIM (1.0f / 32)

/* A cell is in doubt once a shadow ray finds what the last one there didn't, until so many have found the same. The
 * light of others gets this share of the rays. Each kind is scaled by itself by what its rays find. */
enum { LIT, DARK, DOUBTFUL, KINDS };
enum { DOUBTS = 4 };
#define CALM .2f

/* Lobes narrower than this, rad, aren't resolved: n = 300. */
#define LEAST_WIDTH .08f
/* A smaller cell, sr, is a direction. */
#define LEAST_CAP 1e-6f
/* A lamp that fills more of what a point sees, sr, has cells that are too wide. */
#define MOST_SOLID_ANGLE 1.0f
/* Where one fills this, one cell of so many (prime to SIDE) is looked at: highlights of which this share lies in cells
 * whose radius is over this part of the lobe's width aren't averaged. */
enum { WATCHED_CELLS = 5 };
#define WATCHED_SOLID_ANGLE .1f
#define MOST_COARSE .1f
#define COARSE_WIDTH .25f

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

bool direct_near(const struct model *model, const struct point *point)
{
    return lights_widest(model->lights, point->origin) >= MOST_SOLID_ANGLE;
}

rgb direct_met(const struct model *model, const struct point *point, const float u[static 2])
{
    const struct lights *lights = model->lights;
    struct ray ray = {point->origin, cosine_direction(point->n, u)};
    float pdf = dot(ray.dir, point->n) / PI, travelled = 0, pdf_light;
    rgb met = {0}, nearer = {0}, passed = {1, 1, 1};
    if (is_black(point->brdf.kd) || !(pdf > 0) || dot(ray.dir, point->ng) <= 0) return met;
    while (!is_black(passed)) { /* straight through panes */
        struct hit hit;
        bool found = trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit);
        hit.t = found ? hit.t + travelled : INFINITY;
        rgb lamps = lights_radiance_lamps(lights, point->origin, point->n, ray.dir, hit.t, pdf, NULL);
        met = add(met, mul(passed, sub(lamps, nearer)));
        nearer = lamps;
        if (!found) {
            rgb strong = lights_strong(lights, point->origin, point->n, ray.dir, &pdf_light);
            met = add(met, scale(mul(passed, strong), mis_weight(pdf, pdf_light)));
            break;
        }
        struct point at;
        shade_point(model, ray, &hit, &at);
        pdf_light = lights_pdf_hit(lights, point->origin, point->n, ray.dir, &hit, at.ng);
        met = add(met, scale(mul(passed, at.emission), mis_weight(pdf, pdf_light)));
        passed = mul(passed, at.brdf.through);
        ray.origin = shade_origin(&at, ray.dir);
        travelled = hit.t;
    }
    return mul(point->brdf.kd, met);
}

/* Parts of the lamps, as a point sees them. */
struct cells {
    int count;
    struct cap caps[DIRECT_CELLS]; /* omega 0: a point */
    float flux[3][DIRECT_CELLS];   /* radiance x omega by channel, W/m2 before the cosine */
};

/* Cell i of LAMP_CELLS by the light sample at the place (x, y) in it, .5 each: its middle. */
static bool lamp_sample_in(const struct light_weights *weights, int i, float x, float y, struct light_sample *light)
{
    int run = i / (SIDE * SIDE), row = i / SIDE % SIDE, column = i % SIDE;
    /* The runs' shifts interleave their middles; jittered places wrap within the run's square. */
    float v = ((float)row + y + (run & 1 ? .25f : -.25f)) / (float)SIDE,
          w = ((float)column + x + (run & 2 ? .25f : -.25f)) / (float)SIDE;
    float u[3] = {((float)i + .5f) / (float)LAMP_CELLS, v - floorf(v), w - floorf(w)};
    return lights_sample_weighed(weights, u, light);
}

static inline void set_channels(float channels[3][DIRECT_CELLS], int i, rgb value)
{
    channels[0][i] = value.x;
    channels[1][i] = value.y;
    channels[2][i] = value.z;
}

/* Every step-th cell; weights: at the point. */
static void lamp_cells(const struct direct *direct, const struct light_weights *weights, int step, struct cells *cells)
{
    cells->count = (LAMP_CELLS + step - 1) / step;
    for (int i = 0; i < cells->count; i++) {
        struct light_sample light;
        bool any = lamp_sample_in(weights, i * step, .5f, .5f, &light);
        float omega = any && light.pdf > 0 ? minf(1 / (light.pdf * (float)LAMP_CELLS), 2 * PI) : 0;
        any = any && (omega == 0 || !direct->points_only);
        cells->caps[i] = (struct cap){any ? light.wi : weights->n, omega};
        rgb flux = any ? scale(light.weight, 1 / (float)LAMP_CELLS) : vec3(0, 0, 0);
        set_channels(cells->flux, i, flux);
    }
}

/* The cells about each: in the sky the nearest, of lamps those beside it. */
static void find_neighbours(const struct cells *sky, uint16_t neighbours[DIRECT_CELLS][DIRECT_NEIGHBOURS])
{
    for (int i = 0; i < DIRECT_CELLS; i++) {
        const int beside[DIRECT_NEIGHBOURS] = {i - 1, i + 1, i - SIDE, i + SIDE, i - SIDE * SIDE, i + SIDE * SIDE};
        float cosines[DIRECT_NEIGHBOURS] = {-2, -2, -2, -2, -2, -2};
        for (int k = 0; k < DIRECT_NEIGHBOURS; k++)
            neighbours[i][k] = (uint16_t)(beside[k] >= 0 && beside[k] < DIRECT_CELLS ? beside[k] : i);
        for (int j = 0; sky && i < sky->count && j < sky->count; j++) {
            float cosine = j == i ? -2 : dot(sky->caps[i].axis, sky->caps[j].axis);
            int at = DIRECT_NEIGHBOURS;
            while (at > 0 && cosine > cosines[at - 1]) at--;
            if (at == DIRECT_NEIGHBOURS) continue;
            for (int k = DIRECT_NEIGHBOURS - 1; k > at; k--) {
                cosines[k] = cosines[k - 1];
                neighbours[i][k] = neighbours[i][k - 1];
            }
            cosines[at] = cosine;
            neighbours[i][at] = (uint16_t)j;
        }
    }
}

/* The cells of an environment alone; sky->count 0: there are other lamps. False: no memory. */
static bool find_sky(const struct model *model, struct cells *sky, float3 *places)
{
    struct environment_cell *cells = malloc(DIRECT_CELLS * sizeof *cells);
    sky->count = cells ? lights_cells(model->lights, DIRECT_CELLS, cells, places) : -1;
    for (int i = 0; i < sky->count; i++) {
        /* The cap whose directions are spread as much: the mean cosine to its axis is 1 - omega/4pi. */
        sky->caps[i] = (struct cap){cells[i].wi, 4 * PI * (1 - cells[i].spread)};
        set_channels(sky->flux, i, cells[i].flux);
    }
    free(cells);
    return sky->count >= 0;
}

bool direct_prepare(const struct model *model, const struct mean_brdf *tables, bool points_only, struct direct *direct)
{
    *direct = (struct direct){.model = model, .tables = tables, .points_only = points_only};
    direct->idle = points_only && !lights_any_points(model->lights);
    if (direct->idle) return true;
    direct->neighbours = malloc(DIRECT_CELLS * sizeof *direct->neighbours);
    struct cells *sky = calloc(1, sizeof *sky);
    float3 *places = malloc(DIRECT_CELLS * ENVIRONMENT_PLACES * sizeof *places);
    bool ok = direct->neighbours && sky && places && (points_only || find_sky(model, sky, places));
    if (ok && sky->count > 0) {
        direct->sky = sky;
        direct->places = places;
        for (int i = 0; i < sky->count; i++)
            direct->sky_flux += luminance(vec3(sky->flux[0][i], sky->flux[1][i], sky->flux[2][i]));
    } else {
        free(sky);
        free(places);
    }
    if (ok) find_neighbours(direct->sky, direct->neighbours);
    else direct_free(direct);
    return ok;
}

void direct_free(struct direct *direct)
{
    free(direct->neighbours);
    free(direct->sky);
    free(direct->places);
    *direct = (struct direct){0};
}

void direct_forget(struct shadow_memory *memory)
{
    for (int i = 0; i < DIRECT_CELLS; i++) {
        memory->doubt[i] = 1;
        memory->lit[i] = true;
    }
}

/* What the point reflects of each cell unshadowed, by channel: the mean over the cell of f cos, of the diffuse part kd
 * and, if `lobes`, of the lobes. */
static void reflect_cells(const struct direct *direct, const struct point *point, rgb kd, bool lobes,
                          const struct cells *cells, float light[3][DIRECT_CELLS])
{
    const int count = cells->count;
    const float3 n = point->n;
    float f_cos[3][DIRECT_CELLS], per_omega[DIRECT_CELLS];
    rgb values[DIRECT_CELLS];
#pragma omp simd
    for (int i = 0; i < count; i++) {
        struct cap cap = cells->caps[i];
        float cosine = maxf(cap.axis.x * n.x + cap.axis.y * n.y + cap.axis.z * n.z, 0);
        float mean = (1 / PI) * cosine * (1 - cap.omega * (1 / (4 * PI)));
        f_cos[0][i] = kd.x * mean;
        f_cos[1][i] = kd.y * mean;
        f_cos[2][i] = kd.z * mean;
        per_omega[i] = cap.omega > LEAST_CAP ? 1 / cap.omega : 0;
    }
    for (int k = 0; lobes && k < point->brdf.lobe_count; k++) {
        struct mean_lobe lobe = mean_lobe(direct->tables, &point->brdf.lobes[k], n, point->wo);
        mean_lobe_caps(&lobe, cells->caps, count, values);
#pragma omp simd
        for (int i = 0; i < count; i++) {
            f_cos[0][i] += values[i].x * per_omega[i];
            f_cos[1][i] += values[i].y * per_omega[i];
            f_cos[2][i] += values[i].z * per_omega[i];
        }
        for (int i = 0; i < count; i++) {
            struct cap cap = cells->caps[i];
            if (cap.omega > LEAST_CAP || dot(cap.axis, n) <= 0) continue;
            rgb f = scale(lobe_eval(lobe.lobe, n, lobe.wo, cap.axis), dot(cap.axis, n));
            set_channels(f_cos, i, add(vec3(f_cos[0][i], f_cos[1][i], f_cos[2][i]), f));
        }
    }
    for (int c = 0; c < 3; c++)
#pragma omp simd
        for (int i = 0; i < count; i++) light[c][i] = f_cos[c][i] * cells->flux[c][i];
}

bool direct_averages(const struct direct *direct, const struct point *point)
{
    if (point->brdf.lobe_count == 0) return true; /* nothing to average, and no lamp to look at for it */
    if (direct->points_only || direct->sky) return true;
    float widest = lights_widest(direct->model->lights, point->origin);
    if (widest < WATCHED_SOLID_ANGLE || widest >= MOST_SOLID_ANGLE) return widest < MOST_SOLID_ANGLE;
    float narrowest = PI, sum = 0, coarse = 0;
    for (int i = 0; i < point->brdf.lobe_count; i++) narrowest = minf(narrowest, lobe_width(&point->brdf.lobes[i]));
    float most = PI * sqr(COARSE_WIDTH * narrowest); /* sr */
    struct light_weights weights;
    struct cells cells;
    float light[3][DIRECT_CELLS];
    lights_weigh(direct->model->lights, point->origin, point->n, &weights);
    lamp_cells(direct, &weights, WATCHED_CELLS, &cells);
    reflect_cells(direct, point, vec3(0, 0, 0), true, &cells, light);
#pragma omp simd reduction(+ : sum, coarse)
    for (int i = 0; i < cells.count; i++) {
        float value = light[0][i] + light[1][i] + light[2][i];
        sum += value;
        coarse += cells.caps[i].omega > most ? value : 0;
    }
    return coarse <= MOST_COARSE * sum;
}

/* direct_sample on one side; weights: NULL, or those there. */
static rgb sample_side(const struct direct *direct, const struct point *point, bool beyond,
                       const struct light_weights *weights, const float u[static 3], int averaged, bool near)
{
    const struct brdf *brdf = &point->brdf;
    const struct side side = shade_side(point, beyond);
    struct light_sample light;
    rgb sum = {0};
    bool any = weights ? lights_sample_weighed(weights, u, &light)
                       : lights_sample(direct->model->lights, side.origin, side.n, u, &light);
    if (!any) return sum;
    if (direct->points_only && light.pdf > 0) return sum;
    float cosine = dot(light.wi, side.n);
    if (cosine <= 0 || dot(light.wi, side.ng) <= 0) return sum;
    if (beyond) sum = scale(mul(light.weight, brdf->kt), cosine / PI);
    else if (!direct->sky) sum = scale(mul(light.weight, brdf->kd), cosine / PI * direct_weight(near, &light, cosine));
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

rgb direct_sample(const struct direct *direct, const struct point *point, const struct light_weights *weights,
                  const float u[static 3], int averaged, bool near)
{
    const struct brdf *brdf = &point->brdf;
    rgb sum = {0};
    if (direct->idle) return sum;
    if (averaged < brdf->lobe_count || (!direct->sky && !is_black(brdf->kd)))
        sum = sample_side(direct, point, false, weights, u, averaged, near);
    return brdf_spreads(brdf) ? add(sum, sample_side(direct, point, true, NULL, u, averaged, false)) : sum;
}

/* Alike points that look at cells; `point` is their mean. */
struct look {
    const struct direct *direct;
    const struct point *point;
    const struct light_weights *weights; /* at the point; unset under a sky */
    const float3 *origins;
    int origin_count;
};

/* What the lobes reflect of lamp cell i if all of it is like a sample in it. */
static rgb reflect_place(const struct point *point, const struct light_sample *sample)
{
    rgb f = {0};
    for (int i = 0; i < point->brdf.lobe_count; i++)
        f = add(f, lobe_eval(&point->brdf.lobes[i], point->n, point->wo, sample->wi));
    return scale(mul(f, sample->weight), maxf(dot(sample->wi, point->n), 0) / (float)LAMP_CELLS);
}

/* Shadow ray k, to a place in cell i, `along` its light, in [0, 1); *light, the cell's, becomes what it would be if all
 * of a lamp's cell were like that place. False: nothing arrives. */
static bool aim(const struct look *look, int k, int i, float along, struct rng *rng, struct shadow_ray *ray,
                rgb *light)
{
    const struct direct *direct = look->direct;
    const struct point *point = look->point;
    float3 origin = look->origins[k % look->origin_count];
    *ray = (struct shadow_ray){.origin = origin, .tfar = INFINITY};
    if (direct->sky) {
        ray->dir = direct->places[i * ENVIRONMENT_PLACES + (int)(along * ENVIRONMENT_PLACES)];
    } else {
        struct light_sample sample;
        if (!lamp_sample_in(look->weights, i, along, rng_float(rng), &sample) &&
            !lamp_sample_in(look->weights, i, .5f, .5f, &sample))
            return false;
        /* Sampled from the mean point: the same place from this origin. */
        float3 to = isinf(sample.distance) ? sample.wi : sub(mad(point->origin, sample.wi, sample.distance), origin);
        ray->tfar = sample.reach == 0 ? 0 : isinf(sample.distance) ? INFINITY : length(to);
        ray->dir = normalize(to);
        *light = reflect_place(point, &sample);
    }
    return dot(ray->dir, point->ng) > 0;
}

/* What a shadow ray to cell i has found. */
static void remember(const struct direct *direct, struct shadow_memory *memory, int i, bool lit)
{
    if (memory->lit[i] == lit) {
        memory->doubt[i] -= memory->doubt[i] > 0;
        return;
    }
    memory->lit[i] = lit;
    memory->doubt[i] = DOUBTS;
    for (int k = 0; k < DIRECT_NEIGHBOURS; k++) memory->doubt[direct->neighbours[i][k]] = DOUBTS;
}

static rgb ratio(rgb a, rgb b)
{
    return vec3(b.x > 0 ? a.x / b.x : 0, b.y > 0 ? a.y / b.y : 0, b.z > 0 ? a.z / b.z : 0);
}

/* The light of some cells that comes through, by a shadow ray for each of equal strata of it. weights: luminance of
 * each cell's light, 0 of those left out; sum: of the weights. What a ray finds on a lamp is worth what its own
 * place in the cell brings: lobes change within a cell, and shadows that end there would be too dark or too bright. */
static rgb shadowed(const struct look *look, const float light[3][DIRECT_CELLS], const float *weights, float sum,
                    int cell_count, int rays, struct shadow_memory *memory, struct rng *rng)
{
    struct shadow_ray traced[MOST_RAYS];
    rgb shares[MOST_RAYS], through[MOST_RAYS], asked = {0}, lit = {0};
    int cells[MOST_RAYS], count = 0, cell = 0;
    float step = sum / (float)rays, passed = 0;
    for (int k = 0; k < rays; k++) {
        float at = ((float)k + rng_float(rng)) * step;
        while (cell + 1 < cell_count && passed + weights[cell] <= at) passed += weights[cell++];
        if (!(weights[cell] > 0)) break; /* rounding: beyond the last */
        float along = clampf((at - passed) / weights[cell], 0, 0x1.fffffep-1f);
        rgb value = {light[0][cell], light[1][cell], light[2][cell]};
        bool arrives = aim(look, k, cell, along, rng, &traced[count], &value);
        shares[count] = scale(value, step / weights[cell]);
        asked = add(asked, shares[count]);
        cells[count] = cell;
        count += arrives;
    }
    pane_transmittances(look->direct->model, traced, count, through);
    for (int k = 0; k < count; k++) {
        lit = add(lit, mul(shares[k], through[k]));
        remember(look->direct, memory, cells[k], !is_black(through[k]));
    }
    float red = 0, green = 0, blue = 0;
#pragma omp simd reduction(+ : red, green, blue)
    for (int i = 0; i < cell_count; i++) {
        red += weights[i] > 0 ? light[0][i] : 0;
        green += weights[i] > 0 ? light[1][i] : 0;
        blue += weights[i] > 0 ? light[2][i] : 0;
    }
    return mul(vec3(red, green, blue), ratio(lit, asked)); /* exact where all is lit */
}

rgb direct_light(const struct direct *direct, const struct point *point, bool averages, const float3 *origins,
                 int count, int rays, struct shadow_memory *memory, struct rng *rng)
{
    struct light_weights at_point;
    struct cells lamps;
    const struct cells *cells = direct->sky ? direct->sky : &lamps;
    float light[3][DIRECT_CELLS], weights[KINDS][DIRECT_CELLS], lit = 0, dark = 0, doubtful = 0;
    rgb diffuse = direct->sky ? point->brdf.kd : vec3(0, 0, 0), sum = {0};
    averages = averages && point->brdf.lobe_count > 0;
    if (direct->idle || (!averages && is_black(diffuse))) return sum;
    if (!direct->sky) {
        lights_weigh(direct->model->lights, point->origin, point->n, &at_point);
        lamp_cells(direct, &at_point, 1, &lamps);
    }
    reflect_cells(direct, point, diffuse, averages, cells, light);
#pragma omp simd reduction(+ : lit, dark, doubtful)
    for (int i = 0; i < cells->count; i++) {
        float y = .2126f * light[0][i] + .7152f * light[1][i] + .0722f * light[2][i];
        weights[LIT][i] = !memory->doubt[i] && memory->lit[i] ? y : 0;
        weights[DARK][i] = !memory->doubt[i] && !memory->lit[i] ? y : 0;
        weights[DOUBTFUL][i] = memory->doubt[i] ? y : 0;
        lit += weights[LIT][i];
        dark += weights[DARK][i];
        doubtful += weights[DOUBTFUL][i];
    }
    /* The doubt is of other pixels' rays: those of this one have no say in where they go, which would bias the mean. */
    const struct look look = {direct, point, &at_point, origins, count};
    const float sums[KINDS] = {lit, dark, doubtful};
    float all = lit + dark + doubtful, per_light = (float)rays / all;
    if (direct->sky) per_light *= clampf(all / (DIM * direct->sky_flux), 1, BRIGHT);
    for (int kind = 0; kind < KINDS; kind++) {
        if (!(sums[kind] > 0 && per_light < INFINITY)) continue; /* none, or too faint for its reciprocal */
        int asked = (int)minf(ceilf(per_light * sums[kind] * (kind == DOUBTFUL ? 1 : CALM)), MOST_RAYS);
        sum = add(sum, shadowed(&look, light, weights[kind], sums[kind], cells->count, asked, memory, rng));
    }
    return sum;
}
