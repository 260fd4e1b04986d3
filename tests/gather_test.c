/* SPDX-License-Identifier: Apache-2.0 */
/* Gather rays in scenes whose radiance is known: what they bring, and where it seems to come from. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "render/gather.h"
#include "tests/stage.h"

static struct diffuse_cache build_cache(const struct model *model)
{
    struct diffuse_cache cache;
    char error[SCENE_ERROR];
    struct progress quiet = {.quiet = true};
    assert_true(diffuse_cache_build(model, 0, 5, &quiet, &cache, error));
    return cache;
}

/* Inside a closed box that glows with 1 and reflects a, radiance is 1/(1 - a); a gather ray leaves out the glow of the
 * wall that it hits, which its sender samples: a/(1 - a). A ray by a lobe that nothing else samples (its density is
 * high) brings the glow apart, nearly in full. */
static void furnace(void **state)
{
    (void)state;
    enum { RAYS = 20000 };
    const float a = .5f, dense = 1e4f;
    struct stage *s = new_stage();
    add_cube(s, 1, grey(a, 0, 0, 1));
    struct model model = build(s);
    struct diffuse_cache cache = build_cache(&model);
    struct rng rng = rng_seed(9, 0, 0);
    /* In the open, and in a corner, where rays are shorter than the cache's zones and one more bounce is traced. */
    const float3 floors[] = {{.1f, .2f, -.9999f}, {.97f, .97f, -.9999f}}, up = {0, 0, 1};
    for (int k = 0; k < 2; k++) {
        double plain = 0, specular = 0, glow = 0;
        for (int i = 0; i < RAYS; i++) {
            float u[2] = {rng_float(&rng), rng_float(&rng)};
            struct ray ray = {floors[k], cosine_direction(up, u)};
            struct gathered light = gather(&model, &cache, ray, &rng, NULL);
            rgb lamps;
            plain += light.surface.x + light.mirrored.x;
            light = gather_specular(&model, &cache, ray, up, dense, &rng, &lamps);
            specular += light.surface.x + light.mirrored.x;
            glow += lamps.x;
        }
        assert_float_equal(plain / RAYS, a / (1 - a), k == 0 ? .05f : .2f); /* near lamps records are noisy */
        assert_float_equal(specular / RAYS, a / (1 - a), k == 0 ? .05f : .2f);
        assert_float_equal(glow / RAYS, 1, .01f);
    }
    diffuse_cache_free(&cache);
    end(s, &model);
}

/* A near-mirror floor under a ceiling 2 m up that a lamp between them lights: a ray that goes down at 45 degrees from 1
 * m hits the floor at sqrt(2) m, and what it mirrors lies as far behind as the ceiling is along the reflected ray. */
static void virtual_image(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    struct scene_material lamp = grey(0, 0, 0, 50);
    lamp.emission_back = false;
    add_quad(s, vec3(0, 0, 0), vec3(9, 0, 0), vec3(0, 9, 0), grey(0, .9f, 20000, 0));
    add_quad(s, vec3(0, 0, 2), vec3(0, 9, 0), vec3(9, 0, 0), grey(.7f, 0, 0, 0));
    add_quad(s, vec3(-4, 0, .5f), vec3(.5f, 0, 0), vec3(0, .5f, 0), lamp); /* shines up */
    struct model model = build(s);
    struct diffuse_cache cache = build_cache(&model);
    struct rng rng = rng_seed(1, 2, 3);
    int bright = 0;
    for (int i = 0; i < 200; i++) {
        struct ray ray = {vec3(0, 0, 1), normalize(vec3(1, 0, -1))};
        struct gathered light = gather(&model, &cache, ray, &rng, NULL);
        assert_float_equal(light.distance, sqrtf(2), 1e-3f);
        assert_float_equal(light.normal.z, 1, 1e-4f);
        assert_true(is_black(light.surface));
        if (is_black(light.mirrored)) continue;
        bright++;
        assert_float_equal(light.mirrored_distance, 3 * sqrtf(2), .2f);
    }
    assert_true(bright > 150);
    diffuse_cache_free(&cache);
    end(s, &model);
}

