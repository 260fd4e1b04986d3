/* SPDX-License-Identifier: Apache-2.0 */
/* The mean of GGX lobes over caps against quadrature of the lobes, and against what is known without it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "render/rng.h"
#include "tests/mean_ggx_errors.h"

static const float3 N = {0, 0, 1};

static rgb over_cap(const struct lobe *lobe, float3 n, float3 wo, struct cap cap)
{
    struct mean_ggx mean = mean_ggx(lobe, n, wo);
    rgb value;
    mean_ggx_caps(&mean, &cap, 1, &value);
    return value;
}

/* Roughness with anisotropy: .09 is about the least alpha that isn't traced. */
static const float LOBES[][2] = {{.3f, 0}, {.5f, 0}, {1, 0}, {.5f, .775f}, {.6f, .997f}};
enum { LOBE_COUNT = sizeof LOBES / sizeof *LOBES };

/* The first `lobes` of them; caps at elevations in rad or, across the horizon, in radii. */
static void check(int lobes, const float *elevations, int count, bool radii, float theta, bool white,
                  struct errors limit)
{
    for (int i = 0; i < lobes; i++)
        for (int j = 0; j < count; j++) {
            struct lobe lobe = ggx_lobe(LOBES[i][0], LOBES[i][1], .6f, white);
            float elevation = elevations[j] * (radii ? theta : 1);
            struct errors errors = errors_of(&lobe, cap_at(elevation, theta), .2f);
            if (!(errors.rms <= limit.rms && errors.most <= limit.most))
                fail_msg("roughness %g, anisotropic %g, cap %g rad at %g: errors rms %g, largest %g", LOBES[i][0],
                         LOBES[i][1], theta, elevation, errors.rms, errors.most);
        }
}

static void test_above_horizon(void **state)
{
    (void)state;
    const float elevations[] = {.4f, .9f, 1.5f};
    for (int white = 0; white < 2; white++) {
        check(LOBE_COUNT, elevations, 3, false, .01f, white, (struct errors){1e-3f, 2e-3f});
        check(LOBE_COUNT, elevations, 3, false, .1f, white, (struct errors){2e-3f, .01f});
    }
    check(LOBE_COUNT, elevations, 3, false, .35f, true, (struct errors){.005f, .02f});
    check(LOBE_COUNT, elevations, 3, false, .35f, false, (struct errors){.01f, .045f});
}

static void test_across_horizon(void **state)
{
    (void)state;
    const float elevations[] = {-.8f, -.3f, .2f, .9f};
    for (int white = 0; white < 2; white++) {
        check(LOBE_COUNT, elevations, 4, true, .03f, white, (struct errors){2e-3f, 5e-3f});
        check(LOBE_COUNT, elevations, 4, true, .1f, white, (struct errors){4e-3f, .02f});
        check(LOBE_COUNT, elevations, 4, true, .3f, white, (struct errors){.01f, .04f});
    }
}

/* EAS at contacts: up to the hemisphere itself. The last lobe, ten times as long as wide, is off by .15 of the peak
 * (rms) over the widest, whose 48 points lie too far apart for it. */
static void test_wide(void **state)
{
    (void)state;
    const float elevations[] = {-.3f, .1f, .8f, 1.1f}, zenith[] = {PI / 2};
    check(LOBE_COUNT, elevations, 4, false, .7f, true, (struct errors){.01f, .02f});
    check(LOBE_COUNT - 1, elevations, 4, false, 1.2f, true, (struct errors){.05f, .15f});
    check(LOBE_COUNT - 1, zenith, 1, false, PI / 2, true, (struct errors){.1f, .15f});
}

