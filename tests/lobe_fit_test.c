/* SPDX-License-Identifier: Apache-2.0 */
/* The paper's fitted lobes against F~ by quadrature, at viewers of the test's own, uniform over a disc about the mirror
 * direction; and beside them the default's error. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <string.h>

#include "eas/lobe_fit.h"

enum { VIEWERS = 300 };
#define DEGREE (PI / 180)

static struct lobe phong(float exponent) { return brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), exponent).lobes[0]; }
static float3 in_plane(float angle) { return vec3(sinf(angle), 0, cosf(angle)); }
static float omega_of(float radius) { return 4 * PI * sqr(sinf(radius / 2)); }

/* F~ of a cap at viewers within `spread` of its mirror direction; returns the largest value. */
struct truth {
    int count;
    float3 wi, wo[VIEWERS];
    float omega, value[VIEWERS], largest;
};

static void look(const struct lobe *lobe, float theta, float radius, float spread, struct truth *t)
{
    *t = (struct truth){.wi = in_plane(theta), .omega = omega_of(radius)};
    struct frame mirror = frame_about(in_plane(-theta));
    for (int i = 0; i < VIEWERS; i++) {
        float z = 1 - (1 - cosf(spread)) * ((float)i + .5f) / VIEWERS, r = sqrtf(1 - z * z), phi = 2.399963f * (float)i;
        float3 wo = to_world(mirror, vec3(r * cosf(phi), r * sinf(phi), z));
        if (wo.z <= 0) continue;
        t->wo[t->count] = wo;
        t->value[t->count] = lobe_fit_exact(lobe, t->wi, t->omega, wo, 48);
        t->largest = maxf(t->largest, t->value[t->count++]);
    }
}

struct errors {
    float rms, most; /* of the largest value */
};

static struct errors fit_errors(const struct truth *t, const struct lobe_fit *fit)
{
    struct errors e = {0};
    for (int i = 0; i < t->count; i++) {
        float error = fabsf(lobe_fit_eval(fit, t->wi, t->wo[i]) - t->value[i]) / t->largest;
        e.rms += sqr(error) / (float)t->count;
        e.most = maxf(e.most, error);
    }
    e.rms = sqrtf(e.rms);
    return e;
}

static float default_error(const struct truth *t, const struct mean_brdf *tables, const struct lobe *lobe)
{
    float most = 0;
    for (int i = 0; i < t->count; i++) {
        struct mean_lobe mean = mean_lobe(tables, lobe, vec3(0, 0, 1), t->wo[i]);
        float value = luminance(mean_lobe_cap(&mean, (struct cap){t->wi, t->omega})) / lobe_fit_cosine(t->wi, t->omega);
        most = maxf(most, fabsf(value - t->value[i]) / t->largest);
    }
    return most;
}

/* The paper's denominator, against midpoints of the cosine. */
static void cosine(void **state)
{
    (void)state;
    struct brdf white = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), 0); /* cos^0: f = 1/pi */
    float3 wi = in_plane(.8f);
    float integral =
        mean_lobe_quadrature(&white.lobes[0], vec3(0, 0, 1), vec3(0, 0, 1), (struct cap){wi, .9f}, 200, 200).x;
    assert_float_equal(lobe_fit_cosine(wi, .9f) / (PI * integral), 1, 1e-4f);
}

/* A cap of no size: the lobe itself, (n+2)/2pi cos^n about the mirror direction. */
static void the_lobe_itself(void **state)
{
    (void)state;
    const float exponents[] = {5, 40, 200};
    for (int k = 0; k < 3; k++) {
        struct lobe lobe = phong(exponents[k]);
        struct lobe_fit fit;
        assert_true(lobe_fit(&lobe, .7f, 0, &fit));
        float c = powf((exponents[k] + 2) / (2 * PI), 1 / exponents[k]);
        assert_float_equal(fit.exponent / exponents[k], 1, 2e-3f);
        assert_float_equal(fit.cx, -c, 1e-3f);
        assert_float_equal(fit.cz, c, 1e-3f);
    }
}

/* What the headers say of both ways, at n = 200 and elsewhere: the fit is good while the cap is narrower than the lobe,
 * and the default everywhere. */
static void errors_beside_the_default(void **state)
{
    const struct {
        float exponent, degrees, rms, most;
    } cases[] = {{40, 4, .001f, .002f}, {200, 4, .002f, .01f}, {40, 8, .002f, .005f}, {100, 8, .008f, .025f},
                 {200, 8, .02f, .08f},  {100, 12, .03f, .09f}, {40, 20, .04f, .1f},   {200, 20, .15f, .35f}};
    for (int k = 0; k < 8; k++) {
        struct lobe lobe = phong(cases[k].exponent);
        struct truth t;
        struct lobe_fit fit;
        float radius = cases[k].degrees * DEGREE;
        look(&lobe, .9f, radius, radius + 3 / sqrtf(cases[k].exponent), &t);
        assert_true(lobe_fit(&lobe, .9f, t.omega, &fit));
        struct errors e = fit_errors(&t, &fit);
        float other = default_error(&t, *state, &lobe);
        if (!(e.rms < cases[k].rms && e.most < cases[k].most && other < 2.5e-3f))
            fail_msg("n = %g, %g degrees: fit %g rms, %g at most; default %g", cases[k].exponent, cases[k].degrees,
                     e.rms, e.most, other);
        if (cases[k].exponent == 200 && cases[k].degrees >= 8) assert_true(e.most > .04f);
    }
}

