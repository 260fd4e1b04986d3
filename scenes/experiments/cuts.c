/* SPDX-License-Identifier: Apache-2.0 */
#include "scenes/experiments/cuts.h"

#include <stdio.h>

#include "eas/lobe_fit.h"

/* Steps of the quadrature; the table's cells, so many that the interpolation errs little beside the fit. */
enum { STEPS = 64, THETAS = 6, OMEGAS = 256, EXPONENT_COUNT = 3 };

static const float EXPONENTS[EXPONENT_COUNT] = {40, 100, 200}, OMEGA[] = {PI / 120, PI / 60, PI / 30, PI / 15};
static const float THETA[] = {15, 45, 60, 75}; /* degrees */

struct cut {
    struct lobe lobe;
    const struct mean_brdf *tables;
    float theta, omega;
    float3 wi;
    struct lobe_fit fit;
};

static float3 in_plane(float angle) { return vec3(sinf(angle), 0, cosf(angle)); }

/* One cut by whole degrees; returns the viewer of the largest exact value. */
static float3 print_cut(const struct cut *cut, const char *name, float3 from, float3 towards)
{
    const float degree = PI / 180;
    float largest = -1;
    float3 peak = from;
    for (int angle = -89; angle <= 89; angle++) {
        float3 wo = mad(scale(from, cosf((float)angle * degree)), towards, sinf((float)angle * degree));
        struct mean_lobe mean = mean_lobe(cut->tables, &cut->lobe, vec3(0, 0, 1), wo);
        float exact = lobe_fit_exact(&cut->lobe, cut->wi, cut->omega, wo, STEPS);
        float value = luminance(mean_lobe_cap(&mean, (struct cap){cut->wi, cut->omega}));
        printf("%g,%g,%g,%s,%d,%g,%g,%g\n", cut->lobe.exponent, cut->theta, cut->omega, name, angle, exact,
               value / lobe_fit_cosine(cut->wi, cut->omega), lobe_fit_eval(&cut->fit, cut->wi, wo));
        if (exact > largest) {
            largest = exact;
            peak = wo;
        }
    }
    return peak;
}

/* An exponent's lobe and the paper's table for it. */
struct fitted {
    struct lobe lobe;
    struct lobe_fit_table table;
    bool good;
};

static struct fitted fit(float exponent)
{
    struct fitted fitted = {.lobe = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), exponent).lobes[0]};
    fitted.good = lobe_fit_table_build(&fitted.lobe, THETAS, OMEGAS, &fitted.table);
    return fitted;
}

static void print_exponent(const struct mean_brdf *tables, const struct fitted *fitted)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            float theta = THETA[j] * PI / 180;
            struct cut cut = {fitted->lobe, tables,          THETA[j],
                              OMEGA[i],     in_plane(theta), lobe_fit_table_at(&fitted->table, theta, OMEGA[i])};
            float3 peak = print_cut(&cut, "V1", vec3(0, 0, 1), vec3(-1, 0, 0));
            print_cut(&cut, "V2", peak, vec3(0, 1, 0));
        }
}

bool cuts_print(void)
{
    struct mean_brdf *tables = mean_brdf_build();
    struct fitted fitted[EXPONENT_COUNT];
    bool good = tables != NULL;
#pragma omp parallel for schedule(dynamic, 1)
    for (int k = 0; k < EXPONENT_COUNT; k++) fitted[k] = fit(EXPONENTS[k]);
    for (int k = 0; k < EXPONENT_COUNT; k++) good = good && fitted[k].good;
    if (good) printf("n,theta,omega,cut,angle,exact,default,fit\n");
    for (int k = 0; good && k < EXPONENT_COUNT; k++) print_exponent(tables, &fitted[k]);
    for (int k = 0; k < EXPONENT_COUNT; k++) lobe_fit_table_free(&fitted[k].table);
    mean_brdf_free(tables);
    return good;
}
