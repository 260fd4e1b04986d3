/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of a reflectance about the normal (0, 0, 1): its samples against its pdf, its albedo. cmocka.h comes before
 * this. */
#ifndef TESTS_REFLECTANCE_H
#define TESTS_REFLECTANCE_H

#include "eas/brdf.h"
#include "render/rng.h"

static const float3 N = {0, 0, 1};

static inline float3 direction(float cosine, float phi)
{
    float s = sqrtf(fmaxf(1 - cosine * cosine, 0));
    return vec3(s * cosf(phi), s * sinf(phi), cosine);
}

/* Bins about the mirror direction, whose rings widen with the square of the angle; the last bin counts what was
 * refused. */
enum { RINGS = 16, SECTORS = 16, BINS = RINGS * SECTORS, STEPS = 12, SAMPLES = 250000 };

static inline int bin_of(struct frame mirror, float3 wi)
{
    float3 v = to_local(mirror, wi);
    float ring = sqrtf(acosf(clampf(v.z, -1, 1)) / PI) * RINGS, sector = (atan2f(v.y, v.x) / (2 * PI) + 0.5f) * SECTORS;
    int r = (int)ring, s = (int)sector;
    return (r < RINGS ? r : RINGS - 1) * SECTORS + (s < SECTORS ? s : SECTORS - 1);
}

/* The pdf over a bin by midpoints. */
static inline double bin_chance(const struct brdf *brdf, struct frame mirror, float3 wo, int bin)
{
    double sum = 0;
    float r0 = (float)(bin / SECTORS) / RINGS, r1 = (float)(bin / SECTORS + 1) / RINGS;
    float a0 = PI * r0 * r0, a1 = PI * r1 * r1, p0 = (float)(bin % SECTORS) / SECTORS - 0.5f;
    for (int i = 0; i < STEPS; i++)
        for (int j = 0; j < STEPS; j++) {
            float a = a0 + (a1 - a0) * ((float)i + 0.5f) / STEPS,
                  phi = 2 * PI * (p0 + ((float)j + 0.5f) / STEPS / SECTORS);
            sum += (double)brdf_pdf(brdf, N, wo, to_world(mirror, direction(cosf(a), phi))) * sinf(a);
        }
    return sum * (a1 - a0) * 2 * PI / SECTORS / (STEPS * STEPS);
}

/* Chi-square of brdf_sample's directions against brdf_pdf, its weights against brdf_eval. */
static inline void check_sampling(const char *name, const struct brdf *brdf, float3 wo)
{
    static double counts[BINS + 1];
    for (int i = 0; i <= BINS; i++) counts[i] = 0;
    struct frame mirror = frame_about(reflect(wo, N));
    struct rng rng = rng_seed(1, 2, 3);
    for (int i = 0; i < SAMPLES; i++) {
        float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)}, pdf;
        float3 wi;
        rgb weight = brdf_sample(brdf, N, wo, u, &wi, &pdf);
        if (pdf <= 0) {
            counts[BINS]++;
            continue;
        }
        counts[bin_of(mirror, wi)]++;
        if (i % 64 == 0) {
            rgb f = brdf_eval(brdf, N, wo, wi);
            assert_float_equal(pdf / brdf_pdf(brdf, N, wo, wi), 1, 1e-4f);
            assert_float_equal(weight.y * pdf, f.y * fabsf(wi.z), 1e-4f * f.y * fabsf(wi.z) + 1e-20f);
        }
    }
    double chi2 = 0, few_expected = 0, few_found = 0, sum = 0;
    int degrees = 0;
    for (int i = 0; i <= BINS; i++) {
        double chance = i < BINS ? bin_chance(brdf, mirror, wo, i) : fmax(1 - sum, 0), expected = chance * SAMPLES;
        sum += chance;
        if (i == BINS) assert_true(sum < 1.005); /* refused ones make up the rest, never less than none */
        if (expected < 50) {                     /* pooled: chi-square needs counts */
            few_expected += expected;
            few_found += counts[i];
            continue;
        }
        /* The quadrature's own error at the horizon's edge, 1 %, goes into the variance, and into that of the refused
         * ones that of a pdf which rests on Walter's fit of Lambda, .35 % of all. */
        double off = i < BINS ? .01 * expected : .0035 * SAMPLES;
        chi2 += (counts[i] - expected) * (counts[i] - expected) / (expected + off * off);
        degrees++;
    }
    if (few_expected > 50) {
        chi2 += (few_found - few_expected) * (few_found - few_expected) /
                (few_expected + 1e-4 * few_expected * few_expected);
        degrees++;
    }
    double sigma = (chi2 - degrees) / sqrt(2.0 * degrees);
    if (sigma > 4.5) print_message("%s, cos_o %.2f: chi2 %.1f of %d\n", name, (double)wo.z, chi2, degrees);
    assert_true(sigma < 4.5);
}

/* What comes back of white light by a grid over the hemisphere on the viewer's side (side 1) or the other (-1), even in
 * the cosine; sees only brdf_eval. */
static inline rgb albedo_of_side(const struct brdf *brdf, float3 wo, float side)
{
    enum { COSINES = 400, ANGLES = 400 };
    double sum[3] = {0};
    for (int i = 0; i < COSINES; i++)
        for (int j = 0; j < ANGLES; j++) {
            float3 wi = direction(side * ((float)i + 0.5f) / COSINES, 2 * PI * ((float)j + 0.5f) / ANGLES);
            rgb f = scale(brdf_eval(brdf, N, wo, wi), fabsf(wi.z));
            sum[0] += f.x, sum[1] += f.y, sum[2] += f.z;
        }
    double area = 2 * (double)PI / (COSINES * ANGLES);
    return vec3((float)(sum[0] * area), (float)(sum[1] * area), (float)(sum[2] * area));
}

static inline rgb albedo_by_grid(const struct brdf *brdf, float3 wo) { return albedo_of_side(brdf, wo, 1); }

/* Of both sides, by the mean weight of brdf_sample. */
static inline rgb albedo_by_samples(const struct brdf *brdf, float3 wo, int count)
{
    double sum[3] = {0};
    struct rng rng = rng_seed(5, 6, 7);
    for (int i = 0; i < count; i++) {
        float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)}, pdf;
        float3 wi;
        rgb w = brdf_sample(brdf, N, wo, u, &wi, &pdf);
        sum[0] += w.x, sum[1] += w.y, sum[2] += w.z;
    }
    return vec3((float)(sum[0] / count), (float)(sum[1] / count), (float)(sum[2] / count));
}

#endif
