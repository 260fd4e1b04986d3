/* SPDX-License-Identifier: Apache-2.0 */
/* Lamps at the points of a pixel: render/direct against quadrature over the lamp, and well spread samples. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "render/direct.h"
#include "render/sequence.h"
#include "tests/stage.h"

static const float RADIANCE = 10;

/* A floor under a square lamp of side 1 at height 1.5 that is a mesh of two triangles and faces down. */
static struct stage *lamp_over_floor(float kd, float ks, float exponent, float radiance)
{
    struct stage *s = new_stage();
    struct scene_material lamp = grey(0, 0, 0, radiance);
    lamp.emission_back = false;
    add_quad(s, vec3(0, 0, 0), vec3(4, 0, 0), vec3(0, 4, 0), grey(kd, ks, exponent, 0));
    add_quad(s, vec3(0, 0, 1.5f), vec3(0, .5f, 0), vec3(.5f, 0, 0), lamp);
    return s;
}

/* What the floor at `point` reflects of the lamp's half x < limit: midpoints of 400 x 400 cells. */
static double quadrature(const struct point *point, float limit)
{
    enum { SIDE = 400 };
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        float3 q = vec3(((float)(i % SIDE) + .5f) / SIDE - .5f, ((float)(i / SIDE) + .5f) / SIDE - .5f, 1.5f);
        float3 to = sub(q, point->p), wi = normalize(to);
        if (q.x < limit) sum += brdf_eval(&point->brdf, point->n, point->wo, wi).x * wi.z * wi.z / dot(to, to);
    }
    return sum * RADIANCE / (SIDE * SIDE);
}

static struct point floor_point(const struct model *model, float3 eye, float3 at)
{
    struct ray ray = {eye, normalize(sub(at, eye))};
    struct hit hit;
    struct point point;
    assert_true(trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit));
    shade_point(model, ray, &hit, &point);
    return point;
}

/* The light of a pixel's 16 samples, all at one point. memory: NULL or what the seeds before have left. */
static float rendered_after(const struct model *model, const struct mean_brdf *tables, const struct point *point,
                            uint64_t seed, struct shadow_memory *memory)
{
    struct shadow_memory none;
    direct_forget(&none);
    struct direct direct;
    assert_true(direct_prepare(model, tables, false, &direct));
    struct rng rng = rng_seed(seed, 0, 0);
    struct sequence lamp = sequence_draw(&rng, 16);
    struct point wide = *point;
    wide.brdf.lobe_count = direct_sort(&wide.brdf);
    bool averages = direct_averages(&direct, &wide), near = direct_near(model, point);
    int averaged = averages ? wide.brdf.lobe_count : 0;
    struct light_weights weights;
    lights_weigh(model->lights, point->origin, point->n, &weights);
    rgb sum = {0};
    for (int i = 0; i < 16; i++) {
        float2 on_lamp = sequence_point(lamp, i);
        float u[3] = {((float)i + rng_float(&rng)) / 16, on_lamp.x, on_lamp.y};
        sum = mad(sum, direct_sample(&direct, point, &weights, u, averaged, near), 1.0f / 16);
        if (near) sum = mad(sum, direct_met(model, point, u + 1), 1.0f / 16);
    }
    sum = add(sum, direct_light(&direct, &wide, averages, &point->origin, 1, 64, memory ? memory : &none, &rng));
    direct_free(&direct);
    return sum.x;
}

static float rendered(const struct model *model, const struct mean_brdf *tables, const struct point *point,
                      uint64_t seed)
{
    return rendered_after(model, tables, point, seed, NULL);
}

/* Without shadows lobes have no noise: every seed within 1.5 % of quadrature and .0005 of the peak. */
static void unshadowed(void **state)
{
    const float exponents[] = {20, 100, 200};
    for (int k = 0; k < 3; k++)
        for (int place = -2; place <= 2; place++) {
            struct stage *s = lamp_over_floor(0, .5f, exponents[k], RADIANCE);
            struct model model = build(s);
            struct point point = floor_point(&model, vec3(-1.5f, .2f, 1.4f), vec3(.4f * (float)place, 0, 0));
            float truth = (float)quadrature(&point, INFINITY);
            for (uint64_t seed = 1; seed <= 3; seed++)
                assert_float_equal(rendered(&model, *state, &point, seed), truth, .015f * truth + .002f);
            end(s, &model);
        }
}

/* A blocker that hides the lamp's part x > edge from the point: the mean over seeds within 4 % of quadrature,
 * though the highlight changes within the lamp's cells. */
static void partly_shadowed(void **state)
{
    const float exponents[] = {40, 200}, edges[] = {-.1f, 0, .1f};
    for (int k = 0; k < 6; k++) {
        float edge = edges[k / 2];
        struct stage *s = lamp_over_floor(.3f, .5f, exponents[k % 2], RADIANCE);
        add_quad(s, vec3(edge / 2 + .5f, 0, .75f), vec3(.5f, 0, 0), vec3(0, 1, 0), grey(0, 0, 0, 0));
        struct model model = build(s);
        struct point point = floor_point(&model, vec3(-.2f, 0, 1.4f), vec3(0, 0, 0));
        float truth = (float)quadrature(&point, edge), sum = 0;
        struct shadow_memory memory;
        direct_forget(&memory);
        for (uint64_t seed = 0; seed < 400; seed++)
            sum += rendered_after(&model, *state, &point, seed, &memory) / 400;
        assert_float_equal(sum / truth, 1, .04f);
        end(s, &model);
    }
}

