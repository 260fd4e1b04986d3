/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras of every kind by the geometry that they stand for, and what their rays see. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "render/pane.h"
#include "render/primary.h"
#include "render/rng.h"
#include "tests/stage.h"

/* Looks along +y from (1, 2, 3), z up. */
#define LOOKS_ALONG_Y                                                                                                  \
    {                                                                                                                  \
        1, 0, 0, 1, 0, 0, -1, 2, 0, 1, 0, 3                                                                            \
    }

static void near_to(float3 found, float3 expected)
{
    if (!(length(sub(found, expected)) < 1e-5f))
        fail_msg("found %g %g %g, expected %g %g %g", found.x, found.y, found.z, expected.x, expected.y, expected.z);
}

/* Rays through a picture's corners and centre, a new aspect. */
static void camera_rays(void **state)
{
    (void)state;
    /* Looks along +y from (1, 2, 3), z up; twice as wide as high, shifted to the right. */
    struct scene_camera camera = {.transform = {1, 0, 0, 1, 0, 0, -1, 2, 0, 1, 0, 3},
                                  .window = {-0.5f, 1.5f, -0.5f, 0.5f},
                                  .width = 200,
                                  .height = 100};
    struct ray corner = camera_ray(&camera, 0, 0), axis = camera_ray(&camera, 50, 50);
    assert_float_equal(corner.origin.z, 3, 0);
    assert_float_equal(corner.dir.x / corner.dir.y, -0.5f, 1e-6f);
    assert_float_equal(corner.dir.z / corner.dir.y, 0.5f, 1e-6f);
    assert_float_equal(axis.dir.y, 1, 1e-6f);
    assert_float_equal(length(corner.dir), 1, 1e-6f);
    camera_resize(&camera, 50, 50);
    assert_float_equal(camera.window[0], 0, 1e-6f);
    assert_float_equal(camera.window[1], 1, 1e-6f);
    assert_float_equal(camera.window[3], 0.5f, 1e-6f);
}

/* The step is what a ray's direction turns by from pixel to pixel, at a distance. */
static void pixels_off_the_axis(void **state)
{
    (void)state;
    struct scene_camera camera = {.type = CAMERA_PERSPECTIVE,
                                  .transform = LOOKS_ALONG_Y,
                                  .window = {-1.2f, 1, -.5f, .6f},
                                  .width = 2200,
                                  .height = 1100};
    for (int i = 0; i < 4; i++) {
        float x = i & 1 ? 2000 : 1200, y = i & 2 ? 1000 : 600;
        struct ray ray = camera_ray(&camera, x, y);
        float right = length(sub(camera_ray(&camera, x + 1, y).dir, ray.dir));
        float down = length(sub(camera_ray(&camera, x, y + 1).dir, ray.dir));
        float found = camera_pixel_step(&camera, mad(ray.origin, ray.dir, 7));
        assert_float_equal(found, 7 * (right + down) / 2, 2e-3f * found);
    }
}

static void orthographic(void **state)
{
    (void)state;
    struct scene_camera camera = {.type = CAMERA_ORTHOGRAPHIC,
                                  .transform = LOOKS_ALONG_Y,
                                  .window = {-2, 2, -1, 1},
                                  .width = 400,
                                  .height = 200};
    struct ray corner = camera_ray(&camera, 0, 0), middle = camera_ray(&camera, 200, 100);
    near_to(corner.origin, vec3(-1, 2, 4));
    near_to(middle.origin, vec3(1, 2, 3));
    near_to(corner.dir, vec3(0, 1, 0));
    assert_float_equal(camera_pixel_width(&camera, vec3(50, 60, 70)), .01f, 1e-7f);
    float distance;
    near_to(camera_way(&camera, vec3(5, 5, 5), &distance), vec3(0, -1, 0));
    assert_true(distance == INFINITY);
    camera_resize(&camera, 200, 200);
    assert_float_equal(camera.window[0], -1, 1e-6f);
}

