/* SPDX-License-Identifier: Apache-2.0 */
/* The mean BRDF's tables against quadrature of the BRDF itself. Errors are relative to the lobe's largest value over viewers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <stdio.h>
#include <cmocka.h>

#include "eas/mean_brdf.h"

static struct lobe phong(float exponent)
{
    return brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), exponent).lobes[0];
}

static float3 direction(float elevation, float azimuth)
{
    return vec3(cosf(elevation) * cosf(azimuth), cosf(elevation) * sinf(azimuth), sinf(elevation));
}

/* The largest error over viewers spread about the mirror direction of a cap at `elevation`, over the largest value. */
static float worst_error(const struct mean_brdf *tables, float exponent, float elevation, float theta)
{
    struct lobe lobe = phong(exponent);
    float3 n = vec3(0, 0, 1);
    struct cap cap = {direction(elevation, 0), 4 * PI * sqr(sinf(theta / 2))};
    float largest = 0, error = 0;
    for (int i = -8; i <= 8; i++)
        for (int j = 0; j <= 6; j++) {
            float spread = theta + 3 / sqrtf(exponent), up = elevation + spread * (float)i / 8;
            if (up <= .02f || up >= PI / 2)
                continue;
            float3 wo = direction(up, PI + spread * (float)j / 6);
            struct mean_lobe mean = mean_lobe(tables, &lobe, n, wo);
            float exact = mean_lobe_quadrature(&lobe, n, wo, cap, 160, 160).x;
            largest = fmaxf(largest, exact);
            error = fmaxf(error, fabsf(mean_lobe_cap(&mean, cap).x - exact));
        }
    return error / largest;
}

static void test_phong_above_horizon(void **state)
{
    const float exponents[] = {5, 12, 40, 100, 200, 700}, elevations[] = {.5f, .9f, 1.4f};
    const float thetas[] = {.01f, .05f, .12f, .35f};
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 4; k++) {
                float error = worst_error(*state, exponents[i], elevations[j], thetas[k]);
                if (error > 8e-3f)
                    fail_msg("n = %g, elevation %g, cap %g rad: error %g of the peak", exponents[i], elevations[j], thetas[k],
                             error);
            }
}

static void test_phong_across_horizon(void **state)
{
    const float exponents[] = {5, 40, 200}, elevations[] = {.05f, .2f};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 2; j++) {
            float error = worst_error(*state, exponents[i], elevations[j], .3f);
            if (error > .2f)
                fail_msg("n = %g, elevation %g, cap .3 rad: error %g of the peak", exponents[i], elevations[j], error);
        }
}

/* GGX by points of the cap: within 5 % of its peak where the cap is narrower than the lobe. */
static void test_ggx(void **state)
{
    struct principled metal = {.base_colour = {1, 1, 1}, .specular_tint = {1, 1, 1}, .metallic = 1, .ior = 1.5f,
                               .specular_level = .5f};
    float3 n = vec3(0, 0, 1);
    const float roughness[] = {.3f, .5f}, thetas[] = {.01f, .06f, .12f};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++) {
            struct cap cap = {direction(.9f, 0), 4 * PI * sqr(sinf(thetas[k] / 2))};
            float largest = 0, error = 0;
            metal.roughness = roughness[i];
            for (int j = -8; j <= 8; j++) {
                float3 wo = direction(.9f + .05f * (float)j, PI + .02f * (float)j);
                struct brdf brdf = brdf_principled(&metal, wo.z);
                struct mean_lobe mean = mean_lobe(*state, &brdf.lobes[0], n, wo);
                float exact = mean_lobe_quadrature(&brdf.lobes[0], n, wo, cap, 64, 64).x;
                largest = fmaxf(largest, exact);
                error = fmaxf(error, fabsf(mean_lobe_cap(&mean, cap).x - exact));
            }
            if (error > .05f * largest)
                fail_msg("roughness %g, cap %g rad: error %g of the peak", roughness[i], thetas[k], error / largest);
        }
}

static int setup(void **state) { return (*state = mean_brdf_build()) ? 0 : -1; }
static int teardown(void **state) { return mean_brdf_free(*state), 0; }

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_phong_above_horizon), cmocka_unit_test(test_phong_across_horizon),
                                       cmocka_unit_test(test_ggx)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
