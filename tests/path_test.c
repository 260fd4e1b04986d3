/* SPDX-License-Identifier: Apache-2.0 */
/* The path tracer in scenes whose answer is known: furnaces, a sky, a disc's form factor, shadows, instances. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "render/path.h"
#include "tests/stage.h"

static float total(struct radiance r) { return r.emission.x + r.direct.x + r.indirect.x; }

/* The mean of `count` paths along a ray; *direct that of the direct part. Infinite where the ray escapes. */
static float look(const struct model *model, float3 origin, float3 dir, int count, float *direct)
{
    struct hit hit;
    double sum = 0, sum_direct = 0;
    struct ray ray = {origin, normalize(dir)};
    if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) return INFINITY;
    for (int i = 0; i < count; i++) {
        struct rng rng = rng_seed(1, (uint64_t)i, 0);
        struct point point;
        shade_point(model, ray, &hit, &point);
        struct radiance r = path_radiance(model, &point, NULL, &rng);
        sum += total(r);
        sum_direct += r.direct.x;
    }
    if (direct) *direct = (float)(sum_direct / count);
    return (float)(sum / count);
}

/* Inside a closed box that glows with e and reflects a, radiance is e (1 + a + a2 ...) = e / (1 - a) everywhere. */
static void closed_furnace(void **state)
{
    (void)state;
    static const float albedos[] = {0.2f, 0.5f, 0.8f};
    for (int i = 0; i < 3; i++) {
        struct stage *s = new_stage();
        add_cube(s, 1, grey(albedos[i], 0, 0, 1));
        struct model model = build(s);
        assert_float_equal(look(&model, vec3(0.3f, 0.2f, 0), vec3(0.9f, 0.7f, 0.4f), 40000, NULL) * (1 - albedos[i]), 1,
                           0.01f);
        end(s, &model);
    }
}

/* Under an even sky a convex surface sends back its directional albedo, whatever its tilt. */
static void even_sky(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    float3 u = normalize(vec3(0.9f, 0.1f, -0.4f)), v = normalize(cross(vec3(0.2f, 0.3f, 1), u));
    add_quad(s, vec3(3, -2, 1), u, v, grey(0.3f, 0.5f, 60, 0));
    s->scene.world = (struct scene_world){{2, 2, 2}, SCENE_NONE, {0}};
    struct model model = build(s);
    float3 n = cross(u, v);
    n = normalize(n);
    for (int k = 0; k < 3; k++) {
        static const float cosines[] = {0.9f, 0.4f, 0.05f};
        float3 wo = add(scale(n, cosines[k]), scale(u, sqrtf(1 - sqr(cosines[k]))));
        struct brdf brdf = brdf_phong(vec3(0.3f, 0.3f, 0.3f), vec3(0.5f, 0.5f, 0.5f), 60);
        enum { STEPS = 300 };
        double albedo = 0;
        for (int i = 0; i < STEPS; i++)
            for (int j = 0; j < STEPS; j++) {
                float z = ((float)i + 0.5f) / STEPS, phi = 2 * PI * ((float)j + 0.5f) / STEPS, r = sqrtf(1 - z * z);
                float3 wi = to_world(frame_about(n), vec3(r * cosf(phi), r * sinf(phi), z));
                albedo += (double)brdf_eval(&brdf, n, wo, wi).x * z * 2 * PI / (STEPS * STEPS);
            }
        float3 from = mad(vec3(3, -2, 1), wo, 2);
        assert_float_equal(look(&model, from, scale(wo, -1), 40000, NULL) / (2 * albedo), 1, 0.01f);
        assert_float_equal(look(&model, mad(from, n, -2 * dot(sub(from, vec3(3, -2, 1)), n)),
                                add(scale(wo, -1), scale(n, 2 * cosines[k])), 40000, NULL) /
                               (2 * albedo),
                           1, 0.01f); /* the back */
    }
    end(s, &model);
}

/* A square lamp over a floor beside a wall: light doesn't depend on the unit of length. At 1e-5 a ray's
 * start 4 micrometres off its surface would be a quarter of the way to the lamp. */