static void panoramic(void **state)
{
    (void)state;
    struct scene_camera camera = {.type = CAMERA_PANORAMIC,
                                  .transform = LOOKS_ALONG_Y,
                                  .window = {-PI, PI, -PI / 2, PI / 2},
                                  .width = 360,
                                  .height = 180};
    near_to(camera_ray(&camera, 180, 90).dir, vec3(0, 1, 0));  /* the middle: ahead */
    near_to(camera_ray(&camera, 270, 90).dir, vec3(1, 0, 0));  /* a quarter on: right */
    near_to(camera_ray(&camera, 90, 90).dir, vec3(-1, 0, 0));  /* left */
    near_to(camera_ray(&camera, 0, 90).dir, vec3(0, -1, 0));   /* behind */
    near_to(camera_ray(&camera, 123, 0).dir, vec3(0, 0, 1));   /* the top row's edge: up */
    near_to(camera_ray(&camera, 225, 45).dir, vec3(.5f, .5f, sqrtf(.5f)));
    near_to(camera_ray(&camera, 225, 45).origin, vec3(1, 2, 3));
    assert_float_equal(camera_pixel_width(&camera, vec3(1, 12, 3)), 10 * PI / 180, 1e-5f);
    camera_resize(&camera, 100, 100);
    near_to(camera_ray(&camera, 75, 50).dir, vec3(1, 0, 0));
}

/* Where rays of a pixel through all of the lens meet the plane at a distance: mean square of the offsets from where
 * they'd meet through its middle, along x and along the direction `turn`, and the farthest along that. */
struct spread {
    double square, squared_x;
    float farthest;
};

static struct spread spread_at(const struct scene_camera *camera, float x, float y, float distance, float turn)
{
    enum { COUNT = 40000 };
    struct rng rng = rng_seed(1, 2, 3);
    struct spread s = {0};
    struct ray middle = camera_ray(camera, x, y);
    float3 centre = mad(middle.origin, middle.dir, distance / -middle.dir.z);
    for (int i = 0; i < COUNT; i++) {
        float2 u = {rng_float(&rng), rng_float(&rng)};
        struct ray ray = camera_lens_ray(camera, x, y, u);
        assert_float_equal(dot(ray.dir, ray.dir), 1, 1e-5f);
        float3 off = sub(mad(ray.origin, ray.dir, distance / -ray.dir.z), centre);
        s.square += dot(off, off) / COUNT;
        s.squared_x += sqr(off.x) / COUNT;
        s.farthest = maxf(s.farthest, off.x * cosf(turn) + off.y * sinf(turn));
    }
    return s;
}

/* A point at distance d is blurred over the lens's shape scaled by |d - focus| / focus. */
static void lens(void **state)
{
    (void)state;
    struct scene_camera camera = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                  .window = {-1, 1, -1, 1},
                                  .width = 64,
                                  .height = 64,
                                  .lens = {.radius = .2f, .focus = 4, .ratio = 1}};
    assert_true(spread_at(&camera, 10, 50, 4, 0).square < 1e-11);
    struct spread disc = spread_at(&camera, 10, 50, 6, .3f); /* a disc of .2 x 2/4, mean square r^2/2 */
    assert_float_equal(disc.square, .005f, 1e-4f);
    assert_float_equal(disc.squared_x, .0025f, 1e-4f);
    assert_float_equal(disc.farthest, .1f, 1e-3f);
    assert_float_equal(spread_at(&camera, 10, 50, 3, 0).farthest, .05f, 1e-3f);
    camera.lens.ratio = 2;
    assert_float_equal(spread_at(&camera, 10, 50, 6, 0).farthest, .05f, 1e-3f);
    assert_float_equal(spread_at(&camera, 10, 50, 6, PI / 2).farthest, .1f, 1e-3f);
    /* A triangle's sides are half its corners' radius from the middle; mean square r^2 (2 + cos(2 pi/n)) / 6. */
    camera.lens = (struct scene_lens){.radius = .2f, .focus = 4, .ratio = 1, .blades = 3, .rotation = .3f};
    struct spread triangle = spread_at(&camera, 10, 50, 8, .3f + PI); /* behind the focus it is turned over */
    assert_float_equal(triangle.square, .2f * .2f * 1.5f / 6, 2e-4f);
    assert_float_equal(triangle.farthest, .1f, 1e-3f);
    assert_float_equal(spread_at(&camera, 10, 50, 8, .3f).farthest, .2f, 4e-3f);
    camera.lens.radius = 0;
    near_to(camera_lens_ray(&camera, 10, 50, (float2){.3f, .9f}).origin, vec3(0, 0, 0));
}

static bool first_hit(const struct model *model, float z, uint32_t object, bool any)
{
    struct hit hit;
    bool found = trace_camera(model->trace, vec3(0, 0, z), vec3(0, 0, -1), INFINITY, &hit);
    return any ? !found : found && hit.object == object;
}

