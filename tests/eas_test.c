/* SPDX-License-Identifier: Apache-2.0 */
/* An EAS seen from elsewhere, against a disc projected by brute force. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "eas/eas.h"
#include "render/rng.h"

static const rgb WHITE = {1, 1, 1};

/* The solid angle of a disc of radius r at c seen from x: the integral of cos(alpha)/d^2 over its area. */
static float disc_solid_angle(float3 c, float3 normal, float r, float3 x)
{
    enum { RINGS = 60, SECTORS = 60 };
    struct frame frame = frame_about(normal);
    double sum = 0;
    for (int i = 0; i < RINGS; i++)
        for (int j = 0; j < SECTORS; j++) {
            float rho = r * ((float)i + .5f) / RINGS, phi = 2 * PI * ((float)j + .5f) / SECTORS;
            float3 v = sub(x, add(c, to_world(frame, vec3(rho * cosf(phi), rho * sinf(phi), 0))));
            double d2 = dot(v, v), area = 2 * PI * rho * (r / RINGS) / SECTORS;
            sum += fmax(dot(v, normal), 0) / (d2 * sqrt(d2)) * area;
        }
    return (float)sum;
}

/* From its record an EAS is the cap that was put in, however wide and however it is turned. */
static void identity_at_record(void **state)
{
    (void)state;
    const float omegas[] = {1e-5f, .01f, .5f, 3, 5.9f};
    const float3 origin = {1, -2, .5f}, normals[] = {{0, 0, -1}, {.6f, 0, -.8f}, {.95f, .1f, -.3f}};
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 3; j++) {
            struct eas eas =
                eas_make(origin, add(origin, vec3(0, 0, 3)), scale(normals[j], 7), WHITE, omegas[i], false);
            struct cap cap = eas_translate(&eas, origin);
            assert_float_equal(cap.omega / omegas[i], 1, 1e-3f);
            assert_float_equal(cap.axis.z, 1, 1e-6f);
        }
}

/* Discs, some seen obliquely, from points about the record: without the receiver's cosine the solid angle is right to a
 * few percent. With it, as the paper prints eq. 19, it is wrong by the ratio of the cosines. */
static void translation_of_a_disc(void **state)
{
    (void)state;
    const float3 record = {0, 0, 0}, n = {0, 0, 1}, c = {1.2f, .3f, .9f};
    const float3 normals[] = {{-.8f, 0, -.6f}, {0, 0, -1}, {-1, 0, 0}, {-.3f, .5f, -.81f}};
    const float3 places[] = {{.5f, 0, 0}, {-.5f, 0, 0}, {0, .6f, 0}, {.3f, -.3f, .2f}, {.7f, .2f, 0}};
    float with_cosine = 0;
    for (int i = 0; i < 4; i++) {
        float3 normal = normalize(normals[i]);
        struct eas eas = eas_make(record, c, normal, WHITE, disc_solid_angle(c, normal, .1f, record), false);
        for (int j = 0; j < 5; j++) {
            struct cap cap = eas_translate(&eas, places[j]);
            float exact = disc_solid_angle(c, normal, .1f, places[j]);
            if (fabsf(cap.omega / exact - 1) > .02f)
                fail_msg("disc %d from place %d: %g sr, expected %g", i, j, cap.omega, exact);
            assert_float_equal(length(sub(cap.axis, normalize(sub(c, places[j])))), 0, 1e-5f);
            float cosines = dot(cap.axis, n) / dot(normalize(c), n);
            with_cosine = maxf(with_cosine, fabsf(cap.omega * cosines / exact - 1));
        }
    }
    assert_true(with_cosine > .3f);
}

