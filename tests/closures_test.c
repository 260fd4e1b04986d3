/* SPDX-License-Identifier: Apache-2.0 */
/* Cycles' closures: what they send back and let pass, against quadrature, Snell, Fresnel and their own sampling. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>

#include "eas/ggx.h"
#include "tests/reflectance.h"

static const rgb WHITE = {1, 1, 1};

static struct brdf glass(float roughness, float ior, enum distribution distribution, float cos_o, bool front)
{
    struct glass g = {WHITE, roughness, ior, distribution};
    return brdf_glass(&g, cos_o, front);
}

static struct brdf glossy(float roughness, float anisotropy, enum distribution distribution, float cos_o)
{
    struct glossy g = {WHITE, roughness, anisotropy, {0.8f, 0.6f, 0}, distribution};
    return brdf_glossy(&g, cos_o);
}

static void samples_follow_pdf(void **state)
{
    (void)state;
    static const float cosines[] = {0.9f, 0.4f}, roughnesses[] = {0.4f, 0.8f};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++) {
            float3 wo = direction(cosines[i], 0.7f);
            struct brdf brdf = glossy(roughnesses[k], 0, DISTRIBUTION_BECKMANN, wo.z);
            check_sampling("Beckmann", &brdf, wo);
            brdf = glossy(roughnesses[k], 0.6f, DISTRIBUTION_BECKMANN, wo.z);
            check_sampling("anisotropic Beckmann", &brdf, wo);
            brdf = glossy(roughnesses[k], 0, DISTRIBUTION_ASHIKHMIN_SHIRLEY, wo.z);
            check_sampling("Ashikhmin-Shirley", &brdf, wo);
            brdf = glossy(roughnesses[k], -0.5f, DISTRIBUTION_ASHIKHMIN_SHIRLEY, wo.z);
            check_sampling("anisotropic Ashikhmin-Shirley", &brdf, wo);
            brdf = brdf_sheen(WHITE, roughnesses[k], wo.z);
            check_sampling("sheen", &brdf, wo);
            /* Refraction by less rough facets is too narrow for the bins' quadrature. */
            for (int front = 0; k > 0 && front < 2; front++) {
                brdf = glass(roughnesses[k], 1.5f, DISTRIBUTION_MULTI_GGX, wo.z, front);
                check_sampling("glass", &brdf, wo);
                brdf = glass(roughnesses[k], 1.3f, DISTRIBUTION_BECKMANN, wo.z, front);
                check_sampling("Beckmann glass", &brdf, wo);
                struct glass g = {WHITE, roughnesses[k], 1.5f, DISTRIBUTION_GGX};
                brdf = brdf_refraction(&g, front);
                brdf.kd = vec3(0.2f, 0.3f, 0.1f);
                brdf.kt = vec3(0.1f, 0.3f, 0.4f);
                check_sampling("refraction, diffuse, translucent", &brdf, wo);
            }
        }
}

/* Glass loses nothing: smooth or compensated for multiple scattering it is white in a white furnace. (From inside
 * Cycles' compensation falls short.) Single scattering loses as much as its table says, and never gains. */
static void white_furnace(void **state)
{
    (void)state;
    for (int front = 0; front < 2; front++)
        for (int r = 0; r <= 15; r += 3)
            for (int i = 3; i <= 15; i += 4) { /* nodes of the tables, where nothing is interpolated */
                float mu = (float)i / 15, roughness = (float)r / 15;
                const float q = 6.0f / 15, ior = (1 + q * q) / (1 - q * q); /* 1.38 */
                float3 wo = direction(mu, 1);
                struct brdf brdf = glass(roughness, ior, DISTRIBUTION_MULTI_GGX, mu, front);
                float all = albedo_by_samples(&brdf, wo, 40000).x;
                if (front || roughness == 0) assert_float_equal(all, 1, 0.012f);
                else assert_true(all < 1.012f && all > (mu > 0.7f ? 0.93f : 0.7f)); /* refracted upward again: lost */
                brdf = glass(roughness, ior, DISTRIBUTION_GGX, mu, front);
                float mean, e = ggx_glass_albedo(roughness, mu, front ? ior : 1 / ior, &mean);
                if (front && roughness > 0.7f) /* less rough ones are too narrow for the grid */
                    assert_float_equal(albedo_of_side(&brdf, wo, 1).x + albedo_of_side(&brdf, wo, -1).x, e, 4e-3f);
                assert_true(e <= 1 && mean <= 1 && mean > 0.5f);
            }
    for (int k = 0; k < 3; k++) { /* no closure gives back more than it takes */
        static const float cosines[] = {0.9f, 0.5f, 0.1f};
        float3 wo = direction(cosines[k], 0);
        for (int r = 0; r <= 10; r++) {
            float roughness = (float)r / 10;
            struct brdf beckmann = glossy(roughness, 0.3f, DISTRIBUTION_BECKMANN, wo.z);
            assert_true(albedo_by_samples(&beckmann, wo, 20000).x < 1.005f);
            struct brdf ashikhmin = glossy(roughness, 0.3f, DISTRIBUTION_ASHIKHMIN_SHIRLEY, wo.z);
            assert_true(albedo_by_samples(&ashikhmin, wo, 20000).x < 1.005f);
            struct brdf multi = glossy(roughness, 0, DISTRIBUTION_MULTI_GGX, wo.z);
            assert_float_equal(albedo_by_samples(&multi, wo, 40000).x, 1, 0.02f);
        }
    }
}