/* A lamp that has all cells to itself is averaged over them; not one that gets few, for another is brighter, though
 * hidden: the highlight would have a quarter of its light. */
static void coarse_cells(void **state)
{
    for (int other = 0; other < 2; other++) {
        struct stage *s = lamp_over_floor(0, .5f, 100, RADIANCE);
        struct scene_material bright = grey(0, 0, 0, 200 * RADIANCE);
        bright.emission_back = false;
        if (other) add_quad(s, vec3(0, 3, 1.5f), vec3(0, .5f, 0), vec3(.5f, 0, 0), bright);
        add_quad(s, vec3(0, 1.5f, 1), vec3(2, 0, 0), vec3(0, 0, .99f), grey(0, 0, 0, 0));
        struct model model = build(s);
        struct point point = floor_point(&model, vec3(-.25f, 0, .9f), vec3(0, 0, 0));
        struct direct direct;
        assert_true(direct_prepare(&model, *state, false, &direct));
        assert_int_equal(direct_averages(&direct, &point), !other);
        direct_free(&direct);
        end(s, &model);
    }
}

/* A floor under a sky with one bright spot, a wall before some of it or not, by many pixels whose shadow rays remember
 * what those before have found, or start anew: mean light, and rays. */
static float under_sky(const struct mean_brdf *tables, bool wall, bool remembers, uint64_t *rays)
{
    enum { PIXELS = 3000 };
    struct stage *s = new_stage();
    add_quad(s, vec3(0, 0, 0), vec3(4, 0, 0), vec3(0, 4, 0), grey(.5f, 0, 0, 0));
    if (wall) add_quad(s, vec3(2, -2.25f, 0), vec3(0, 2, 0), vec3(0, 0, 4), grey(0, 0, 0, 0));
    add_sky(s);
    struct model model = build(s);
    struct point point = floor_point(&model, vec3(.5f, -2, 1.4f), vec3(.5f, 0, 0));
    struct shadow_memory memory;
    direct_forget(&memory);
    double sum = 0;
    for (uint64_t seed = 0; seed < PIXELS; seed++)
        sum += (double)rendered_after(&model, tables, &point, seed, remembers ? &memory : NULL) / PIXELS;
    *rays = trace_rays(model.trace);
    end(s, &model);
    return (float)sum;
}

/* What shadow rays remember changes where the next go and how many, not their mean, here within .4 % (4 sigma). */
static void remembered(void **state)
{
    uint64_t anew, after;
    float whole = under_sky(*state, false, false, &anew);
    assert_float_equal(under_sky(*state, false, true, &after), whole, 1e-5f * whole);
    assert_true(after < anew / 4);
    float part = under_sky(*state, true, false, &anew);
    assert_true(part > .6f * whole && part < .9f * whole);
    assert_float_equal(under_sky(*state, true, true, &after), part, .004f * part);
}

/* Irradiance over radiance at a wall's point `depth` below the lamp's edge, .1 m from its middle: the sum over its
 * sides of half their angle times the cosine of their plane's normal (Lambert 1760). */
static double beside(double depth)
{
    const double corners[4][3] = {{0, -.6, depth}, {0, .4, depth}, {1, .4, depth}, {1, -.6, depth}};
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        const double *a = corners[i], *b = corners[(i + 1) % 4];
        double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
        double sine = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]),
               cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        sum += atan2(sine, cosine) / 2 * n[0] / sine;
    }
    return fabs(sum);
}

/* A wall that the lamp touches with an edge, seen 1 to 64 mm below it: 100 pixels within 3 % of the light, each
 * within 40 %. */
static void beside_a_lamp(void **state)
{
    for (int k = 0; k < 4; k++) {
        struct stage *s = lamp_over_floor(.5f, 0, 0, RADIANCE);
        add_quad(s, vec3(-.5f, 0, 1), vec3(0, .5f, 0), vec3(0, 0, .499f), grey(.5f, 0, 0, 0));
        struct model model = build(s);
        float depth = .001f * (float)(1 << 2 * k);
        struct point point = floor_point(&model, vec3(0, 0, 1), vec3(-.5f, .1f, 1.5f - depth));
        double truth = .5 * RADIANCE / PI * beside(depth), sum = 0;
        for (uint64_t seed = 0; seed < 100; seed++) {
            float light = rendered(&model, *state, &point, seed);
            assert_float_equal(light / truth, 1, .4f);
            sum += (double)light / 100;
        }
        assert_float_equal(sum / truth, 1, .03f);
        end(s, &model);
    }
}