/* Camera rays pass what is hidden, shadow rays what casts none; other rays meet both. Alone and instanced. */
static void visibility(void **state)
{
    (void)state;
    for (int shared = 0; shared < 2; shared++) {
        struct stage *s = new_stage();
        for (int i = 0; i < 3; i++) /* 0 is opaque, at the bottom */
            add_quad(s, vec3(0, 0, (float)i), vec3(1, 0, 0), vec3(0, 1, 0), grey(.5f, 0, 0, 0));
        s->objects[2].hidden = true;
        s->objects[1].shadowless = true;
        if (shared)
            for (int i = 0; i < 3; i++) add_object(s, i, i)->transform[3] = 50;
        struct model model = build(s);
        assert_true(first_hit(&model, 3, 1, false));
        struct hit hit;
        assert_true(trace_closest(model.trace, vec3(0, 0, 3), vec3(0, 0, -1), INFINITY, &hit) && hit.object == 2);
        assert_true(trace_caster(model.trace, vec3(0, 0, 1.5f), vec3(0, 0, -1), INFINITY, &hit) && hit.object == 0);
        assert_false(trace_occluded(model.trace, vec3(0, 0, 1.5f), vec3(0, 0, -1), 1));
        assert_true(trace_occluded(model.trace, vec3(0, 0, 2.5f), vec3(0, 0, -1), 1));
        assert_true(pane_transmittance(&model, vec3(0, 0, 1.5f), vec3(0, 0, -1), 1).x == 1);
        end(s, &model);
    }
}

/* A lamp before a wall: seen or not, in front of what lies behind it and behind what lies before it. */
static void lamps_are_seen(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    add_quad(s, vec3(0, 0, -4), vec3(9, 0, 0), vec3(0, 9, 0), grey(.5f, 0, 0, 1));
    add_quad(s, vec3(1, 0, -1), vec3(1, 0, 0), vec3(0, 9, 0), grey(.5f, 0, 0, 2)); /* hides x > 0 */
    s->lights[0] = (struct scene_light){.type = LIGHT_AREA,
                                        .shape = LIGHT_RECTANGLE,
                                        .size = {3, 3},
                                        .spread = PI,
                                        .power = {PI * 9 * 5, PI * 9 * 5, PI * 9 * 5},
                                        .transform = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, -2}}; /* shines along +z */
    s->scene.light_count = 1;
    for (int seen = 0; seen < 2; seen++) {
        s->lights[0].seen = seen;
        struct model model = build(s);
        struct rng rng = rng_seed(1, 2, 3);
        const float places[] = {20, 40, 2}, expected[] = {1 + 5 * (float)seen, 2, 1}; /* lamp, hidden, beside it */
        for (int i = 0; i < 3; i++) {
            struct pixel pixel = {0};
            struct point point;
            assert_true(primary(&model, places[i], 32, (float2){0, 0}, &rng, &pixel, &point));
            assert_float_equal(pixel.emission.x, expected[i], 1e-5f);
        }
        model_free(&model);
    }
    free(s);
}

/* In the light of a lamp without shadows a roof casts none, for samples of the lamp and for rays that meet it. */
static void lamps_without_shadows(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    add_quad(s, vec3(0, 0, 0), vec3(9, 0, 0), vec3(0, 9, 0), grey(1, 0, 0, 0));
    add_quad(s, vec3(0, 0, 1), vec3(9, 0, 0), vec3(0, 9, 0), grey(0, 0, 0, 0));
    s->lights[0] = (struct scene_light){.type = LIGHT_POINT,
                                        .shape = LIGHT_SPHERE,
                                        .radius = .5f,
                                        .power = {10, 10, 10},
                                        .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2}};
    s->scene.light_count = 1;
    for (int shadowless = 0; shadowless < 2; shadowless++) {
        s->lights[0].shadowless = shadowless;
        struct model model = build(s);
        struct ray ray = {vec3(.01f, .02f, .5f), vec3(0, 0, -1)};
        struct hit hit;
        struct point point;
        assert_true(trace_closest(model.trace, ray.origin, ray.dir, INFINITY, &hit));
        shade_point(&model, ray, &hit, &point);
        const float u[3] = {.5f, .5f, .5f};
        assert_true((shade_direct(&model, &point, u, false).x > 0) == shadowless);
        float3 up = {0, 0, 1};
        rgb met = lights_radiance_lamps(model.lights, point.origin, up, up, 1, INFINITY, NULL);
        assert_true((met.x > 0) == shadowless);
        model_free(&model);
    }
    free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(camera_rays),    cmocka_unit_test(orthographic),
                                       cmocka_unit_test(pixels_off_the_axis),
                                       cmocka_unit_test(panoramic),      cmocka_unit_test(lens),
                                       cmocka_unit_test(visibility),     cmocka_unit_test(lamps_are_seen),
                                       cmocka_unit_test(lamps_without_shadows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
