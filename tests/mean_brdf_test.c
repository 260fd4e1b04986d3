/* SPDX-License-Identifier: Apache-2.0 */
/* The mean BRDF of modified Phong against quadrature of the BRDF itself; mean_ggx_test.c has GGX. Errors are relative
 * to the integral's largest value over viewers spread about the cap's mirror direction. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "eas/mean_brdf.h"
#include "render/rng.h"
#include "tests/caps.h"

static const float3 N = {0, 0, 1};

/* The largest error over viewers over the largest value: one near the peak and `viewers` within `spread` of the mirror
 * direction of the cap's axis. A peak between them would only make the error less. */
static float worst_error(const struct mean_brdf *tables, const struct lobe *lobe, struct cap cap, float spread,
                         int viewers, int steps)
{
    struct rng rng = rng_seed(1, 2, 3);
    float largest = 0, error = 0, elevation = asinf(cap.axis.z), sigma = spread / 4;
    for (int i = 0; i < viewers + 3; i++) {
        float up = maxf(elevation, 0) + sigma * (float)i / 2, azimuth = PI; /* near the peak */
        if (i >= 3) {
            up = elevation + spread * (2 * rng_float(&rng) - 1);
            azimuth += spread * rng_float(&rng) / cosf(up);
        }
        if (up <= .005f || up >= PI / 2) continue;
        float3 wo = direction(up, azimuth);
        struct mean_lobe mean = mean_lobe(tables, lobe, N, wo);
        float exact = mean_lobe_quadrature(lobe, N, wo, cap, steps, steps).x;
        largest = maxf(largest, exact);
        error = maxf(error, fabsf(mean_lobe_cap(&mean, cap).x - exact));
    }
    return error / largest;
}

/* Modified Phong over a cap. */
static void check_phong(const struct mean_brdf *tables, float exponent, float elevation, float theta, int viewers,
                        float tolerance)
{
    struct brdf brdf = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), exponent);
    float sigma = 1 / sqrtf(exponent + 1);
    int steps = theta > 3 * sigma ? 96 : theta > sigma ? 64 : 40;
    float error = worst_error(tables, &brdf.lobes[0], cap_at(elevation, theta), theta + 3 * sigma, viewers, steps);
    if (!(error <= tolerance))
        fail_msg("n = %g, elevation %g, cap %g rad: error %g of the peak", exponent, elevation, theta, error);
}

/* The statement of mean_phong.h, by random exponents of 5 to 1000, caps to 20 degrees and elevations: from `low` to
 * `high` radii of the cap, or to the zenith where high is 0. */
static void sweep(const struct mean_brdf *tables, int count, float low, float high, float tolerance)
{
    struct rng rng = rng_seed(4, 5, 6);
    for (int i = 0; i < count; i++) {
        float exponent = 5 * powf(200, rng_float(&rng)), theta = .349f * powf(.01f, rng_float(&rng));
        float from = low * theta, to = high > 0 ? high * theta : PI / 2;
        check_phong(tables, exponent, from + (to - from) * rng_float(&rng), theta, 10, tolerance);
    }
}

static void test_phong_above_horizon(void **state)
{
    sweep(*state, 1000, 1, 0, 2.5e-3f);
    sweep(*state, 500, 1, 1.1f, 2.5e-3f);
}

/* Most of them where a sliver is cut off or left. */
static void test_phong_across_horizon(void **state)
{
    sweep(*state, 400, -.98f, .999f, .02f);
    sweep(*state, 400, .6f, .999f, .02f);
    sweep(*state, 200, -.98f, -.8f, .02f);
}

/* Wide caps (EAS at contacts) are rough, most where a wide lobe meets the horizon. The widest is the hemisphere. */
static void test_phong_wide(void **state)
{
    const float exponents[] = {5, 40, 300}, elevations[] = {.1f, .7f, 1.5f};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            check_phong(*state, exponents[i], elevations[j], .7f, 30, .1f);
            check_phong(*state, exponents[i], elevations[j], 1.3f, 30, .1f);
        }
    for (int i = 0; i < 3; i++) check_phong(*state, exponents[i], 1.57079f, 1.57079f, 30, .1f);
}

/* A viewer below the horizon sees nothing; a cap below it sends nothing; an empty one neither. */
static void test_nothing(void **state)
{
    struct brdf brdf = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), 20);
    struct glossy metal = {{1, 1, 1}, .4f, .distribution = DISTRIBUTION_MULTI_GGX};
    struct brdf ggx = brdf_glossy(&metal, .5f);
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
