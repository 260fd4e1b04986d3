/* SPDX-License-Identifier: Apache-2.0 */
/* Hemispherical harmonics: the basis by quadrature, and records of it against direct summation, against sources that
 * are moved, and against albedos. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>

#include "eas/hsh.h"
#include "render/rng.h"

enum { ORDER = 24, COUNT = ORDER * ORDER, LOBES = 3 };

static const float3 UP = {0, 0, 1};
static const float EXPONENTS[LOBES] = {5, 20, 100};

static struct harmonics *harmonics;
static struct hsh *hsh; /* of the exponents, as much of ORDER as they need */

static struct lobe phong(float exponent)
{
    return (struct lobe){.type = LOBE_PHONG, .weight = {1, .5f, .25f}, .exponent = exponent};
}

static int build(void **state)
{
    (void)state;
    struct lobe lobes[LOBES];
    for (int i = 0; i < LOBES; i++) lobes[i] = phong(EXPONENTS[i]);
    harmonics = harmonics_build();
    hsh = hsh_build(lobes, LOBES, 0, ORDER);
    return harmonics && hsh ? 0 : -1;
}

static int destroy(void **state)
{
    (void)state;
    harmonics_free(harmonics);
    hsh_free(hsh);
    return 0;
}

static float3 direction(float theta, float phi)
{
    return vec3(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta));
}

/* Cells of equal solid angle, `columns` a row; in each row of cells Gauss and Legendre's two heights. */
struct node {
    float3 dir;
    float weight;
};

static struct node node(int i, int rows, int columns)
{
    int column = i % columns, half = i / columns;
    float z = ((float)(half / 2) + (half & 1 ? .7886751f : .2113249f)) / (float)rows, level = sqrtf(1 - z * z);
    float phi = 2 * PI * ((float)column + .5f) / (float)columns;
    return (struct node){vec3(level * cosf(phi), level * sinf(phi), z), PI / (float)(rows * columns)};
}

/* Some functions of all kinds (zonal, near the horizon, with cosines and with sines) against all. */
static void orthonormal(void **state)
{
    (void)state;
    enum { ROWS = 400, COLUMNS = 2 * ORDER };
    const int probes[] = {0, 1, 2, 3, 100, 115, 529, 552, 575};
    static double products[9][COUNT];
    for (int i = 0; i < 2 * ROWS * COLUMNS; i++) {
        float values[COUNT];
        struct node q = node(i, ROWS, COLUMNS);
        harmonics_at(harmonics, ORDER, q.dir, values);
        for (int p = 0; p < 9; p++)
            for (int k = 0; k < COUNT; k++) products[p][k] += (double)(values[k] * values[probes[p]] * q.weight);
    }
    for (int p = 0; p < 9; p++)
        for (int k = 0; k < COUNT; k++)
            if (fabs(products[p][k] - (k == probes[p])) > 1e-3) fail_msg("(%d, %d): %g", probes[p], k, products[p][k]);
}

static void project(float f(float3), int order, float *coefficients)
{
    enum { ROWS = 400, COLUMNS = 64 };
    for (int k = 0; k < order * order; k++) coefficients[k] = 0;
    for (int i = 0; i < 2 * ROWS * COLUMNS; i++) {
        float values[COUNT];
        struct node q = node(i, ROWS, COLUMNS);
        harmonics_at(harmonics, order, q.dir, values);
        for (int k = 0; k < order * order; k++) coefficients[k] += values[k] * f(q.dir) * q.weight;
    }
}

static float sum_at(const float *coefficients, int order, float3 dir)
{
    float values[COUNT], sum = 0;
    harmonics_at(harmonics, order, dir, values);
    for (int k = 0; k < order * order; k++) sum += coefficients[k] * values[k];
    return sum;
}

/* Of azimuth 0, 1 and 2, each z^m/2 (1-z)^m/2 times a polynomial in z of 2 degrees at most: within 5 bands, not 4. */
static float polynomial(float3 d) { return d.z * d.z * (1 + d.x * d.y) + d.z * d.x * sqrtf(d.z / (1 + d.z)); }

static void span(void **state)
{
    (void)state;
    float five[COUNT], four[COUNT], off = 0;
    project(polynomial, 5, five);
    project(polynomial, 4, four);
    for (int i = 0; i < 40; i++) {
        float3 d = direction(.02f + .0385f * (float)i, 2.4f * (float)i);
        assert_float_equal(sum_at(five, 5, d), polynomial(d), 5e-4f);
        off = maxf(off, fabsf(sum_at(four, 4, d) - polynomial(d)));
    }
    assert_true(off > .004f);
}