/* A floor 2 cm under the lamp, which nearly fills what it sees: 100 pixels within 1 % of the light, each within 10 %.
 * By lamp samples alone a pixel has two thirds of it, or more than all. */
static void close_to_a_lamp(void **state)
{
    struct stage *s = lamp_over_floor(.5f, 0, 0, RADIANCE);
    add_quad(s, vec3(0, 0, 1.48f), vec3(.2f, 0, 0), vec3(0, .2f, 0), grey(.5f, 0, 0, 0));
    struct model model = build(s);
    struct point point = floor_point(&model, vec3(-.1f, 0, 1.49f), vec3(0, 0, 1.48f));
    double truth = .5 * RADIANCE, sum = 0; /* but for 1.6e-3 of what is beside the lamp */
    assert_true(direct_near(&model, &point));
    for (uint64_t seed = 0; seed < 100; seed++) {
        float light = rendered(&model, *state, &point, seed);
        assert_float_equal(light / truth, 1, .1f);
        sum += (double)light / 100;
    }
    assert_float_equal(sum / truth, 1, .01f);
    end(s, &model);
}

/* A lobe too narrow for the cells: the share left to light sampling is the MIS-weighted one, so less than all. */
static void unresolved(void **state)
{
    struct stage *s = lamp_over_floor(0, .5f, 2000, RADIANCE);
    struct model model = build(s);
    struct point point = floor_point(&model, vec3(-.2f, 0, 1.2f), vec3(0, 0, 0));
    assert_false(direct_resolves(&point.brdf.lobes[0]));
    float truth = (float)quadrature(&point, INFINITY), sum = 0;
    for (uint64_t seed = 0; seed < 400; seed++) sum += rendered(&model, *state, &point, seed) / 400;
    assert_true(sum > 0 && sum < truth);
    end(s, &model);
}

/* Light too faint for single precision, as far off a lobe, is a number. */
static void faint(void **state)
{
    for (int k = 0; k < 12; k++) {
        struct stage *s = lamp_over_floor(0, .5f, 20, powf(10, -33 - (float)k));
        struct model model = build(s);
        struct point point = floor_point(&model, vec3(-1.5f, .2f, 1.4f), vec3(.3f * (float)k, 0, 0));
        for (uint64_t seed = 1; seed <= 3; seed++) {
            float light = rendered(&model, *state, &point, seed);
            assert_true(light >= 0 && light < 1e-30f);
        }
        end(s, &model);
    }
}

/* A lamp closed on all sides, seen from outside: its backs don't count, whatever the strategy. A sphere would do; a
 * cube has an exact answer: below its bottom face only that face lights the floor. */
static void closed_emitter(void **state)
{
    struct stage *s = new_stage();
    add_quad(s, vec3(0, 0, -1.5f), vec3(4, 0, 0), vec3(0, 4, 0), grey(.8f, 0, 0, 0));
    add_cube(s, .5f, grey(0, 0, 0, RADIANCE));
    struct model model = build(s);
    struct point point = floor_point(&model, vec3(0, -2, -1.4f), vec3(0, 0, -1.5f));
    /* Form factor of a square of side 1 at distance 1 above the point on its axis: 4 corners of .5 x .5. */
    double a = .5 / 1.0, corner = (a / sqrt(1 + a * a) * atan(a / sqrt(1 + a * a))) * 2 / (2 * 3.14159265358979);
    float truth = (float)(.8 * RADIANCE * 4 * corner), sum = 0;
    for (uint64_t seed = 0; seed < 2000; seed++) sum += rendered(&model, *state, &point, seed) / 2000;
    assert_float_equal(sum, truth, .01f * truth);
    end(s, &model);
}

/* Each of 16 points alone in its box, for all cuts of the square into 16 equal boxes. */
static void sequences_are_stratified(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        struct rng rng = rng_seed(seed, 1, 2);
        struct sequence sequence = sequence_draw(&rng, 16);
        for (int cut = 0; cut <= 4; cut++) {
            uint32_t seen = 0;
            for (int i = 0; i < 16; i++) {
                float2 p = sequence_point(sequence, i);
                uint32_t x = (uint32_t)(p.x * (float)(1 << cut)), y = (uint32_t)(p.y * (float)(16 >> cut));
                seen |= 1u << (x * (uint32_t)(16 >> cut) + y);
            }
            assert_int_equal(seen, 0xffff);
        }
    }
}

static int setup(void **state) { return (*state = mean_brdf_build()) ? 0 : -1; }
static int teardown(void **state) { return mean_brdf_free(*state), 0; }

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(unshadowed),
                                       cmocka_unit_test(partly_shadowed),
                                       cmocka_unit_test(coarse_cells),
                                       cmocka_unit_test(remembered),
                                       cmocka_unit_test(close_to_a_lamp), cmocka_unit_test(beside_a_lamp),
                                       cmocka_unit_test(unresolved),
                                       cmocka_unit_test(faint),
                                       cmocka_unit_test(closed_emitter),
                                       cmocka_unit_test(sequences_are_stratified)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