/* The same, looking straight down, in a mirror that is part of a sphere of radius 1/bend, bulging up where bend > 0: by
 * the mirror equation the image of what is 2 m away lies 1/(1/2 + 2 bend) behind it. */
static void curved_image(void **state)
{
    (void)state;
    enum { SIDE = 8 };
    const float bends[] = {1, .25f, -.1f}, half = .4f;
    for (int k = 0; k < 3; k++) {
        struct stage *s = new_stage();
        float3 points[SIDE * SIDE * 4], normals[SIDE * SIDE * 4];
        for (int i = 0; i < SIDE * SIDE * 4; i++) {
            int corner = i % 4, x = i / 4 % SIDE + (corner == 1 || corner == 2), y = i / 4 / SIDE + (corner > 1);
            float px = half * (2 * (float)x / SIDE - 1), py = half * (2 * (float)y / SIDE - 1);
            points[i] = vec3(px, py, -.5f * bends[k] * (px * px + py * py));
            normals[i] = normalize(vec3(bends[k] * px, bends[k] * py, 1));
        }
        struct scene_material lamp = grey(0, 0, 0, 50);
        lamp.emission_back = false;
        add_mesh(s, points, 4, SIDE * SIDE, grey(0, .9f, 20000, 0));
        s->meshes[0].normals = &normals[0].x;
        add_quad(s, vec3(0, 0, 2), vec3(0, 9, 0), vec3(9, 0, 0), grey(.7f, 0, 0, 0));
        add_quad(s, vec3(-4, 0, .5f), vec3(.5f, 0, 0), vec3(0, .5f, 0), lamp); /* shines up */
        struct model model = build(s);
        struct diffuse_cache cache = build_cache(&model);
        struct rng rng = rng_seed(1, 2, 3);
        double sum = 0;
        int bright = 0;
        for (int i = 0; i < 200; i++) {
            struct ray ray = {vec3(.02f, .03f, 1), vec3(0, 0, -1)};
            struct gathered light = gather(&model, &cache, ray, &rng, NULL);
            if (is_black(light.mirrored)) continue;
            bright++;
            sum += light.mirrored_distance;
        }
        assert_true(bright > 150);
        assert_float_equal(sum / bright, 1 + 1 / (.5f + 2 * bends[k]), .05f);
        diffuse_cache_free(&cache);
        end(s, &model);
    }
}

/* A ray that escapes is at infinity and brings the part of the sky that isn't sampled. */
static void escape(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    for (int k = 0; k < 3; k++) s->scene.world.radiance[k] = 2;
    add_quad(s, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0), grey(.5f, 0, 0, 0));
    struct model model = build(s);
    struct diffuse_cache cache = build_cache(&model);
    struct rng rng = rng_seed(1, 2, 3);
    struct gathered light = gather(&model, &cache, (struct ray){vec3(0, 0, 1), vec3(0, 0, 1)}, &rng, NULL);
    assert_true(isinf(light.distance));
    assert_float_equal(light.surface.x, 2, 1e-5f);
    diffuse_cache_free(&cache);
    end(s, &model);
}