/* sqrt(z): the integral against P_l(2z - 1) is 2 (-1)^(l+1) / ((2l-1)(2l+1)(2l+3)). What an order leaves over is the
 * rest of the sum of squares. */
static float root(float3 d) { return sqrtf(d.z); }

static void tail(void **state)
{
    (void)state;
    float c[COUNT], before = INFINITY;
    project(root, ORDER, c);
    for (int order = 2; order <= 8; order *= 2) {
        double left = 0, measured = 0;
        for (int l = order; l < 2000; l++)
            left += 2 * (double)PI * (2 * l + 1) * pow(2 / ((2.0 * l - 1) * (2.0 * l + 1) * (2.0 * l + 3)), 2);
        for (int i = 0; i < 2 * 400 * 2; i++) { /* two azimuths tell */
            struct node q = node(i, 400, 2);
            measured += (double)(sqr(sum_at(c, order, q.dir) - root(q.dir)) * q.weight);
        }
        assert_float_equal(sqrt(measured / left), 1, .05f);
        assert_true(left < .1f * before);
        before = (float)left;
    }
}

/* A function away from the horizon, tilted, against its like projected there; a turn about the normal. */
static float lobe_at(float3 d, float3 middle) { return powf(maxf(dot(d, middle), 0), 30); }
static float3 middle;
static float bump(float3 d) { return lobe_at(d, middle); }

static void rotation(void **state)
{
    (void)state;
    enum { N = 20 };
    const float thetas[] = {.3f, .5f, .5f}, phis[] = {1, 2.5f, -2}, betas[] = {.45f, .25f, .02f};
    float c[COUNT], there[COUNT], turned[COUNT];
    for (int i = 0; i < 3; i++) {
        float3 d = middle = direction(thetas[i], phis[i]);
        project(bump, N, c);
        /* Tilting takes the normal toward x. */
        float s = sinf(betas[i]), cosine = cosf(betas[i]);
        middle = vec3(cosine * d.x + s * d.z, d.y, cosine * d.z - s * d.x);
        project(bump, N, there);
        harmonics_tilt(harmonics, N, betas[i], c, c);
        double off = 0, energy = 0;
        for (int k = 0; k < N * N; k++) off += sqr(c[k] - there[k]), energy += sqr(there[k]);
        if (off > sqr(1e-4f) * energy) fail_msg("tilt %g: %g", betas[i], sqrt(off / energy));
        harmonics_turn(N, cosf(.7f), sinf(.7f), there, turned);
        for (int k = 0; k < 30; k++) {
            float3 at = direction(.05f * (float)k, (float)k);
            float3 back = vec3(cosf(.7f) * at.x + sinf(.7f) * at.y, cosf(.7f) * at.y - sinf(.7f) * at.x, at.z);
            assert_float_equal(sum_at(turned, N, at), sum_at(there, N, back), 1e-4f);
        }
    }
}

/* Light of one colour and strength from `count` directions at least `low` above the horizon of n. */
static void random_samples(struct gather_sample *samples, int count, float3 n, float low, struct rng *rng)
{
    for (int i = 0; i < count; i++) {
        float z = low + (1 - low) * rng_float(rng), phi = 2 * PI * rng_float(rng), level = sqrtf(1 - z * z);
        float3 dir = to_world(frame_about(n), vec3(level * cosf(phi), level * sinf(phi), z));
        rgb radiance = {rng_float(rng), 2 * rng_float(rng), rng_float(rng)};
        samples[i] = (struct gather_sample){dir, 1 + rng_float(rng), scale(dir, -1), radiance, .01f, {0, 0, 0}};
    }
}

static rgb summed(const struct gather_sample *samples, int count, const struct lobe *lobe, float3 n, float3 wo)
{
    rgb sum = {0};
    for (int i = 0; i < count; i++) {
        rgb f = scale(lobe_eval(lobe, n, wo, samples[i].dir), maxf(dot(n, samples[i].dir), 0) * samples[i].omega);
        sum = add(sum, mul(f, samples[i].radiance));
    }
    return sum;
}

static float *record_of(const struct gather_sample *samples, int count, float3 n, float step, int order)
{
    float *record = calloc(hsh_floats(order), sizeof *record);
    assert_non_null(record);
    hsh_add(hsh, samples, (uint32_t)count, n, step, order, record);
    return record;
}

/* A few points of light, which hold all frequencies alike, so that the error is what the lobe loses; relative to the
 * root of the mean square over viewers. */