/* Smooth glass: Snell's direction with what Fresnel lets pass, total reflection beyond the critical angle. */
static void smooth_glass(void **state)
{
    (void)state;
    struct rng rng = rng_seed(1, 2, 3);
    for (int front = 0; front < 2; front++)
        for (int k = 1; k <= 9; k++) {
            float mu = (float)k / 10, eta = front ? 1.5f : 1 / 1.5f, sine = sqrtf(1 - mu * mu) / eta;
            float3 wo = direction(mu, 0.4f);
            float reflected = ggx_fresnel_dielectric(mu, eta);
            struct brdf brdf = glass(0, 1.5f, DISTRIBUTION_MULTI_GGX, mu, front);
            assert_true(brdf_transmits(&brdf));
            int below = 0;
            enum { COUNT = 4000 };
            for (int i = 0; i < COUNT; i++) {
                float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)}, pdf;
                float3 wi;
                rgb weight = brdf_sample(&brdf, N, wo, u, &wi, &pdf);
                below += wi.z < 0;
                if (pdf < 1e5f) continue; /* in the far tail the narrow lobe is no mirror */
                assert_float_equal(weight.x, 1, 1e-2f);
                float3 mirrored = reflect(wo, N), bent = direction(-sqrtf(fmaxf(1 - sine * sine, 0)), 0.4f + PI);
                assert_true(length(sub(wi, wi.z < 0 ? bent : mirrored)) < 5e-3f);
            }
            assert_float_equal((float)below / COUNT, 1 - reflected, 4 * sqrtf(0.25f / COUNT));
            if (sine > 1) assert_int_equal(below, 0);
        }
    struct brdf pane = glass(0.5f, 1, DISTRIBUTION_GGX, 0.5f, true); /* bends nothing */
    assert_true(pane.lobe_count == 0 && pane.through.x == 1 && !brdf_transmits(&pane));
}

/* Light and viewer change places: the same but for the square of the index, which radiance isn't scaled by. */
static void reciprocity(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        enum distribution distribution = k ? DISTRIBUTION_BECKMANN : DISTRIBUTION_GGX;
        float3 out = direction(0.7f, 0.5f), in = direction(-0.8f, 0.4f + PI);
        struct brdf outside = glass(0.6f, 1.5f, distribution, out.z, true),
                    inside = glass(0.6f, 1.5f, distribution, -in.z, false);
        float there = brdf_eval(&outside, N, out, in).x, back = brdf_eval(&inside, scale(N, -1), in, out).x;
        assert_true(back > 0.01f);
        assert_float_equal(there / back, 2.25f, 1e-4f);
        struct brdf mirror = glossy(0.5f, 0.4f, distribution, 0.5f);
        float3 other = direction(0.4f, 2.5f);
        assert_float_equal(brdf_eval(&mirror, N, out, other).x / brdf_eval(&mirror, N, other, out).x, 1, 1e-4f);
        mirror = glossy(0.5f, 0.4f, DISTRIBUTION_ASHIKHMIN_SHIRLEY, 0.5f);
        assert_float_equal(brdf_eval(&mirror, N, out, other).x / brdf_eval(&mirror, N, other, out).x, 1, 1e-4f);
    }
}

/* The microfacets of either distribution, seen head-on, cover the surface once: what refracts into an index near 1
 * (no light lost to Fresnel or to other facets) is all. */
static void bare_refraction(void **state)
{
    (void)state;
    struct glass g = {WHITE, 0.6f, 1.05f, DISTRIBUTION_BECKMANN};
    struct brdf brdf = brdf_refraction(&g, true);
    assert_float_equal(albedo_by_samples(&brdf, N, 40000).x, 1, 3e-3f);
    g.ior = 1.5f; /* from inside, beyond the critical angle, nothing */
    g.roughness = 0;
    brdf = brdf_refraction(&g, false);
    assert_true(albedo_by_samples(&brdf, direction(0.5f, 0), 1000).x == 0);
    assert_float_equal(albedo_by_samples(&brdf, direction(0.9f, 0), 1000).x, 1, 1e-3f);
}

static struct principled layered(void)
{
    return (struct principled){.base_colour = WHITE,
                               .specular_tint = WHITE,
                               .roughness = 0.5f,
                               .ior = 1.5f,
                               .specular_level = 0.5f,
                               .coat_weight = 1,
                               .coat_roughness = 0.3f,
                               .coat_ior = 1.5f,
                               .coat_tint = WHITE,
                               .sheen_weight = 1,
                               .sheen_roughness = 0.5f,
                               .sheen_tint = WHITE,
                               .distribution = DISTRIBUTION_MULTI_GGX};
}