/* As x comes close along the axis the disc grows, but not to a hemisphere, nor to no number. */
static void bounded_nearby(void **state)
{
    (void)state;
    struct eas eas = eas_make(vec3(0, 0, 0), vec3(0, 0, 1), vec3(0, 0, -1), WHITE, .1f, false);
    float before = 0;
    for (float d = 1; d > 1e-6f; d *= .5f) {
        float omega = eas_translate(&eas, vec3(0, 0, 1 - d)).omega;
        assert_true(omega >= before && omega < .951f * 2 * PI);
        before = omega;
    }
    assert_true(before > .9f * 2 * PI);
    assert_true(eas_translate(&eas, vec3(0, 0, 1)).omega == 0); /* on the disc itself there is no side */
    /* Edge-on at its record: a disc seen in full elsewhere is at most 1/EAS_GRAZING as large. */
    struct eas edge = eas_make(vec3(0, 0, 0), vec3(0, 0, 1), vec3(1, 0, -1e-3f), WHITE, 1e-3f, false);
    float omega = eas_translate(&edge, vec3(1, 0, 1)).omega;
    assert_true(omega <= 1e-3f / EAS_GRAZING * 1.001f && omega > .9e-3f / EAS_GRAZING);
}

static void empty_from_behind(void **state)
{
    (void)state;
    struct eas eas = eas_make(vec3(0, 0, 0), vec3(0, 0, 1), vec3(0, 0, -1), WHITE, .1f, false);
    assert_true(eas_translate(&eas, vec3(.1f, 0, 1.01f)).omega == 0);
    assert_true(eas_translate(&eas, vec3(.1f, 0, .99f)).omega > 0);
    /* A mean normal that looks away is no normal: the EAS faces its record. */
    eas = eas_make(vec3(0, 0, 0), vec3(0, 0, 1), vec3(0, .1f, 1), WHITE, .1f, false);
    assert_float_equal(eas_translate(&eas, vec3(0, 0, 0)).omega, .1f, 1e-5f);
}

/* The visibility gradient: all of it at the record, less or more by the step, none at the least, twice at the most. */
static void uncovered(void **state)
{
    (void)state;
    const float3 origin = {3, 2, 1}, gradient = {2, 0, 0};
    for (int infinite = 0; infinite < 2; infinite++) {
        struct eas eas = eas_make(origin, vec3(3, 2, 9), vec3(0, 0, -1), WHITE, .1f, infinite);
        struct eas plain = eas;
        eas.uncovered = gradient;
        eas.visible = 1 - dot(gradient, origin);
        const float steps[] = {0, .2f, -.2f, -.7f, .9f}, shares[] = {1, 1.4f, .6f, 0, 2};
        for (int i = 0; i < 5; i++) {
            float3 x = add(origin, vec3(steps[i], .4f, 0));
            assert_float_equal(eas_translate(&eas, x).omega / eas_translate(&plain, x).omega, shares[i], 1e-5f);
        }
    }
}

static void infinity_unmoved(void **state)
{
    (void)state;
    struct eas eas = eas_make(vec3(5, 5, 5), vec3(0, 3, 4), vec3(0, 0, 0), WHITE, .1f, true);
    struct cap cap = eas_translate(&eas, vec3(-100, 3, 7));
    assert_true(cap.omega == .1f);
    assert_float_equal(length(sub(cap.axis, vec3(0, .6f, .8f))), 0, 1e-6f);
}

/* Eq. 9: radiance x integral of f cos over each cap, colour by colour, from where each is seen; nothing from behind. */
static void reflected(void **state)
{
    struct brdf brdf = brdf_phong(vec3(0, 0, 0), vec3(.5f, .25f, 1), 30);
    const float3 n = {0, 0, 1}, x = {.2f, .1f, 0}, wo = normalize(vec3(-.6f, 0, .8f));
    struct eas eas[] = {
        eas_make(vec3(0, 0, 0), vec3(1, 0, 1.2f), vec3(-1, 0, -1), vec3(1, 2, 3), .2f, false),
        eas_make(vec3(0, 0, 0), vec3(.3f, .2f, 1), vec3(0, 0, 0), vec3(4, 0, 1), .1f, true),
        eas_make(vec3(-1, 0, 0), vec3(.1f, 0, .1f), vec3(-1, 0, 0), vec3(100, 100, 100), .1f, false) /* x is behind */
    };
    rgb exact = {0};
    for (int i = 0; i < 2; i++)
        exact = add(exact, mul(eas[i].radiance,
                               mean_lobe_quadrature(&brdf.lobes[0], n, wo, eas_translate(&eas[i], x), 64, 64)));
    struct mean_lobe lobe = mean_lobe(*state, &brdf.lobes[0], n, wo);
    rgb sum = eas_reflect(eas, 3, &lobe, x);
    assert_float_equal(sum.x / exact.x, 1, .005f);
    assert_float_equal(sum.y / exact.y, 1, .005f);
    assert_float_equal(sum.z / exact.z, 1, .005f);
}