static float reflection_error(const struct lobe *lobe, int order, float3 n, float3 record_n, float low)
{
    enum { POINTS = 24, VIEWERS = 60 };
    struct rng rng = rng_seed(3, 4, 5);
    struct gather_sample samples[POINTS];
    double off = 0, energy = 0;
    random_samples(samples, POINTS, record_n, low, &rng);
    float *record = record_of(samples, POINTS, record_n, .1f, order);
    for (int i = 0; i < VIEWERS; i++) {
        float3 wo = to_world(frame_about(n), direction(1.3f * sqrtf(rng_float(&rng)), 2 * PI * rng_float(&rng)));
        struct hsh_view view = hsh_view(hsh, lobe, n, wo);
        rgb exact = summed(samples, POINTS, lobe, n, wo);
        rgb d = sub(hsh_reflect(hsh, &view, record, order, record_n, vec3(0, 0, 0)), exact);
        off += (double)dot(d, d);
        energy += (double)dot(exact, exact);
    }
    free(record);
    return (float)sqrt(off / energy);
}

/* The bars follow what the lobes lose by order: at 45 degrees n = 5, 20, 100 lose amplitudes of .02, .3, .8 at order 5,
 * n = 100 .4, .09 and 5e-3 at orders of 10, 16 and 24. */
static void reflection(void **state)
{
    (void)state;
    const int orders[] = {5, 10, 16, 24};
    const float bars[LOBES][4] = {{.02f, 1e-3f, 5e-4f, 5e-4f}, {.3f, .03f, 2e-3f, 1e-3f}, {.9f, .5f, .12f, .015f}};
    const float3 n = normalize(vec3(.3f, -2, .4f));
    for (int i = 0; i < LOBES; i++) {
        struct lobe lobe = phong(EXPONENTS[i]);
        for (int k = 0; k < 4; k++) {
            float error = reflection_error(&lobe, orders[k], n, n, .1f);
            if (error > bars[i][k]) fail_msg("n = %g, order %d: %g", EXPONENTS[i], orders[k], error);
        }
    }
}

/* From a record whose normal is another, light above both horizons. Without the rotation it is all wrong. */
static void curved(void **state)
{
    (void)state;
    const float betas[] = {.05f, .2f, .45f};
    struct lobe lobe = phong(20);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            float3 n = direction(.4f, 2 + (float)k),
                   record_n = normalize(add(n, scale(direction(1.3f, (float)k), betas[i])));
            float error = reflection_error(&lobe, ORDER, n, record_n, .5f);
            if (error > 4e-3f) fail_msg("%g rad: %g", betas[i], error);
        }
}

/* A disc of radius .6 at height 1 over (.4, 0), facing down, gathered on a fine grid from `p`. */
static int gather_disc(float3 p, struct gather_sample **samples)
{
    enum { ROWS = 90, COLUMNS = 360 };
    int count = 0;
    *samples = calloc(ROWS * COLUMNS, sizeof **samples);
    assert_non_null(*samples);
    for (int i = 0; i < ROWS * COLUMNS; i++) {
        float z = ((float)(i / COLUMNS) + .5f) / ROWS, phi = 2 * PI * ((float)(i % COLUMNS) + .5f) / COLUMNS;
        float level = sqrtf(1 - z * z);
        float3 dir = {level * cosf(phi), level * sinf(phi), z}, q = mad(p, dir, 1 / z);
        if (sqr(q.x - .4f) + sqr(q.y) < sqr(.6f))
            (*samples)[count++] =
                (struct gather_sample){dir, 1 / z, {0, 0, -1}, {2, 2, 2}, 2 * PI / (ROWS * COLUMNS), {0, 0, 0}};
    }
    return count;
}

/* A record moved by .15 m in eight directions, against one made there, over viewers on all sides. */
static void translation(void **state)
{
    (void)state;
    struct gather_sample *samples;
    const float shift = .15f, bars[LOBES] = {.3f, .35f, .5f};
    for (int l = 0; l < LOBES; l++) {
        struct lobe lobe = phong(EXPONENTS[l]);
        double with = 0, without = 0;
        int order = hsh_order(hsh, &lobe), count = gather_disc(vec3(0, 0, 0), &samples);
        float *record = record_of(samples, count, UP, shift, order);
        free(samples);
        for (int k = 0; k < 8; k++) {
            float3 moved = scale(direction(PI / 2, .3f + PI / 4 * (float)k), shift);
            count = gather_disc(moved, &samples);
            float *fresh = record_of(samples, count, UP, shift, order);
            free(samples);
            for (int i = 0; i < 40; i++) {
                struct hsh_view view = hsh_view(hsh, &lobe, UP, direction(1.2f * (float)i / 40, 2.4f * (float)i));
                float there = hsh_reflect(hsh, &view, fresh, order, UP, vec3(0, 0, 0)).x;
                with += (double)sqr(hsh_reflect(hsh, &view, record, order, UP, moved).x - there);
                without += (double)sqr(hsh_reflect(hsh, &view, record, order, UP, vec3(0, 0, 0)).x - there);
            }
            free(fresh);
        }
        free(record);
        if (!(with < sqr(bars[l]) * without)) fail_msg("n = %g: %g of the error", EXPONENTS[l], sqrt(with / without));
    }
}

