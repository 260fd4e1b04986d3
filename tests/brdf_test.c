/* SPDX-License-Identifier: Apache-2.0 */
/* Reflectances against quadrature, closed forms and their own sampling. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>

#include "eas/ggx.h"
#include "tests/reflectance.h"

static struct lobe phong(float exponent) { return brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), exponent).lobes[0]; }

/* A white metal, longer along its tangent where anisotropic. */
static struct lobe brushed(float roughness, float anisotropic)
{
    float2 alpha = ggx_alphas(roughness, anisotropic);
    return (struct lobe){.type = LOBE_METAL,
                         .weight = {1, 1, 1},
                         .alpha_x = alpha.x,
                         .alpha_y = alpha.y,
                         .tangent = {0.8f, 0.6f, 0},
                         .f0 = {1, 1, 1},
                         .f82 = {1, 1, 1}};
}

static struct lobe metal(float roughness) { return brushed(roughness, 0); }

static struct brdf principled(float metallic, float roughness, float cos_o)
{
    struct principled p = {.base_colour = {0.8f, 0.5f, 0.3f},
                           .specular_tint = {1, 0.9f, 0.8f},
                           .metallic = metallic,
                           .roughness = roughness,
                           .ior = 1.5f,
                           .specular_level = 0.5f,
                           .distribution = DISTRIBUTION_MULTI_GGX};
    return brdf_principled(&p, cos_o, true);
}

static void samples_follow_pdf(void **state)
{
    (void)state;
    static const float cosines[] = {0.95f, 0.5f, 0.15f};
    for (int i = 0; i < 3; i++) {
        float3 wo = direction(cosines[i], 0.7f);
        struct brdf diffuse = {.kd = {0.5f, 0.5f, 0.5f}},
                    mixed = brdf_phong(vec3(0.3f, 0.2f, 0.1f), vec3(0.4f, 0.4f, 0.6f), 40);
        check_sampling("diffuse", &diffuse, wo);
        check_sampling("diffuse and Phong", &mixed, wo);
        static const float exponents[] = {2, 20, 400};
        static const float roughnesses[] = {0.15f, 0.5f, 1};
        for (int k = 0; k < 3; k++) {
            struct brdf one = {.lobe_count = 1, .lobes = {phong(exponents[k])}};
            check_sampling("Phong", &one, wo);
            one.lobes[0] = metal(roughnesses[k]);
            check_sampling("GGX", &one, wo);
            one.lobes[0] = brushed(roughnesses[k], 0.8f);
            check_sampling("anisotropic GGX", &one, wo);
            struct brdf plastic = principled(0.4f, roughnesses[k], cosines[i]);
            assert_int_equal(plastic.lobe_count, 2);
            check_sampling("principled", &plastic, wo);
        }
    }
}

static void phong_albedo(void **state)
{
    (void)state;
    struct brdf brdf = brdf_phong(vec3(0, 0, 0), vec3(0.6f, 0.6f, 0.6f), 30);
    /* Seen head-on: (n+2)/2pi times the integral of cos^(n+1) over the hemisphere is 1. */
    assert_float_equal(albedo_by_grid(&brdf, N).x, 0.6f, 1e-3f);
    for (int i = 1; i < 10; i += 2) {
        float3 wo = direction((float)i / 10, 0.3f);
        assert_float_equal(albedo_by_samples(&brdf, wo, 100000).x, albedo_by_grid(&brdf, wo).x, 3e-3f);
    }
}

static void reciprocity(void **state)
{
    (void)state;
    struct lobe lobes[] = {phong(50),
                           metal(0.4f),
                           brushed(0.4f, 0.9f),
                           {.type = LOBE_DIELECTRIC,
                            .weight = {1, 1, 1},
                            .alpha_x = 0.1f,
                            .alpha_y = 0.1f,
                            .ior = 1.5f,
                            .f0 = {0.04f, 0.04f, 0.04f}}};
    float3 a = direction(0.4f, 0.5f), b = direction(0.7f, 3.3f);
    for (int i = 0; i < 4; i++)
        assert_float_equal(lobe_eval(&lobes[i], N, a, b).x / lobe_eval(&lobes[i], N, b, a).x, 1, 1e-5f);
}