static void any_scale(void **state)
{
    (void)state;
    float expected = 0;
    for (float unit = 1; unit > 1e-8f; unit *= 1e-2f) {
        struct stage *s = new_stage();
        struct scene_material lamp = grey(0, 0, 0, 5);
        lamp.emission_back = false;
        add_quad(s, vec3(0, 0, unit), vec3(0, .5f * unit, 0), vec3(.5f * unit, 0, 0), lamp);
        add_quad(s, vec3(0, 0, 0), vec3(2 * unit, 0, 0), vec3(0, 2 * unit, 0), grey(.5f, .3f, 20, 0));
        add_quad(s, vec3(0, .8f * unit, 0), vec3(2 * unit, 0, 0), vec3(0, 0, -2 * unit), grey(.5f, 0, 0, 0));
        struct model model = build(s);
        float sum = look(&model, scale(vec3(.9f, 0, .9f), unit), vec3(-.8f, .1f, -.9f), 4000, NULL);
        if (unit == 1) expected = sum;
        assert_float_equal(sum / expected, 1, .002f);
        end(s, &model);
    }
}

/* A disc of radius r at height h above a point lights it with pi L r2 / (r2 + h2); a polygon of 64 corners is one but
 * for 1/600 of its area. What is not direct is nothing. */
static void disc_emitter(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    float3 points[64];
    for (int i = 0; i < 64; i++)
        points[i] =
            vec3(0.8f * sinf(2 * PI * (float)i / 64), 0.8f * cosf(2 * PI * (float)i / 64), 1.5f); /* faces down */
    struct scene_material lamp = grey(0, 0, 0, 5);
    lamp.emission_back = false;
    add_mesh(s, points, 64, 1, lamp);
    add_quad(s, vec3(0, 0, 0), vec3(4, 0, 0), vec3(0, 4, 0), grey(0.5f, 0, 0, 0));
    struct model model = build(s);
    float direct, truth = 0.5f * 5 * 0.64f / (0.64f + 2.25f);
    float sum = look(&model, vec3(0.5f, 0, 1), vec3(-0.5f, 0, -1), 100000, &direct);
    assert_float_equal(sum / truth, 1, 0.005f);
    assert_float_equal(direct, sum, 1e-6f);
    assert_float_equal(look(&model, vec3(0, 0, 1), vec3(0.1f, 0, 1), 1, NULL), 5, 1e-6f);
    assert_true(look(&model, vec3(0, 0, 3), vec3(0.1f, 0, -1), 100, NULL) < 1e-6f); /* dark on its back */
    end(s, &model);

    s = new_stage(); /* a box that glows outside is dark within */
    struct scene_material outside = grey(0.5f, 0, 0, 5);
    outside.emission_back = false;
    add_cube(s, 1, outside);
    model = build(s);
    assert_true(look(&model, vec3(0, 0, 0), vec3(0.3f, 0.2f, -1), 1000, NULL) == 0);
    end(s, &model);
}