/* The environment doesn't move. */
static void infinity(void **state)
{
    (void)state;
    struct rng rng = rng_seed(1, 1, 1);
    struct gather_sample samples[20];
    struct lobe lobe = phong(20);
    random_samples(samples, 20, UP, .1f, &rng);
    for (int i = 0; i < 20; i++) samples[i].distance = INFINITY;
    float *record = record_of(samples, 20, UP, .1f, 10);
    struct hsh_view view = hsh_view(hsh, &lobe, UP, direction(.5f, 1));
    rgb here = hsh_reflect(hsh, &view, record, 10, UP, vec3(0, 0, 0));
    rgb there = hsh_reflect(hsh, &view, record, 10, UP, vec3(5, -3, 0));
    assert_true(here.x > 0 && here.x == there.x && here.y == there.y && here.z == there.z);
    free(record);
}

/* Under an even sky a record reflects the albedo, Fresnel's colours included. */
static void albedo_of_ggx(void **state)
{
    (void)state;
    enum { ROWS = 60, COLUMNS = 60, SAMPLES = 2 * ROWS * COLUMNS };
    struct lobe lobes[2] = {
        {LOBE_DIELECTRIC, {1, 1, 1}, .alpha_x = .3f, .alpha_y = .3f, .ior = 1.5f, .f0 = {.04f, .06f, .1f}},
        {LOBE_METAL, {.9f, .9f, .9f}, .alpha_x = .3f, .alpha_y = .3f, .f0 = {.9f, .6f, .3f}, .f82 = {1, 1, 1}},
    };
    struct hsh *ggx = hsh_build(lobes, 2, HSH_LOSS, ORDER);
    struct gather_sample *sky = calloc(SAMPLES, sizeof *sky);
    assert_true(ggx && sky);
    for (int i = 0; i < SAMPLES; i++) {
        struct node q = node(i, ROWS, COLUMNS);
        sky[i] = (struct gather_sample){q.dir, INFINITY, {0, 0, 0}, {1, 1, 1}, q.weight, {0, 0, 0}};
    }
    int order = hsh_order(ggx, &lobes[0]);
    float *record = calloc(hsh_floats(order), sizeof *record);
    assert_non_null(record);
    hsh_add(ggx, sky, SAMPLES, UP, 1, order, record);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 4; k++) {
            float3 wo = direction(.3f * (float)k, 1 + (float)k);
            rgb exact = summed(sky, SAMPLES, &lobes[i], UP, wo);
            struct hsh_view view = hsh_view(ggx, &lobes[i], UP, wo);
            rgb got = hsh_reflect(ggx, &view, record, order, UP, vec3(0, 0, 0));
            if (max3(sub(got, exact)) > .03f * max3(exact) || max3(sub(exact, got)) > .03f * max3(exact))
                fail_msg("lobe %d, viewer %d: %g %g %g, expected %g %g %g", i, k, got.x, got.y, got.z, exact.x, exact.y,
                         exact.z);
        }
    free(record);
    free(sky);
    hsh_free(ggx);
}

/* Narrower lobes ask for more, up to the bound; a lobe takes the nearest shape in the tables. */
static void orders(void **state)
{
    (void)state;
    struct lobe lobes[4] = {phong(10), phong(100), phong(10), phong(1000)}, other = phong(12);
    struct hsh *three = hsh_build(lobes, 4, HSH_LOSS, 20);
    assert_non_null(three);
    int ten = hsh_order(three, &lobes[0]), hundred = hsh_order(three, &lobes[1]);
    assert_true(ten >= 5 && ten < hundred && hundred < 20);
    assert_int_equal(hsh_order(three, &lobes[3]), 20);
    assert_int_equal(hsh_order(three, &other), ten);
    hsh_free(three);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(orthonormal),   cmocka_unit_test(span),
                                       cmocka_unit_test(tail),          cmocka_unit_test(rotation),
                                       cmocka_unit_test(reflection),    cmocka_unit_test(curved),
                                       cmocka_unit_test(translation),   cmocka_unit_test(infinity),
                                       cmocka_unit_test(albedo_of_ggx), cmocka_unit_test(orders)};
    return cmocka_run_group_tests(tests, build, destroy);
}