/* A ray that counts what it meets brings a lamp's light from where the lamp is, before what it hits behind it. */
static void lamps_that_a_ray_meets(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    add_quad(s, vec3(0, 0, 5), vec3(9, 0, 0), vec3(0, -9, 0), grey(0, 0, 0, 3)); /* glows down */
    s->lights[0] = (struct scene_light){.type = LIGHT_AREA,
                                        .shape = LIGHT_RECTANGLE,
                                        .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2},
                                        .power = {PI, PI, PI},
                                        .size = {1, 1},
                                        .spread = PI};
    s->scene.light_count = 1;
    struct model model = build(s);
    struct diffuse_cache none = {.zones = cache_empty(1)};
    struct rng rng = rng_seed(1, 2, 3);
    const float3 dir = normalize(vec3(.2f, 0, 1));
    struct gathered light = gather_all(&model, &none, (struct ray){vec3(0, 0, 0), dir}, &rng);
    assert_float_equal(light.mirrored.x, 1, 1e-5f);
    assert_float_equal(light.mirrored_distance * dir.z, 2, 1e-5f);
    assert_float_equal(light.surface.x, 3, 1e-5f);
    assert_float_equal(light.distance * dir.z, 5, 1e-5f);
    light = gather(&model, &none, (struct ray){vec3(0, 0, 0), dir}, &rng, NULL);
    assert_true(is_black(light.mirrored) && is_black(light.surface));
    end(s, &model);
}

/* A ray down to a floor 2 cm under a lamp that fills nearly all it sees: in the mean of 2000 it brings what the floor
 * sends back. By lamp samples alone it was .35 instead of .5. */
static void close_to_a_lamp(void **state)
{
    (void)state;
    enum { RAYS = 2000 };
    struct stage *s = new_stage();
    struct scene_material lamp = grey(0, 0, 0, 1);
    lamp.emission_back = false;
    add_quad(s, vec3(0, 0, 0), vec3(.5f, 0, 0), vec3(0, .5f, 0), grey(.5f, 0, 0, 0));
    add_quad(s, vec3(0, 0, .02f), vec3(0, .5f, 0), vec3(.5f, 0, 0), lamp);
    struct model model = build(s);
    struct diffuse_cache cache = build_cache(&model);
    struct rng rng = rng_seed(1, 2, 3);
    double sum = 0;
    for (int i = 0; i < RAYS; i++) {
        struct ray ray = {vec3(.01f, .02f, .015f), normalize(vec3(.1f, -.1f, -1))};
        struct gathered light = gather(&model, &cache, ray, &rng, NULL);
        sum += (double)(light.surface.x + light.mirrored.x) / RAYS;
    }
    assert_float_equal(sum, .5f, .01f);
    diffuse_cache_free(&cache);
    end(s, &model);
}

/* Sixty bounces at 45 degrees between two lossless mirrors, as light is led in a sheet of glass, and out to a sky of 1:
 * all of it arrives. */
static void led_between_mirrors(void **state)
{
    (void)state;
    enum { RAYS = 10000 };
    struct stage *s = new_stage();
    struct scene_closure mirror = scene_closure_of(CLOSURE_GLOSSY);
    for (int i = 0; i < 3; i++) mirror.colour.value[i] = s->scene.world.radiance[i] = 1;
    add_quad(s, vec3(30, 0, -.5f), vec3(30, 0, 0), vec3(0, 9, 0), material_of(mirror));
    add_quad(s, vec3(30, 0, .5f), vec3(30, 0, 0), vec3(0, 9, 0), material_of(mirror));
    struct model model = build(s);
    struct diffuse_cache cache = build_cache(&model);
    struct rng rng = rng_seed(1, 2, 3);
    double sum = 0;
    for (int i = 0; i < RAYS; i++)
        sum += gather(&model, &cache, (struct ray){vec3(.1f, 0, 0), normalize(vec3(1, 0, -1))}, &rng, NULL).mirrored.x;
    assert_float_equal(sum / RAYS, 1, .05f); /* 3 sigma */
    diffuse_cache_free(&cache);
    end(s, &model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(furnace),
                                       cmocka_unit_test(virtual_image),
                                       cmocka_unit_test(led_between_mirrors),
                                       cmocka_unit_test(curved_image),
                                       cmocka_unit_test(escape),
                                       cmocka_unit_test(lamps_that_a_ray_meets),
                                       cmocka_unit_test(close_to_a_lamp)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