/* A lamp shines on the scene by light sampling alone and by both strategies: the same mean. */
static void two_strategies(void **state)
{
    (void)state;
    for (int kind = 0; kind < 5; kind++) {
        struct stage *s = new_stage();
        add_quad(s, vec3(0, 0, 0), vec3(4, 0, 0), vec3(0, 4, 0), grey(0.2f, 0.6f, 30, 0));
        add_quad(s, vec3(0.4f, 0.2f, 0.5f), vec3(0.3f, 0, 0), vec3(0, 0.3f, 0), grey(0, 0, 0, 0)); /* casts a shadow */
        static const struct scene_light kinds[] = {
            {.type = LIGHT_POINT, .shape = LIGHT_SPHERE, .radius = 0.4f, .power = {20, 20, 20}},
            {.type = LIGHT_AREA, .shape = LIGHT_RECTANGLE, .size = {1, 0.6f}, .spread = 2.5f, .power = {20, 20, 20}},
            {.type = LIGHT_SUN, .angle = 0.3f, .power = {2, 2, 2}}};
        if (kind < 3) {
            s->lights[s->scene.light_count++] = kinds[kind];
            memcpy(s->lights[0].transform, (float[12]){1, 0, 0, 0.5f, 0, 1, 0, 0, 0, 0, 1, 1.6f}, sizeof(float[12]));
        } else if (kind == 4) {
            add_sky(s);
        } else { /* two meshes that glow on their lower side, the first with two faces */
            struct scene_material lamp = grey(0, 0, 0, 8);
            lamp.emission_back = false;
            float3 faces[8] = {{0, -1, 1.5f}, {0, 0, 1.5f}, {1, 0, 1.5f}, {1, -1, 1.5f},
                               {0, 0, 1.6f},  {0, 1, 1.8f}, {1, 1, 1.8f}, {1, 0, 1.6f}};
            add_mesh(s, faces, 4, 2, lamp);
            lamp.emission.value[0] = 20;
            add_quad(s, vec3(-0.9f, 0.5f, 1), vec3(0, 0.3f, 0), vec3(0.2f, 0, 0), lamp);
        }
        struct model model = build(s);
        struct ray ray = {{-1, 0, 1}, normalize(vec3(1, 0, -1))};
        struct hit hit;
        struct point point;
        assert_true(trace_closest(model.trace, ray.origin, ray.dir, INFINITY, &hit));
        shade_point(&model, ray, &hit, &point);
        double one = 0, direct = 0;
        enum { COUNT = 400000 };
        for (int i = 0; i < COUNT; i++) {
            struct rng rng = rng_seed(7, (uint64_t)i, 0);
            float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)};
            one += shade_direct(&model, &point, u, false).x;
            direct += path_radiance(&model, &point, NULL, &rng).direct.x;
        }
        assert_true(direct > 0);
        assert_float_equal(one / direct, 1, kind == 4 ? 0.025f : 0.01f); /* a texel of sun is noisier */
        end(s, &model);
    }
}

