/* SPDX-License-Identifier: Apache-2.0 */
/* The diffuse cache in scenes whose irradiance is known. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <omp.h>

#include "render/diffuse_cache.h"
#include "tests/stage.h"

static struct diffuse_cache build_cache(const struct model *model)
{
    struct diffuse_cache cache;
    char error[SCENE_ERROR];
    struct progress quiet = {.quiet = true};
    assert_true(diffuse_cache_build(model, 0, 3, &quiet, &cache, error));
    assert_true(cache.zones.count > 3);
    return cache;
}

static float mean_e(const struct diffuse_cache *cache)
{
    double sum = 0;
    for (uint32_t i = 0; i < cache->zones.count; i++) sum += cache->e[i].x;
    return (float)(sum / cache->zones.count);
}

/* Inside a closed box that glows with 1 and reflects a, radiance is 1/(1 - a) and irradiance pi times that; pi of it
 * comes from the walls' glow directly, which the cache leaves out: pi a/(1 - a) is left, everywhere. Single records are
 * noisy here, where walls are near lamps. */
static void closed_furnace(void **state)
{
    (void)state;
    static const float albedos[] = {.2f, .5f, .8f};
    for (int i = 0; i < 3; i++) {
        struct stage *s = new_stage();
        add_cube(s, 1, grey(albedos[i], 0, 0, 1));
        struct model model = build(s);
        struct diffuse_cache cache = build_cache(&model);
        assert_float_equal(mean_e(&cache) * (1 - albedos[i]) / (PI * albedos[i]), 1, .03f);
        diffuse_cache_free(&cache);
        end(s, &model);
    }
}

/* A ball's inside in 54 quads; returns its area. */
static float add_ball(struct stage *s, struct scene_material material)
{
    enum { SIDE = 3 };
    float3 points[6 * SIDE * SIDE * 4];
    int count = 0;
    float area = 0;
    for (int face = 0; face < 6; face++)
        for (int cell = 0; cell < SIDE * SIDE; cell++) {
            for (int k = 0; k < 4; k++) {
                /* Equal angles, so that the quads are nearly alike. */
                float a = tanf(PI / 4 * (2 * (float)(cell % SIDE + (k == 1 || k == 2)) / SIDE - 1));
                float b = tanf(PI / 4 * (2 * (float)(cell / SIDE + (k > 1)) / SIDE - 1)), at = face & 1 ? 1.0f : -1.0f;
                float xyz[3];
                xyz[face / 2] = at;
                xyz[(face / 2 + 1) % 3] = a * at;
                xyz[(face / 2 + 2) % 3] = b;
                points[count++] = normalize(vec_from(xyz));
            }
            const float3 *q = points + count - 4;
            area += .5f *
                    (length(cross(sub(q[1], q[0]), sub(q[2], q[0]))) + length(cross(sub(q[2], q[0]), sub(q[3], q[0]))));
        }
    add_mesh(s, points, 4, 6 * SIDE * SIDE, material);
    return area;
}

/* A lamp at the centre of a ball: what its wall sends back is the same all over the wall. All bounces bring P a/(1 - a)
 * W. */
static void integrating_sphere(void **state)
{
    (void)state;
    static const float albedos[] = {.3f, .8f};
    for (int i = 0; i < 2; i++) {
        struct stage *s = new_stage();
        float area = add_ball(s, grey(albedos[i], 0, 0, 0));
        s->lights[s->scene.light_count++] = (struct scene_light){
            .type = LIGHT_POINT, .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, .power = {10, 10, 10}};
        struct model model = build(s);
        struct diffuse_cache cache = build_cache(&model);
        float exact = 10 / area * albedos[i] / (1 - albedos[i]);
        assert_float_equal(mean_e(&cache) / exact, 1, .03f);
        for (uint32_t k = 0; k < cache.zones.count; k++) assert_float_equal(cache.e[k].x / exact, 1, .12f);
        assert_true(diffuse_cache_error(&model, &cache, 5) < .05);
        for (uint32_t k = 0; k < cache.zones.count; k++) cache.e[k] = scale(cache.e[k], 1.3f);
        assert_float_equal(diffuse_cache_error(&model, &cache, 5), .3f, .05f);
        diffuse_cache_free(&cache);
        end(s, &model);
    }
}

/* An even sky over a plane: every record receives pi L, and nothing bounces. */
static void open_sky(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    add_quad(s, vec3(0, 0, -3), vec3(4, 0, 0), vec3(0, 4, 0), grey(.6f, 0, 0, 0));
    s->scene.world = (struct scene_world){{2, 2, 2}, SCENE_NONE, {0}};
    struct model model = build(s);
    struct diffuse_cache cache = build_cache(&model);
    for (uint32_t i = 0; i < cache.zones.count; i++) assert_float_equal(cache.e[i].x, 2 * PI, .01f);
    struct cache_match matches[CACHE_MATCHES];
    int found = cache_find(&cache.zones, vec3(.3f, -.2f, -3), vec3(0, 0, 1), matches);
    assert_true(found > 0);
    assert_float_equal(diffuse_cache_mean(&cache, matches, found).y, 2 * PI, .01f);
    assert_true(diffuse_cache_bytes(&cache) > cache.zones.count * (sizeof(struct zone) + sizeof(rgb)));
    diffuse_cache_free(&cache);
    assert_null(cache.e);
    end(s, &model);
}

/* The same bytes for any number of threads. */
static void threads(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    add_cube(s, 1, grey(.5f, .2f, 30, 1));
    add_quad(s, vec3(.2f, 0, -.5f), vec3(.2f, .1f, 0), vec3(0, .3f, .1f), grey(.3f, 0, 0, 0));
    struct model model = build(s);
    int before = omp_get_max_threads();
    omp_set_num_threads(1);
    struct diffuse_cache one = build_cache(&model);
    omp_set_num_threads(2);
    struct diffuse_cache two = build_cache(&model);
    omp_set_num_threads(before);
    assert_int_equal(one.zones.count, two.zones.count);
    assert_memory_equal(one.zones.zones, two.zones.zones, one.zones.count * sizeof *one.zones.zones);
    assert_memory_equal(one.e, two.e, one.zones.count * sizeof *one.e);
    diffuse_cache_free(&one);
    diffuse_cache_free(&two);
    end(s, &model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(closed_furnace), cmocka_unit_test(integrating_sphere),
                                       cmocka_unit_test(open_sky), cmocka_unit_test(threads)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