/* Two alphas: f head-on is D/4 of Heitz 2014 to the half vector, along the tangent and across it; equal ones are the
 * isotropic lobe; and no more leaves than arrives, by the pdf nor by f. */
static void two_alphas(void **state)
{
    (void)state;
    struct lobe lobe = brushed(0.5f, 0.8f);
    float3 along = lobe.tangent, across = cross(N, along);
    for (int i = 0; i < 5; i++) {
        float half = 0.1f * (float)i, s2 = sqr(sinf(half)), c2 = sqr(cosf(half)), cos_i = cosf(2 * half);
        for (int k = 0; k < 2; k++) {
            float alpha = k ? lobe.alpha_y : lobe.alpha_x;
            float d = 1 / (PI * lobe.alpha_x * lobe.alpha_y * sqr(s2 / sqr(alpha) + c2));
            float g2 = 2 / (1 + sqrtf(1 + sqr(alpha * tanf(2 * half))));
            float3 wi = add(scale(k ? across : along, sinf(2 * half)), scale(N, cos_i));
            assert_float_equal(lobe_eval(&lobe, N, N, wi).x / (d * g2 / (4 * cos_i)), 1, 1e-4f);
        }
    }
    struct lobe round = metal(0.4f), nearly = round;
    nearly.alpha_x *= 1.00001f;
    struct rng rng = rng_seed(8, 9, 10);
    for (int i = 0; i < 1000; i++) {
        float u[4] = {rng_float(&rng), rng_float(&rng), rng_float(&rng), rng_float(&rng)}, pdf[2];
        float3 wo = cosine_direction(N, u), wi = cosine_direction(N, u + 2);
        float f = ggx_eval(&round, N, wo, wi, &pdf[0]).x;
        assert_float_equal(ggx_eval(&nearly, N, wo, wi, &pdf[1]).x / f, 1, 1e-3f);
        assert_float_equal(pdf[1] / pdf[0], 1, 1e-3f);
    }
    for (int i = 2; i <= 5; i++) {
        struct brdf brdf = {.lobe_count = 1, .lobes = {brushed(0.2f * (float)i, 0.9f)}};
        for (int k = 0; k < 6; k++) {
            float3 wo = direction(0.15f + 0.16f * (float)k, (float)k);
            float albedo = albedo_by_grid(&brdf, wo).x;
            assert_true(albedo < 1.003f);
            assert_float_equal(albedo_by_samples(&brdf, wo, 20000).x, albedo, 0.01f);
        }
    }
}

static void fresnel_curves(void **state)
{
    (void)state;
    assert_float_equal(ggx_fresnel_dielectric(1, 1.5f), 0.04f, 1e-6f);
    /* At Brewster's angle, tan = eta, all that is reflected is half of the square of (1 - eta^2)/(1 + eta^2). */
    assert_float_equal(ggx_fresnel_dielectric(1 / sqrtf(1 + 2.25f), 1.5f), 0.5f * sqr(1.25f / 3.25f), 1e-6f);
    assert_float_equal(ggx_fresnel_dielectric(1e-6f, 1.5f), 1, 1e-4f);
    assert_float_equal(ggx_fresnel_dielectric(0.5f, 1 / 1.5f), 1, 1e-6f); /* total reflection */
    struct lobe lobe = metal(0.3f);
    lobe.f0 = vec3(0.5f, 0.3f, 0.1f);
    lobe.f82 = vec3(0.7f, 1, 0.2f);
    rgb edge = ggx_fresnel(&lobe, 1.0f / 7);
    float schlick = powf(6.0f / 7, 5);
    assert_float_equal(edge.x, 0.7f * (0.5f + 0.5f * schlick), 1e-5f);
    assert_float_equal(edge.z, 0.2f * (0.1f + 0.9f * schlick), 1e-5f);
    assert_float_equal(ggx_fresnel(&lobe, 1).y, 0.3f, 1e-6f);
    assert_float_equal(ggx_fresnel(&lobe, 0).y, 1, 1e-6f);
}

