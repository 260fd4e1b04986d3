/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/lobe_fit.h"

#include <nlopt.h>
#include <stdlib.h>

/* Viewers: rings about the cap's mirror direction, which crowd where the lobe is; over half of the azimuths, since F~
 * is the same on both sides of the plane of incidence. */
enum { RINGS = 24, SECTORS = 12 };
/* The searches: evaluations of the global one and of the local one, seed. */
enum { GLOBAL = 300, LOCAL = 200, SEED = 1 };
/* How far the fitted lobe may lean from the mirror direction, rad. */
#define LEAN .6

float lobe_fit_eval(const struct lobe_fit *fit, float3 wi, float3 wo)
{
    float c = fit->cx * (wi.x * wo.x + wi.y * wo.y) + fit->cz * wi.z * wo.z;
    return c > 0 ? powf(c, fit->exponent) : 0;
}

float lobe_fit_exact(const struct lobe *lobe, float3 wi, float omega, float3 wo, int steps)
{
    rgb integral = mean_lobe_quadrature(lobe, vec3(0, 0, 1), wo, (struct cap){wi, omega}, steps, steps);
    return luminance(integral) / lobe_fit_cosine(wi, omega);
}

/* What a lobe is fitted to: F~ at viewers, each with its solid angle. */
struct target {
    int count;
    double squares; /* the sum of F~^2 */
    float3 wo[RINGS * SECTORS];
    float value[RINGS * SECTORS], weight[RINGS * SECTORS];
};

static float3 in_plane(double theta) { return vec3((float)sin(theta), 0, (float)cos(theta)); }

static void sample(const struct lobe *lobe, float theta, float omega, struct target *target)
{
    struct frame mirror = frame_about(in_plane(-theta));
    float radius = sqrtf(omega / PI), width = lobe_width(lobe) + radius, turns = atanf(PI / width);
    int steps = (int)minf(8 + 5 * radius / lobe_width(lobe), 24);
    target->count = 0;
    target->squares = 0;
    for (int i = 0; i < RINGS; i++)
        for (int j = 0; j < SECTORS; j++) {
            float s = turns * ((float)i + .5f) / RINGS, r = width * tanf(s), phi = PI * ((float)j + .5f) / SECTORS;
            float3 wo = to_world(mirror, vec3(sinf(r) * cosf(phi), sinf(r) * sinf(phi), cosf(r)));
            if (wo.z <= 0) continue;
            int k = target->count++;
            target->wo[k] = wo;
            target->weight[k] = sinf(r) * width / sqr(cosf(s));
            target->value[k] = lobe_fit_exact(lobe, in_plane(theta), omega, wo, steps);
            target->squares += target->weight[k] * sqr(target->value[k]);
        }
}

/* The squared error of the lobe A max(0, d.wo)^n, d in the plane of incidence: x is d's angle from n, on the side of
 * the mirror direction, and log n; the best A, in closed form, goes to *amplitude. */
static double lobe_error(const struct target *target, const double x[2], double *amplitude)
{
    float3 d = in_plane(-x[0]);
    float exponent = (float)exp(x[1]);
    double product = 0, squares = 1e-30;
    for (int k = 0; k < target->count; k++) {
        float c = dot(d, target->wo[k]), g = c > 0 ? powf(c, exponent) : 0;
        product += target->weight[k] * g * target->value[k];
        squares += target->weight[k] * g * g;
    }
    *amplitude = product / squares;
    return target->squares - product * product / squares;
}

static double objective(unsigned n, const double *x, double *gradient, void *target)
{
    double amplitude;
    (void)n, (void)gradient;
    return lobe_error(target, x, &amplitude);
}

static bool search(nlopt_algorithm algorithm, int evaluations, const double low[2], const double high[2],
                   struct target *target, double x[2])
{
    double least;
    nlopt_opt opt = nlopt_create(algorithm, 2);
    bool good = opt && nlopt_set_lower_bounds(opt, low) > 0 && nlopt_set_upper_bounds(opt, high) > 0 &&
                nlopt_set_min_objective(opt, objective, target) > 0 && nlopt_set_maxeval(opt, evaluations) > 0 &&
                nlopt_set_xtol_rel(opt, 1e-5) > 0 && nlopt_optimize(opt, x, &least) > 0;
    nlopt_destroy(opt);
    return good;
}

bool lobe_fit(const struct lobe *lobe, float theta, float omega, struct lobe_fit *fit)
{
    struct target target;
    sample(lobe, theta, maxf(omega, 1e-6f), &target);
    /* From a hemisphere wide to half as wide as the lobe. */
    double low[2] = {theta - LEAN, 0}, high[2] = {theta + LEAN, log(8 / sqr(lobe_width(lobe)))}, amplitude;
    double x[2] = {theta, .5 * high[1]};
    nlopt_srand(SEED);
    if (!search(NLOPT_GN_CRS2_LM, GLOBAL, low, high, &target, x) ||
        !search(NLOPT_LN_SBPLX, LOCAL, low, high, &target, x))
        return false;
    lobe_error(&target, x, &amplitude);
    double exponent = exp(x[1]), length = pow(amplitude, 1 / exponent);
    *fit = (struct lobe_fit){(float)(-length * sin(x[0]) / sin(theta)), (float)(length * cos(x[0]) / cos(theta)),
                             (float)exponent};
    return true;
}

static float theta_at(const struct lobe_fit_table *table, int i) { return PI / 2 * (float)i / (float)table->thetas; }

/* Omega of one cell of row i. */
static float omega_step(const struct lobe_fit_table *table, int i)
{
    return 2 * PI * (1 - sinf(theta_at(table, i))) / (float)table->omegas;
}

static struct lobe_fit *row_at(const struct lobe_fit_table *table, int i)
{
    return table->fits + (i - 1) * (table->omegas + 1);
}

bool lobe_fit_table_build(const struct lobe *lobe, int thetas, int omegas, struct lobe_fit_table *table)
{
    *table = (struct lobe_fit_table){thetas, omegas, NULL};
    table->fits = malloc((size_t)(thetas - 1) * (size_t)(omegas + 1) * sizeof *table->fits);
    bool good = table->fits != NULL;
    for (int i = 1; i < thetas && good; i++)
        for (int j = 0; j <= omegas && good; j++)
            good = lobe_fit(lobe, theta_at(table, i), (float)j * omega_step(table, i), &row_at(table, i)[j]);
    if (!good) lobe_fit_table_free(table);
    return good;
}

static struct lobe_fit mix(struct lobe_fit a, struct lobe_fit b, float t)
{
    return (struct lobe_fit){a.cx + t * (b.cx - a.cx), a.cz + t * (b.cz - a.cz),
                             a.exponent + t * (b.exponent - a.exponent)};
}

static struct lobe_fit row_mix(const struct lobe_fit_table *table, int i, float omega)
{
    const struct lobe_fit *row = row_at(table, i);
    float y = clampf(omega / omega_step(table, i), 0, (float)table->omegas);
    int j = (int)minf(y, (float)table->omegas - 1);
    return mix(row[j], row[j + 1], y - (float)j);
}

struct lobe_fit lobe_fit_table_at(const struct lobe_fit_table *table, float theta, float omega)
{
    float x = clampf(theta / (PI / 2) * (float)table->thetas, 1, (float)table->thetas - 1);
    int i = (int)minf(x, (float)table->thetas - 2);
    return mix(row_mix(table, i, omega), row_mix(table, i + 1, omega), x - (float)i);
}

void lobe_fit_table_free(struct lobe_fit_table *table)
{
    free(table->fits);
    *table = (struct lobe_fit_table){0};
}