/* A small cap sees one value of f cos, whatever the lobe and the viewer; metal or dielectric. */
static void test_small(void **state)
{
    (void)state;
    struct rng rng = rng_seed(1, 2, 3);
    for (int i = 0; i < 2000; i++) {
        struct lobe lobe = ggx_lobe(.3f + .7f * rng_float(&rng), rng_float(&rng), 6 * rng_float(&rng), false);
        lobe.f0 = vec3(.9f, .5f, .2f);
        lobe.f82 = vec3(.5f, 1, .8f);
        if (i % 2)
            lobe = (struct lobe){LOBE_DIELECTRIC,         {1, 1, 1},   .alpha_x = lobe.alpha_x, .alpha_y = lobe.alpha_y,
                                 .tangent = lobe.tangent, .ior = 1.5f, .f0 = {.04f, .03f, .02f}};
        float3 n = normalize(vec3(rng_float(&rng) - .5f, rng_float(&rng) - .5f, rng_float(&rng) - .5f));
        float u[4] = {rng_float(&rng), rng_float(&rng), rng_float(&rng), rng_float(&rng)};
        lobe.tangent = frame_about(n).t;
        float3 wo = cosine_direction(n, u), wi = i % 10 ? cosine_direction(n, u + 2) : wo;
        if (dot(wo, n) < .1f || dot(wi, n) < .05f) continue;
        const float omega = 1e-5f;
        rgb value = over_cap(&lobe, n, wo, (struct cap){wi, omega});
        rgb f = scale(lobe_eval(&lobe, n, wo, wi), dot(wi, n) * omega);
        assert_float_equal(value.x, f.x, 2e-3f * f.x);
        assert_float_equal(value.z, f.z, 2e-3f * f.z);
    }
}

/* Nearly small enough for the horizon: f cos rises from 0 there in a line, and so does the integral with the height of
 * what is left. */
static void test_small_across_horizon(void **state)
{
    (void)state;
    struct rng rng = rng_seed(7, 8, 9);
    for (int i = 0; i < 60000; i++) {
        struct lobe lobe = ggx_lobe(.3f + .7f * rng_float(&rng), 0, 0, true);
        float3 wo = direction(.2f + 1.3f * rng_float(&rng), 2 * PI * rng_float(&rng));
        float theta = 1e-5f * powf(200, rng_float(&rng)), up = 1.8f * rng_float(&rng) - .9f; /* up: in radii */
        /* The moment of a circle's segment about its chord: the integral of 2 sqrt(1-y^2) (y + up) from -up to 1. */
        double level = sqrt(1 - up * up), moment = level * (2 + up * up) / 3 + up * (PI / 2 + asin(up));
        float slope = lobe_eval(&lobe, N, wo, direction(1e-3f, 0)).x;
        float value = over_cap(&lobe, N, wo, cap_at(up * theta, theta)).x;
        /* A direction's own rounding is 1e-7. */
        assert_float_equal(value / (slope * powf(theta, 3) * (float)moment), 1, .05f + 2e-5f / theta);
    }
}

/* A cap that holds all of a narrow lobe reflects G2/G1 times F, which is about 1 where the viewer isn't low; one that
 * holds none of it, next to nothing. */
static void test_narrow_lobe(void **state)
{
    (void)state;
    const float roughness[] = {.01f, .03f, .1f};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 4; k++) {
            struct lobe lobe = ggx_lobe(roughness[i], k % 2 ? .8f : 0, 1, true);
            float3 wo = direction(.8f, PI + .1f);
            assert_float_equal(over_cap(&lobe, N, wo, cap_at(.75f, .3f)).x, 1, .02f);
            assert_float_equal(over_cap(&lobe, N, wo, cap_at(k < 2 ? .2f : .1f, .15f)).x, 0, .02f);
        }
}

/* No number is lost, and nothing reflects more than arrives: f cos of a white lobe integrates to at most 1. */
static void test_bounds(void **state)
{
    (void)state;
    struct rng rng = rng_seed(4, 5, 6);
    for (int i = 0; i < 20000; i++) {
        struct lobe lobe = ggx_lobe(.2f + .8f * rng_float(&rng), rng_float(&rng), 6 * rng_float(&rng), true);
        float3 wo = direction(powf(10, -4 * rng_float(&rng)) * PI / 2, 6 * rng_float(&rng));
        struct cap cap = {direction((2 * rng_float(&rng) - 1) * PI / 2, 0), 2 * PI * powf(10, -6 * rng_float(&rng))};
        if (i % 16 == 0) cap.axis = wo;
        if (i % 16 == 1) cap.axis = scale(wo, -1);
        if (i % 16 == 2) cap.axis = reflect(wo, N);
        if (i % 16 == 3) cap.axis = N;
        if (i % 16 == 4) wo = N;
        float value = over_cap(&lobe, N, wo, cap).x;
        if (!(value >= 0 && value < 1.06f))
            fail_msg("alphas %g, %g, cos_o %g, cap %g sr at %g: %g", lobe.alpha_x, lobe.alpha_y, wo.z, cap.omega,
                     cap.axis.z, value);
    }
}