/* The tables, whose quadrature runs over visible normals, against a grid of directions. */
static void albedo_tables(void **state)
{
    (void)state;
    double mean = 0;
    for (int i = 0; i < 16; i++) { /* at nodes of the table, 31 cells, where nothing is interpolated */
        float mu = (float)(2 * i + 1) / 31;
        struct brdf brdf = {.lobe_count = 1, .lobes = {metal(20.0f / 31)}};
        float truth = albedo_by_grid(&brdf, direction(mu, 0.2f)).x;
        assert_float_equal(ggx_albedo(20.0f / 31, mu), truth, 1.5e-3f);
        mean += 2 * (double)mu * truth * 2 / 31;
    }
    mean -= 2.0 / 31 *
            (double)ggx_albedo(20.0f / 31, 1); /* midpoints at odd nodes: the last one stands at 1, half outside */
    assert_float_equal(ggx_albedo_mean(20.0f / 31), (float)mean, 4e-3f);
    assert_float_equal(ggx_albedo(0, 0.5f), 1, 1e-6f);
    /* A smooth dielectric's share is that of the one angle it sees. */
    float f = ggx_fresnel_dielectric(0.2f, 2), f0 = ggx_f0(2);
    assert_float_equal(ggx_fresnel_share(0, 0.2f, 2), (f - f0) / (1 - f0), 0.02f);
}

/* In a white furnace a white metal vanishes, and nothing gives back more than it takes. */
static void white_furnace(void **state)
{
    (void)state;
    struct principled white = {
        .base_colour = {1, 1, 1}, .specular_tint = {1, 1, 1}, .metallic = 1, .ior = 1.5f, .specular_level = 0.5f,
                           .distribution = DISTRIBUTION_MULTI_GGX};
    for (int r = 1; r <= 10; r++)
        for (int i = 1; i <= 10; i++) {
            float mu = (float)i / 10;
            white.roughness = (float)r / 10;
            white.metallic = 1;
            struct brdf metallic = brdf_principled(&white, mu, true);
            assert_float_equal(albedo_by_samples(&metallic, direction(mu, 0), 20000).x, 1, 0.015f);
            white.metallic = 0;
            struct brdf plastic = brdf_principled(&white, mu, true);
            float albedo = albedo_by_samples(&plastic, direction(mu, 0), 20000).x;
            assert_true(albedo > 0.95f && albedo < 1.02f);
        }
}

static void narrow_lobes(void **state)
{
    (void)state;
    struct brdf mirror = principled(1, 0, 0.6f);
    float3 wo = direction(0.6f, 1), wi;
    float u[3] = {0.3f, 0.6f, 0.2f}, pdf;
    rgb weight = brdf_sample(&mirror, N, wo, u, &wi, &pdf);
    assert_float_equal(dot(wi, reflect(wo, N)), 1, 1e-5f);
    assert_float_equal(weight.x, ggx_fresnel(&mirror.lobes[0], 0.6f).x, 1e-3f);
    assert_true(lobe_width(&mirror.lobes[0]) < 1e-3f);
    struct lobe wide = phong(100);
    assert_float_equal(powf(cosf(lobe_width(&wide)), 100), expf(-1), 1e-4f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(samples_follow_pdf), cmocka_unit_test(phong_albedo),
                                       cmocka_unit_test(reciprocity),        cmocka_unit_test(two_alphas),
                                       cmocka_unit_test(fresnel_curves),     cmocka_unit_test(albedo_tables),
                                       cmocka_unit_test(white_furnace),      cmocka_unit_test(narrow_lobes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
