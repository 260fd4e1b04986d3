/* SPDX-License-Identifier: Apache-2.0 */
/* The mean BRDF of modified Phong against quadrature of the BRDF itself; mean_ggx_test.c has GGX. Errors are relative
 * to the integral's largest value over viewers spread about the cap's mirror direction. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "eas/mean_brdf.h"
#include "tests/caps.h"

static const float3 N = {0, 0, 1};

/* The largest error over viewers within `spread` of the mirror direction of the cap's axis, over the largest value. */
static float worst_error(const struct mean_brdf *tables, const struct lobe *lobe, struct cap cap, float spread,
                         int steps)
{
    float largest = 0, error = 0, elevation = asinf(cap.axis.z);
    for (int i = -5; i <= 5; i++)
        for (int j = 0; j <= 3; j++) {
            float up = elevation + spread * (float)i / 5;
            if (up <= .02f || up >= PI / 2) continue;
            float3 wo = direction(up, PI + spread * (float)j / (3 * cosf(up)));
            struct mean_lobe mean = mean_lobe(tables, lobe, N, wo);
            float exact = mean_lobe_quadrature(lobe, N, wo, cap, steps, steps).x;
            largest = maxf(largest, exact);
            error = maxf(error, fabsf(mean_lobe_cap(&mean, cap).x - exact));
        }
    return error / largest;
}

/* Modified Phong over caps of `elevation` in radii (radii false: rad). */
static void check_phong(const struct mean_brdf *tables, float exponent, float elevation, float theta, float tolerance)
{
    struct brdf brdf = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), exponent);
    float sigma = 1 / sqrtf(exponent + 1);
    float error =
        worst_error(tables, &brdf.lobes[0], cap_at(elevation, theta), theta + 3 * sigma, theta > 3 * sigma ? 96 : 48);
    if (!(error <= tolerance))
        fail_msg("n = %g, elevation %g, cap %g rad: error %g of the peak", exponent, elevation, theta, error);
}

static void test_phong_above_horizon(void **state)
{
    const float exponents[] = {5, 8, 20, 100, 300, 1000}, elevations[] = {.4f, .9f, 1.5f};
    const float thetas[] = {.005f, .05f, .12f, .35f};
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 4; k++) check_phong(*state, exponents[i], elevations[j], thetas[k], 2.5e-3f);
}

static void test_phong_across_horizon(void **state)
{
    const float exponents[] = {5, 40, 200, 1000}, thetas[] = {.02f, .1f, .3f}, radii[] = {-.8f, -.4f, 0, .3f, .7f};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 5; k++) check_phong(*state, exponents[i], radii[k] * thetas[j], thetas[j], .02f);
}

/* Wide caps: EAS at contacts. The widest is the hemisphere itself. */
static void test_phong_wide(void **state)
{
    const float exponents[] = {5, 40, 300}, elevations[] = {.1f, .7f, 1.5f};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            check_phong(*state, exponents[i], elevations[j], .7f, .035f);
            check_phong(*state, exponents[i], elevations[j], 1.3f, .035f);
        }
    for (int i = 0; i < 3; i++) check_phong(*state, exponents[i], 1.57079f, 1.57079f, .035f);
}

/* A viewer below the horizon sees nothing; a cap below it sends nothing; an empty one neither. */
static void test_nothing(void **state)
{
    struct brdf brdf = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), 20);
    struct principled metal = {{1, 1, 1}, {1, 1, 1}, 1, .4f, 1.5f, .5f};
    struct brdf ggx = brdf_principled(&metal, .5f);
    const struct lobe *lobes[] = {&brdf.lobes[0], &ggx.lobes[0]};
    for (int i = 0; i < 2; i++) {
        struct mean_lobe above = mean_lobe(*state, lobes[i], N, direction(.3f, PI));
        struct mean_lobe below = mean_lobe(*state, lobes[i], N, direction(-.1f, PI));
        assert_true(mean_lobe_cap(&above, cap_at(.1f, .2f)).x > 0);
        assert_true(mean_lobe_cap(&below, cap_at(.1f, .2f)).x == 0);
        assert_true(mean_lobe_cap(&below, cap_at(.5f, .2f)).x == 0);
        assert_true(mean_lobe_cap(&above, cap_at(-.21f, .2f)).x == 0);
        assert_true(mean_lobe_cap(&above, cap_at(-.19f, .2f)).x >= 0);
        assert_true(mean_lobe_cap(&above, cap_at(.3f, 0)).x == 0);
    }
}

static int setup(void **state) { return (*state = mean_brdf_build()) ? 0 : -1; }
static int teardown(void **state) { return mean_brdf_free(*state), 0; }

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_phong_above_horizon),
                                       cmocka_unit_test(test_phong_across_horizon), cmocka_unit_test(test_phong_wide),
                                       cmocka_unit_test(test_nothing)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
