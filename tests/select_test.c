/* SPDX-License-Identifier: Apache-2.0 */
/* Selection of EAS: how many, and how well they reflect, against all samples and against quadrature. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>

#include "eas/irradiance.h"
#include "eas/select.h"
#include "render/rng.h"

enum { ROWS = 24, COUNT = ROWS * 4 * ROWS, VIEWS = 64 };
static const float3 ORIGIN = {1, 0, -1};

struct scene_light {
    struct mean_brdf *tables;
    struct gather_sample samples[COUNT];
    struct sample_tree tree;
    struct select_scratch scratch;
    struct select_place place;
    struct brdf brdf;
    struct eas chosen[COUNT], all[COUNT];
};

/* Radiance by local direction and distance, sampled about a tilted normal. */
static void light(struct scene_light *s, float (*radiance)(float3 local), float distance)
{
    struct rng rng = rng_seed(4, 5, 6);
    struct gather_grid grid = {ROWS, 4 * ROWS};
    for (int i = 0; i < COUNT; i++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        float3 local = gather_direction(grid, i / grid.columns, i % grid.columns, u, v);
        float3 dir = to_world(s->place.frame, local);
        float l = radiance(local);
        s->samples[i] =
            (struct gather_sample){dir, distance, scale(dir, -1), vec3(l, l, l), 2 * PI / COUNT, vec3(0, 0, 0)};
    }
    assert_true(sample_tree_build(&s->tree, s->samples, COUNT, ORIGIN, s->place.frame));
    for (int i = 0; i < COUNT; i++) {
        float3 at = isinf(distance) ? s->samples[i].dir : mad(ORIGIN, s->samples[i].dir, distance);
        s->all[i] = eas_make(ORIGIN, at, s->samples[i].normal, s->samples[i].radiance, 2 * PI / COUNT, isinf(distance));
    }
}

static uint32_t choose(struct scene_light *s, struct select_options options)
{
    uint32_t count = select_eas(&s->tree, 1, s->tables, s->brdf.lobes, 1, &s->place, &options, &s->scratch, s->chosen);
    assert_true(count <= (uint32_t)options.most);
    return count;
}

/* Viewer i of the test's own: spread over the hemisphere but its rim. */
static float3 viewer(const struct scene_light *s, int i)
{
    float z = 1 - .95f * ((float)i + .5f) / VIEWS, phi = 2.399963f * (float)i, r = sqrtf(1 - z * z);
    return to_world(s->place.frame, vec3(r * cosf(phi), r * sinf(phi), z));
}

/* CV(RMSE) of what the selection reflects against all samples, at the record. */
static float error(struct scene_light *s, uint32_t count)
{
    double squares = 0, sum = 0;
    for (int i = 0; i < VIEWS; i++) {
        struct mean_lobe lobe = mean_lobe(s->tables, &s->brdf.lobes[0], s->place.frame.n, viewer(s, i));
        double exact = eas_reflect(s->all, COUNT, &lobe, ORIGIN).x,
               value = eas_reflect(s->chosen, count, &lobe, ORIGIN).x;
        squares += (value - exact) * (value - exact);
        sum += exact;
    }
    return (float)(sqrt(squares / VIEWS) / (sum / VIEWS));
}

static float one(float3 local) { return (void)local, 1; }
static float none(float3 local) { return (void)local, 0; }
/* Bright windows on a dim slope. */
static float windows(float3 d)
{
    bool window = d.z > .2f && sinf(7 * d.x) * sinf(5 * d.y + 1) > .3f;
    return .3f + .2f * d.x + (window ? 3.0f : 0);
}

/* Even light needs a twentieth of the samples, and they reflect the lobe's albedo for every viewer: within 4 % on the
 * average, since the caps of groups overlap and leave gaps. */
static void even_light(void **state)
{
    struct scene_light *s = *state;
    struct select_options options = SELECT_DEFAULTS;
    const float distances[] = {INFINITY, 3};
    s->place.radius = .05f;
    for (int k = 0; k < 2; k++) {
        light(s, one, distances[k]);
        uint32_t count = choose(s, options);
        assert_in_range(count, 1, COUNT / 16);
        double squares = 0, sum = 0;
        for (int i = 0; i < VIEWS; i++) {
            float3 wo = viewer(s, i), n = s->place.frame.n;
            struct mean_lobe lobe = mean_lobe(s->tables, &s->brdf.lobes[0], n, wo);
            rgb value = eas_reflect(s->chosen, count, &lobe, ORIGIN);
            rgb exact = mean_lobe_quadrature(&s->brdf.lobes[0], n, wo, (struct cap){n, 2 * PI}, 96, 192);
            assert_float_equal(value.x, exact.x, .08f);
            squares += sqr(value.x - exact.x);
            sum += exact.x;
        }
        assert_true(sqrt(squares / VIEWS) < .04 * sum / VIEWS);
    }
}