/* A closed box in a bright world stays black inside: no ray leaks through edges or starts on the wrong side. */
static void no_leaks(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    add_cube(s, 1, grey(0.8f, 0.1f, 20, 0));
    memcpy(s->objects[0].transform, (float[12]){0.8f, -0.6f, 0, 21.3f, 0.6f, 0.8f, 0, -7.7f, 0, 0, 1, 3.1f},
           sizeof(float[12]));
    s->scene.world = (struct scene_world){{1e3f, 1e3f, 1e3f}, SCENE_NONE, {0}};
    s->lights[s->scene.light_count++] = (struct scene_light){
        .type = LIGHT_SUN, .power = {1e3f, 1e3f, 1e3f}, .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    struct model model = build(s);
    struct rng rng = rng_seed(9, 0, 0);
    for (int i = 0; i < 20000; i++) {
        float3 dir = {rng_float(&rng) - 0.5f, rng_float(&rng) - 0.5f, rng_float(&rng) - 0.5f};
        if (i % 2) /* into the edges */
            dir = vec3(copysignf(0.5f, dir.x), copysignf(0.5f, dir.y), dir.z);
        assert_true(look(&model, vec3(21.3f, -7.7f, 3.1f), dir, 1, NULL) == 0);
    }
    end(s, &model);
}

/* A mesh used twice is instanced, mirrored once: both must look as the same triangles placed by hand. */
static void instances(void **state)
{
    (void)state;
    static const float mirrored[12] = {-1, 0, 0, 2, 0, 1.5f, 0, 0, 0, 0, 1, 0.5f};
    float seen[2][2];
    for (int shared = 0; shared < 2; shared++) {
        struct stage *s = new_stage();
        struct scene_material glow = grey(0.4f, 0, 0, 3);
        glow.emission_back = false;
        struct scene_object *object = add_quad(s, vec3(0, 0, 0), vec3(0.5f, 0, 0), vec3(0, 0.5f, 0.2f), glow);
        memcpy(object->transform, mirrored, sizeof mirrored);
        if (shared)
            memcpy(add_object(s, 0, 0)->transform, (float[12]){1, 0, 0, 50, 0, 1, 0, 0, 0, 0, 1, 0}, sizeof mirrored);
        add_quad(s, vec3(2, 0, 3), vec3(0, 2, 0), vec3(2, 0, 0), grey(0.5f, 0, 0, 0)); /* a ceiling, lit by the front */
        struct model model = build(s);
        assert_int_equal(model.objects[0].instanced, shared);
        seen[shared][0] = look(&model, vec3(2.1f, 0.1f, 2), vec3(0, 0, -1), 20000, NULL); /* the front glows */
        seen[shared][1] = look(&model, vec3(2.1f, 0.1f, 2), vec3(0, 0, 1), 100000, NULL);
        assert_true(seen[shared][0] > 2.9f && seen[shared][1] > 0.05f);
        assert_true(look(&model, vec3(2.1f, 0.1f, -2), vec3(0, 0, 1), 1000, NULL) < 2.9f); /* the back does not */
        end(s, &model);
    }
    assert_float_equal(seen[0][0], seen[1][0], 0.01f);
    assert_float_equal(seen[0][1] / seen[1][1], 1, 0.01f);
}

/* path_incident leaves out the direct light of lamps that the caller counts, and only that. */
static void incident(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    add_cube(s, 1, grey(0.5f, 0, 0, 1));
    struct model model = build(s);
    double sum = 0;
    for (int i = 0; i < 40000; i++) {
        struct rng rng = rng_seed(3, (uint64_t)i, 0);
        sum += path_incident(&model, (struct ray){{0.2f, 0.1f, 0}, normalize(vec3(0.3f, 1, 0.2f))}, &rng).x;
    }
    assert_float_equal(sum / 40000, 1, 0.01f); /* of 2 in all, 1 is the wall's own */
    end(s, &model);
}

/* A smooth normal on a glossy face keeps its mirror direction above the face: pulled just so far where it would not,
 * else left alone; a diffuse face keeps it as it is. */
static void pulled_normals(void **state)
{
    (void)state;
    static const float3 tilted = {0.8f, 0, 0.6f};
    for (int glossy = 0; glossy < 2; glossy++) {
        struct stage *s = new_stage();
        add_quad(s, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0), grey(0.3f, glossy ? 0.3f : 0, 40, 0));
        float3 normals[4] = {tilted, tilted, tilted, tilted};
        s->meshes[0].normals = &normals[0].x;
        struct model model = build(s);
        struct rng rng = rng_seed(1, 0, 0);
        int pulled = 0;
        for (int i = 0; i < 2000; i++) {
            float3 wo = normalize(vec3(rng_float(&rng) - 0.5f, rng_float(&rng) - 0.5f, 0.5f * rng_float(&rng) + 1e-3f));
            struct ray ray = {scale(wo, 2), scale(wo, -1)};
            struct hit hit;
            struct point point;
            assert_true(trace_closest(model.trace, ray.origin, ray.dir, INFINITY, &hit));
            shade_point(&model, ray, &hit, &point);
            float least = minf(0.9f * wo.z, 0.01f);
            bool fine = !glossy || reflect(wo, tilted).z >= least;
            assert_float_equal(length(point.n), 1, 1e-5f);
            if (fine) {
                assert_float_equal(dot(point.n, tilted), 1, 1e-5f);
            } else {
                assert_float_equal(reflect(wo, point.n).z, least, 1e-4f);
                assert_float_equal(point.n.y, 0, 1e-5f); /* turned toward the face's own, (0, 0, 1) */
                assert_true(point.n.z > tilted.z && dot(point.n, wo) > 0);
                pulled++;
            }
        }
        assert_true(glossy ? pulled > 100 : pulled == 0);
        end(s, &model);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_furnace), cmocka_unit_test(even_sky),       cmocka_unit_test(any_scale),
        cmocka_unit_test(disc_emitter),   cmocka_unit_test(two_strategies), cmocka_unit_test(no_leaks),
        cmocka_unit_test(instances),      cmocka_unit_test(incident),       cmocka_unit_test(pulled_normals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