/* Many EAS, near and far, large and small: none that the lobe reaches is left out. */
static void many(void **state)
{
    enum { COUNT = 300 };
    const float exponents[] = {3, 30, 300};
    struct rng rng = rng_seed(1, 2, 3);
    struct eas eas[COUNT];
    for (int i = 0; i < COUNT; i++) {
        float z = rng_float(&rng), r = sqrtf(1 - z * z), phi = 2 * PI * rng_float(&rng);
        float3 dir = {r * cosf(phi), r * sinf(phi), z};
        float3 normal = mad(scale(dir, -1), vec3(rng_float(&rng), rng_float(&rng), rng_float(&rng)), .8f);
        eas[i] = eas_make(vec3(0, 0, 0), scale(dir, .2f + rng_float(&rng)), normal, WHITE, expf(-7 * rng_float(&rng)),
                          rng_float(&rng) < .3f);
    }
    for (int k = 0; k < 60; k++) {
        struct brdf brdf = brdf_phong(vec3(0, 0, 0), WHITE, exponents[k % 3]);
        float3 x = {.2f * rng_float(&rng), .2f * rng_float(&rng), 0};
        float3 wo = normalize(vec3(rng_float(&rng) - .5f, rng_float(&rng) - .5f, .05f + .6f * rng_float(&rng)));
        struct mean_lobe lobe = mean_lobe(*state, &brdf.lobes[0], vec3(0, 0, 1), wo);
        float sum = 0;
        for (int i = 0; i < COUNT; i++) sum += mean_lobe_cap(&lobe, eas_translate(&eas[i], x)).x;
        assert_true(sum > 0);
        assert_float_equal(eas_reflect(eas, COUNT, &lobe, x).x / sum, 1, 1e-3f);
    }
}

/* In a corner the mean of a group's hits may lie where the record is, and means of normals look away or cancel: the
 * EAS's normal is unit all the same, its cap no wider than a disc's. */
static void in_a_corner(void **state)
{
    (void)state;
    const float3 record = {1, 2, 3}, normals[] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, 0, 0}, {0, 1e-20f, 0}};
    for (int k = 0; k < 5; k++)
        for (float d = 0; d < 1; d = d > 0 ? 10 * d : 1e-16f) {
            struct eas eas = eas_make(record, add(record, vec3(0, 0, d)), normals[k], vec3(1, 1, 1), .5f, false);
            assert_float_equal(length(eas.normal), 1, 1e-5f);
            struct cap cap = eas_translate(&eas, record);
            assert_true(eas.area >= 0 && cap.omega >= 0 && cap.omega < 2 * PI);
        }
}

/* What is seen doesn't depend on the unit of length. */
static void any_scale(void **state)
{
    (void)state;
    const float3 position = {.5f, .2f, 1}, normal = {.1f, .3f, -1}, x = {.1f, -.2f, .1f};
    struct eas eas = eas_make(vec3(0, 0, 0), position, normal, vec3(1, 1, 1), .1f, false);
    float expected = eas_translate(&eas, x).omega;
    for (float unit = 1e-9f; unit < 1e10f; unit *= 10) {
        eas = eas_make(vec3(0, 0, 0), scale(position, unit), normal, vec3(1, 1, 1), .1f, false);
        assert_float_equal(eas_translate(&eas, scale(x, unit)).omega, expected, 1e-5f);
    }
}

static int setup(void **state) { return (*state = mean_brdf_build()) ? 0 : -1; }
static int teardown(void **state) { return mean_brdf_free(*state), 0; }

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(identity_at_record), cmocka_unit_test(translation_of_a_disc),
                                       cmocka_unit_test(bounded_nearby),     cmocka_unit_test(empty_from_behind),
                                       cmocka_unit_test(infinity_unmoved),   cmocka_unit_test(uncovered),
                                       cmocka_unit_test(reflected),          cmocka_unit_test(many),
                                       cmocka_unit_test(in_a_corner),        cmocka_unit_test(any_scale)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