/* No other lobe does better in squares: neither nearby nor anywhere on a grid of leans, exponents and heights. */
static void none_better(void **state)
{
    (void)state;
    const float radii[] = {.05f, .14f, .3f};
    for (int k = 0; k < 3; k++) {
        struct lobe lobe = phong(100);
        struct truth t;
        struct lobe_fit fit, other;
        look(&lobe, 1, radii[k], 1.2f, &t);
        assert_true(lobe_fit(&lobe, 1, t.omega, &fit));
        float least = fit_errors(&t, &fit).rms;
        for (int i = -12; i <= 12; i++)
            for (int j = 0; j < 25; j++)
                for (int h = 0; h < 10; h++) {
                    float angle = 1 + .04f * (float)i, exponent = 3 * powf(1.22f, (float)j);
                    float c = powf(t.largest * (.7f + .06f * (float)h), 1 / exponent);
                    other = (struct lobe_fit){-c * sinf(angle) / t.wi.x, c * cosf(angle) / t.wi.z, exponent};
                    assert_true(least < 1.02f * fit_errors(&t, &other).rms);
                }
        for (int i = 0; i < 6; i++) {
            float change = i & 1 ? 1.01f : .99f;
            other = fit;
            if (i / 2 == 0) other.exponent *= change;
            else if (i / 2 == 1) other.cx *= 1 + .1f * (change - 1);
            else other.cz *= 1 + .1f * (change - 1);
            assert_true(least < 1.02f * fit_errors(&t, &other).rms);
        }
    }
}

/* GGX, whose tails no power of a cosine has: roughly; at a grazing angle leaning to the horizon. */
static void ggx(void **state)
{
    (void)state;
    struct glossy metal = {{1, 1, 1}, .4f, .distribution = DISTRIBUTION_MULTI_GGX};
    struct truth t;
    struct lobe_fit fit;
    for (int k = 0; k < 2; k++) {
        float theta = k ? 1.2f : .4f;
        struct lobe lobe = brdf_glossy(&metal, cosf(theta)).lobes[0];
        look(&lobe, theta, .1f, .6f, &t);
        assert_true(lobe_fit(&lobe, theta, t.omega, &fit));
        struct errors e = fit_errors(&t, &fit);
        if (!(e.rms < (k ? .15f : .06f))) fail_msg("theta %g: %g rms, %g at most", theta, e.rms, e.most);
        float lean = atan2f(-fit.cx * t.wi.x, fit.cz * t.wi.z) - theta;
        assert_true(k ? lean > .05f : fabsf(lean) < .04f);
    }
}

/* Cells as the paper lays them, linear between, the nearest outside; the same bytes again. */
static void table(void **state)
{
    (void)state;
    enum { THETAS = 4, OMEGAS = 5 };
    struct lobe lobe = phong(60);
    struct lobe_fit_table one, two;
    struct lobe_fit fit;
    assert_true(lobe_fit_table_build(&lobe, THETAS, OMEGAS, &one) && lobe_fit_table_build(&lobe, THETAS, OMEGAS, &two));
    assert_memory_equal(one.fits, two.fits, (THETAS - 1) * (OMEGAS + 1) * sizeof *one.fits);
    float theta = 2 * PI / (2 * THETAS), omega = 3 * 2 * PI * (1 - sinf(theta)) / OMEGAS;
    assert_true(lobe_fit(&lobe, theta, omega, &fit));
    struct lobe_fit at = lobe_fit_table_at(&one, theta, omega);
    assert_float_equal(at.exponent, fit.exponent, 1e-3f * fit.exponent);
    assert_float_equal(at.cx, fit.cx, 1e-4f);
    assert_float_equal(at.cz, fit.cz, 1e-4f);
    /* Between two thetas, at an Omega that both rows have: the mean of what each has. */
    float before = theta - PI / (4 * THETAS);
    struct lobe_fit a = lobe_fit_table_at(&one, theta - PI / (2 * THETAS), .2f),
                    b = lobe_fit_table_at(&one, theta, .2f);
    struct lobe_fit middle = lobe_fit_table_at(&one, before, .2f);
    assert_float_equal(middle.exponent, (a.exponent + b.exponent) / 2, 1e-3f);
    assert_float_equal(middle.cx, (a.cx + b.cx) / 2, 1e-5f);
    assert_float_equal(middle.cz, (a.cz + b.cz) / 2, 1e-5f);
    struct lobe_fit widest = lobe_fit_table_at(&one, 1.5f, 3), last = one.fits[(THETAS - 1) * (OMEGAS + 1) - 1];
    assert_memory_equal(&widest, &last, sizeof last);
    lobe_fit_table_free(&one);
    lobe_fit_table_free(&two);
}

static int setup(void **state) { return (*state = mean_brdf_build()) ? 0 : -1; }
static int teardown(void **state) { return mean_brdf_free(*state), 0; }

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(cosine),      cmocka_unit_test(the_lobe_itself),
                                       cmocka_unit_test(none_better), cmocka_unit_test(errors_beside_the_default),
                                       cmocka_unit_test(ggx),         cmocka_unit_test(table)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