/* White layers on white stay white but for what their albedos miss; each takes from those below what it adds. */
static void layers(void **state)
{
    (void)state;
    for (int i = 1; i <= 5; i++) {
        float mu = 0.2f * (float)i;
        float3 wo = direction(mu, 0.3f);
        for (int metal = 0; metal < 3; metal++) {
            struct principled p = layered();
            p.metallic = metal == 1;
            p.transmission = metal == 2;
            struct brdf brdf = brdf_principled(&p, mu, true);
            float albedo = albedo_by_samples(&brdf, wo, 40000).x;
            assert_true(albedo > 0.93f && albedo < 1.02f);
        }
        /* A black base under a coat: what is left is Fresnel's mean over the coat's facets. */
        struct principled p = layered();
        p.sheen_weight = 0;
        p.base_colour = vec3(0, 0, 0);
        p.specular_level = 0;
        struct brdf coat = brdf_principled(&p, mu, true);
        assert_int_equal(coat.lobe_count, 1);
        float f0 = 0.04f, seen = f0 + (1 - f0) * ggx_fresnel_share(0.3f, mu, 1.5f);
        assert_float_equal(albedo_by_samples(&coat, wo, 100000).x, seen, 0.1f * seen);
        /* A tint is what passes at right angles once. */
        p.base_colour = WHITE;
        p.coat_tint = vec3(0.5f, 1, 0.25f);
        if (i == 5) {
            struct brdf tinted = brdf_principled(&p, 1, true);
            assert_float_equal(tinted.kd.x / tinted.kd.y, 0.5f, 1e-4f);
            assert_float_equal(tinted.kd.z / tinted.kd.y, 0.25f, 1e-4f);
        }
    }
}

/* More lobes than there is room for: the weakest become diffuse, and the sum is what it was. */
static void sums(void **state)
{
    (void)state;
    struct brdf sum = {0}, none = {0};
    float total = 0;
    for (int i = 0; i < 9; i++) {
        float ks = 0.02f * (float)(1 + i * 4 % 9);
        struct brdf part = brdf_phong(vec3(0, 0, 0), vec3(ks, ks, ks), 10 + (float)i);
        brdf_add(&sum, &part, vec3(0.5f, 0.5f, 0.5f));
        total += 0.5f * ks;
    }
    brdf_add(&sum, &none, WHITE);
    assert_int_equal(sum.lobe_count, BRDF_LOBES);
    float lobes = 0, least = 1;
    for (int i = 0; i < BRDF_LOBES; i++) {
        lobes += sum.lobes[i].weight.x;
        least = fminf(least, sum.lobes[i].weight.x);
    }
    assert_float_equal(sum.kd.x, 0.5f * 0.02f * (1 + 2 + 3), 1e-6f);
    assert_float_equal(lobes + sum.kd.x, total, 1e-6f);
    assert_float_equal(least, 0.5f * 0.02f * 4, 1e-6f);
}

/* Fujii's Oren-Nayar: its single scattering, which is all that a dark one does, and its albedo by quadrature of that;
 * rough white stays white. */
static void rough_diffuse(void **state)
{
    (void)state;
    const float sigma = 0.8f, a = 1 / (PI + sigma * (PI / 2 - 2.0f / 3));
    enum { GRID = 400 };
    for (int k = 1; k <= 4; k++) {
        float3 wo = direction(0.25f * (float)k, 0);
        double single = 0;
        struct brdf dark = brdf_diffuse(vec3(1e-3f, 1e-3f, 1e-3f), sigma, wo.z);
        for (int i = 0; i < GRID; i++)
            for (int j = 0; j < GRID; j++) {
                float3 wi = direction(((float)i + 0.5f) / GRID, 2 * PI * ((float)j + 0.5f) / GRID);
                float s = dot(wi, wo) - wi.z * wo.z, t = s > 0 ? fmaxf(wi.z, wo.z) : 1;
                float f = a * (1 + sigma * s / t);
                assert_float_equal(brdf_eval(&dark, vec3(0, 0, 1), wo, wi).x / 1e-3f, f, 2e-3f);
                single += (double)(f * wi.z) * 2 * PI / (GRID * GRID);
            }
        assert_float_equal(dark.kd.x / 1e-3f, single, 2e-3f);
        assert_float_equal(brdf_diffuse(WHITE, sigma, wo.z).kd.x, 1, 1e-4f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_pdf), cmocka_unit_test(white_furnace),   cmocka_unit_test(smooth_glass),
        cmocka_unit_test(reciprocity),        cmocka_unit_test(bare_refraction), cmocka_unit_test(layers),
        cmocka_unit_test(sums),               cmocka_unit_test(rough_diffuse)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