/* A cap that touches the horizon, by both ways. */
static void test_continuous_at_horizon(void **state)
{
    (void)state;
    for (int i = 0; i < LOBE_COUNT; i++)
        for (int k = 0; k < 5; k++) {
            struct lobe lobe = ggx_lobe(LOBES[i][0], LOBES[i][1], .4f, true);
            float3 wo = direction(.15f + .2f * (float)k, PI + .1f * (float)k);
            float above = over_cap(&lobe, N, wo, cap_at(.1001f, .1f)).x;
            float below = over_cap(&lobe, N, wo, cap_at(.0999f, .1f)).x;
            assert_float_equal(above / below, 1, .02f);
        }
}

/* Many caps at once are those one by one; turned about, they are the same; with alphas and
 * tangent exchanged, too, but for the points that stand for an ellipse. */
static void test_same(void **state)
{
    (void)state;
    enum { COUNT = 37 };
    struct cap caps[COUNT];
    rgb values[COUNT];
    struct lobe lobe = ggx_lobe(.5f, .7f, .3f, false), other = lobe;
    other.alpha_x = lobe.alpha_y;
    other.alpha_y = lobe.alpha_x;
    other.tangent = cross(N, lobe.tangent);
    float3 wo = direction(.5f, 3);
    struct frame turned = {{.36f, .48f, -.8f}, {-.8f, .6f, 0}, {.48f, .64f, .6f}};
    struct lobe there = lobe;
    there.tangent = to_world(turned, lobe.tangent);
    struct mean_ggx mean = mean_ggx(&lobe, N, wo);
    for (int i = 0; i < COUNT; i++)
        caps[i] = (struct cap){direction(1.5f * (float)i / COUNT - .1f, .7f * (float)i), .5f * (float)i / COUNT};
    mean_ggx_caps(&mean, caps, COUNT, values);
    for (int i = 0; i < COUNT; i++) {
        float tolerance = 1e-4f * values[i].x + 1e-7f;
        assert_float_equal(over_cap(&lobe, N, wo, caps[i]).x, values[i].x, tolerance);
        assert_float_equal(over_cap(&other, N, wo, caps[i]).x, values[i].x, tolerance * 100);
        struct cap cap = {to_world(turned, caps[i].axis), caps[i].omega};
        assert_float_equal(over_cap(&there, turned.n, to_world(turned, wo), cap).x, values[i].x, tolerance * 10);
    }
}

static void test_nothing(void **state)
{
    (void)state;
    struct lobe lobe = ggx_lobe(.4f, .5f, 0, true);
    float3 above = direction(.3f, PI), below = direction(-.1f, PI);
    assert_true(over_cap(&lobe, N, above, cap_at(.1f, .2f)).x > 0);
    assert_true(over_cap(&lobe, N, below, cap_at(.1f, .2f)).x == 0);
    assert_true(over_cap(&lobe, N, below, cap_at(.5f, .2f)).x == 0);
    assert_true(over_cap(&lobe, N, above, cap_at(-.21f, .2f)).x == 0);
    assert_true(over_cap(&lobe, N, above, cap_at(-.19f, .2f)).x > 0);
    assert_true(over_cap(&lobe, N, above, cap_at(.3f, 0)).x == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_above_horizon),
                                       cmocka_unit_test(test_across_horizon),
                                       cmocka_unit_test(test_wide),
                                       cmocka_unit_test(test_small),
                                       cmocka_unit_test(test_small_across_horizon),
                                       cmocka_unit_test(test_narrow_lobe),
                                       cmocka_unit_test(test_bounds),
                                       cmocka_unit_test(test_same),
                                       cmocka_unit_test(test_continuous_at_horizon),
                                       cmocka_unit_test(test_nothing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