/* A smaller tau takes more EAS and errs less: what the directions of the selection promise holds for others. */
static void tau(void **state)
{
    struct scene_light *s = *state;
    const float taus[] = {.3f, .1f, .03f, .01f};
    const float distances[] = {INFINITY, 2};
    s->place.radius = 0;
    for (int k = 0; k < 2; k++) {
        uint32_t count_before = 0;
        float error_before = INFINITY;
        light(s, windows, distances[k]);
        for (int i = 0; i < 4; i++) {
            struct select_options options = SELECT_DEFAULTS;
            options.tau = taus[i];
            options.directions = SELECT_DIRECTIONS;
            options.most = COUNT;
            uint32_t count = choose(s, options);
            float e = error(s, count);
            if (!(e < 2 * taus[i] && e < error_before && count > count_before && count < COUNT))
                fail_msg("tau %g: %u EAS, error %g (before: %u, %g)", taus[i], count, e, count_before, error_before);
            count_before = count;
            error_before = e;
        }
    }
}

/* The same light at two depths: seen from the zone's rim it moves apart, so a wide zone takes more EAS. */
static float lamps(float3 d) { return d.z > .7f && d.z < .9f ? 1.0f : .01f; }

static void wide_zone(void **state)
{
    struct scene_light *s = *state;
    struct select_options options = SELECT_DEFAULTS;
    light(s, lamps, 2);
    for (int i = 0; i < COUNT; i++)
        if (i % 2) s->samples[i].distance = 6;
    assert_true(sample_tree_build(&s->tree, s->samples, COUNT, ORIGIN, s->place.frame));
    options.most = COUNT;
    s->place.radius = 0;
    uint32_t narrow = choose(s, options);
    s->place.radius = .8f;
    uint32_t wide = choose(s, options);
    assert_true(wide > narrow * 3 / 2);
    s->place.radius = 0;
}

static void dark(void **state)
{
    struct scene_light *s = *state;
    struct select_options options = SELECT_DEFAULTS;
    light(s, none, 2);
    assert_int_equal(choose(s, options), 0);
    struct sample_tree empty[3] = {0};
    assert_int_equal(select_eas(empty, 3, s->tables, s->brdf.lobes, 1, &s->place, &options, &s->scratch, s->chosen), 0);
}

static void never_more_than_most(void **state)
{
    struct scene_light *s = *state;
    const int most[] = {1, 6, 7, 40, 100};
    light(s, windows, 2);
    for (int i = 0; i < 5; i++) {
        struct select_options options = {.tau = 1e-6f, .levels = 2, .directions = 96, .most = most[i]};
        uint32_t count = choose(s, options);
        assert_in_range(count, 1, most[i]);
        assert_true((int)count > most[i] - 7);
    }
}

/* Light that the surface reflects besides makes errors matter less. */
static void base(void **state)
{
    struct scene_light *s = *state;
    struct select_options options = SELECT_DEFAULTS;
    light(s, windows, 2);
    uint32_t alone = choose(s, options);
    s->place.base = 20;
    uint32_t beside = choose(s, options);
    s->place.base = 0;
    assert_true(beside < alone / 2);
}

static int setup(void **state)
{
    struct scene_light *s = calloc(1, sizeof *s);
    if (!s || !(s->tables = mean_brdf_build())) return -1;
    s->brdf = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), 40);
    s->place = (struct select_place){.origin = ORIGIN, .frame = frame_about(normalize(vec3(.2f, .9f, .3f)))};
    s->place.wo = viewer(s, 20);
    return *state = s, 0;
}

static int teardown(void **state)
{
    struct scene_light *s = *state;
    mean_brdf_free(s->tables);
    sample_tree_free(&s->tree);
    select_free(&s->scratch);
    return free(s), 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(even_light),
                                       cmocka_unit_test(tau),
                                       cmocka_unit_test(wide_zone),
                                       cmocka_unit_test(dark),
                                       cmocka_unit_test(never_more_than_most),
                                       cmocka_unit_test(base)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
