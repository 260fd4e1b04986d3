/* SPDX-License-Identifier: Apache-2.0 */
/* Lamps of every kind against closed forms, and lights_sample against what a ray along the same direction finds. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>

#include "render/environment.h"
#include "render/light.h"
#include "render/rng.h"

#define IDENTITY                                                                                                       \
    {                                                                                                                  \
        1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0                                                                             \
    }
#define POWER                                                                                                          \
    {                                                                                                                  \
        10, 10, 10                                                                                                     \
    }

static const float3 UP = {0, 0, 1}, ORIGIN = {0, 0, 0};

static struct lights *build(struct scene_light *lights, int count)
{
    static struct scene scene; /* borrowed by the result */
    static struct textures textures;
    char error[SCENE_ERROR];
    scene = (struct scene){.world.texture = SCENE_NONE, .lights = lights, .light_count = count};
    textures.scene = &scene;
    struct lights *result = lights_build(&scene, &textures, NULL, 10, error);
    assert_non_null(result);
    return result;
}

/* Irradiance at p by lights_sample. */
static float sampled(const struct lights *lights, float3 p, float3 n, int count)
{
    double sum = 0;
    struct rng rng = rng_seed(1, 1, 1);
    for (int i = 0; i < count; i++) {
        float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)};
        struct light_sample s;
        if (lights_sample(lights, p, n, u, &s)) sum += (double)s.weight.x * fmaxf(dot(s.wi, n), 0);
    }
    return (float)(sum / count);
}

/* The same by directions over the hemisphere: rays that meet the lamps by chance. */
static float met(const struct lights *lights, float3 p, float3 n, int count)
{
    double sum = 0;
    struct rng rng = rng_seed(2, 2, 2);
    struct frame frame = frame_about(n);
    for (int i = 0; i < count; i++) {
        float u = rng_float(&rng), phi = 2 * PI * rng_float(&rng), r = sqrtf(u);
        float3 dir = to_world(frame, vec3(r * cosf(phi), r * sinf(phi), sqrtf(1 - u)));
        sum += (double)PI * lights_radiance_lamps(lights, p, n, dir, INFINITY, INFINITY, NULL).x;
    }
    return (float)(sum / count);
}

/* A direction that lights_sample gives, followed as a ray with the same density, must weigh one half of the radiance
 * that lights_sample reports. */
static void check_densities(const struct lights *lights, float3 p, float3 n, float tolerance)
{
    enum { COUNT = 20000 };
    struct rng rng = rng_seed(3, 3, 3);
    int taken = 0, agreeing = 0;
    for (int i = 0; i < COUNT; i++) {
        float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)};
        struct light_sample s;
        if (!lights_sample(lights, p, n, u, &s) || dot(s.wi, n) <= 0) continue;
        taken++;
        float radiance = s.weight.x * s.pdf, half = lights_radiance_lamps(lights, p, n, s.wi, INFINITY, s.pdf, NULL).x;
        agreeing += fabsf(half - radiance / 2) <= tolerance * radiance;
        assert_true(lights_radiance_lamps(lights, p, n, s.wi, s.distance * 0.999f, s.pdf, NULL).x == 0 ||
                    s.distance == INFINITY);
    }
    assert_true(taken > COUNT / 100);
    assert_true(agreeing > taken - taken / 200 - 1); /* a few fall on the rim, by rounding */
}

static void check(struct scene_light light, float3 p, float3 n, float truth, bool extent)
{
    struct lights *lights = build(&light, 1);
    assert_float_equal(sampled(lights, p, n, 100000) / truth, 1, 0.01f);
    if (extent) {
        assert_float_equal(met(lights, p, n, 1000000) / truth, 1, 0.04f);
        check_densities(lights, p, n, 2e-3f);
    }
    lights_free(lights);
}

static struct scene_light at_height(enum light_type type, enum light_shape shape, float height)
{
    return (struct scene_light){.type = type,
                                .shape = shape,
                                .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, height},
                                .power = POWER,
                                .spread = PI,
                                .size = {1, 1}};
}

static const float3 TILTED = {0.6f, 0, 0.8f};

static void point_lamps(void **state)
{
    (void)state;
    float there = 10 / (4 * PI * 4) * 0.8f; /* P / 4 pi d2 cos, for a whole sphere of any radius too */
    struct scene_light light = at_height(LIGHT_POINT, LIGHT_SPHERE, 2);
    check(light, ORIGIN, TILTED, there, false);
    light.radius = 0.5f;
    check(light, ORIGIN, TILTED, there, true);
    light.radius = 1e-3f;
    check(light, ORIGIN, TILTED, there, false);
    /* The disc that faces the point: pi L r2 / (d2 + r2), L = P / 4 pi2 r2. */
    light.shape = LIGHT_DISC;
    light.radius = 0.5f;
    check(light, ORIGIN, UP, 10 / (4 * PI) / (4 + 0.25f), true);
    /* Inside a sphere all directions see it. */
    light.shape = LIGHT_SPHERE;
    light.radius = 3;
    check(light, ORIGIN, TILTED, 10 / (4 * PI * 9), true);
}

static void spot_lamps(void **state)
{
    (void)state;
    struct scene_light light = at_height(LIGHT_SPOT, LIGHT_SPHERE, 2);
    light.angle = 1;
    light.blend = 0.3f;
    float there = 10 / (4 * PI * 4), inner = cosf(0.5f);
    check(light, ORIGIN, UP, there, false);
    /* A quarter into the soft border, in cosines: smoothstep of 1/4 is 5/32. */
    float c = inner + (1 - inner) * 0.3f / 4, x = 2 * sqrtf(1 - c * c) / c;
    check(light, vec3(x, 0, 0), UP, 5.0f / 32 * 10 / (4 * PI * (4 + x * x)) * c, false);
    light.radius = 0.2f;
    check(light, ORIGIN, UP, there, true);
    light.shape = LIGHT_DISC;
    check(light, ORIGIN, UP, there * 4 / (4 + 0.04f), true);
    struct lights *lights = build(&light, 1);
    assert_true(sampled(lights, vec3(3, 0, 0), UP, 1000) == 0);
    assert_true(sampled(lights, vec3(0, 0, 4), scale(UP, -1), 1000) == 0);
    lights_free(lights);
}

/* A parallel rectangle a x b seen from below its corner, at height 1 (Siegel and Howell, configuration B-3 = 4). */
static float corner_factor(float a, float b)
{
    float p = sqrtf(1 + a * a), q = sqrtf(1 + b * b);
    return (a / p * atanf(b / p) + b / q * atanf(a / q)) / (2 * PI);
}

static void area_lamps(void **state)
{
    (void)state;
    struct scene_light light = at_height(LIGHT_AREA, LIGHT_RECTANGLE, 2);
    light.size[0] = 2;
    light.size[1] = 4;
    float radiance = 10 / (PI * 8);
    check(light, ORIGIN, UP, PI * radiance * 4 * corner_factor(0.5f, 1), true);
    check(light, vec3(1, 2, 0), UP, PI * radiance * corner_factor(1, 2), true);
    /* A round one: pi L r2 / (r2 + h2). */
    light = at_height(LIGHT_AREA, LIGHT_ELLIPSE, 2);
    light.size[0] = light.size[1] = 3;
    check(light, ORIGIN, UP, 10 / PI / (2.25f + 4), true);
    struct lights *lights = build(&light, 1);
    assert_true(sampled(lights, vec3(0, 0, 3), scale(UP, -1), 1000) == 0); /* dark behind */
    assert_true(met(lights, vec3(0, 0, 3), scale(UP, -1), 1000) == 0);
    lights_free(lights);
}

/* A spread keeps the power, and nothing leaves outside. */
static void area_spread(void **state)
{
    (void)state;
    static const float spreads[] = {0.08f, 1, 2.5f};
    for (int k = 0; k < 3; k++) {
        struct scene_light light = at_height(LIGHT_AREA, LIGHT_RECTANGLE, 0);
        light.size[0] = light.size[1] = 1e-5f;
        light.spread = spreads[k];
        struct lights *lights = build(&light, 1);
        enum { STEPS = 200 };
        double flux = 0;
        for (int i = 0; i < STEPS; i++) {
            float a = spreads[k] / 2 * ((float)i + 0.5f) / STEPS;
            float3 dir = {sinf(a), 0, -cosf(a)};
            flux += (double)sampled(lights, dir, scale(dir, -1), 4) * 2 * PI * sinf(a) * spreads[k] / 2 / STEPS;
        }
        assert_float_equal(flux, 10, 0.02);
        float outside = spreads[k] / 2 + 0.01f;
        assert_true(sampled(lights, vec3(sinf(outside), 0, -cosf(outside)), UP, 100) == 0);
        lights_free(lights);
    }
    struct scene_light wide = at_height(LIGHT_AREA, LIGHT_ELLIPSE, 2);
    wide.spread = 1.5f;
    struct lights *lights = build(&wide, 1);
    assert_float_equal(sampled(lights, ORIGIN, UP, 100000) / met(lights, ORIGIN, UP, 1000000), 1, 0.04f);
    check_densities(lights, ORIGIN, UP, 2e-3f);
    lights_free(lights);
}

static void suns(void **state)
{
    (void)state;
    struct scene_light light = at_height(LIGHT_SUN, LIGHT_SPHERE, 0);
    check(light, ORIGIN, TILTED, 8, false);
    light.angle = 0.00918f;
    check(light, ORIGIN, TILTED, 8, false);
    struct lights *lights = build(&light, 1);
    check_densities(lights, ORIGIN, TILTED, 2e-3f);
    lights_free(lights);
    light.angle = 0.5f;
    check(light, ORIGIN, TILTED, 8, true);
}

/* Several at once: weighed at each point up to 64, by power beyond. Both must give the sum and the densities. */
static void many_lamps(void **state)
{
    (void)state;
    static const int counts[] = {5, 100};
    for (int k = 0; k < 2; k++) {
        struct scene_light lights[100];
        float truth = 0;
        for (int i = 0; i < counts[k]; i++) {
            float x = (float)(i % 10) - 4.5f, y = (float)(i / 10) - 4.5f, d2 = x * x + y * y + 9;
            lights[i] = at_height(i % 2 ? LIGHT_POINT : LIGHT_SPOT, LIGHT_SPHERE, 3);
            lights[i].angle = 3;
            lights[i].transform[3] = x;
            lights[i].transform[7] = y;
            lights[i].radius = 0.1f + 0.02f * (float)(i % 7);
            lights[i].power[0] = lights[i].power[1] = lights[i].power[2] = (float)(1 + i % 3);
            truth += (float)(1 + i % 3) / (4 * PI * d2) * 3 / sqrtf(d2);
        }
        struct lights *built = build(lights, counts[k]);
        assert_true(lights_any(built));
        assert_float_equal(sampled(built, ORIGIN, UP, 400000) / truth, 1, 0.01f);
        check_densities(built, ORIGIN, UP, 2e-3f);
        lights_free(built);
    }
}

/* Pictures: a dim sky, one texel of sun, a bright patch across the seam and one at the pole. */
enum { WIDTH = 32, HEIGHT = 16 };

static void fill_sky(float *pixels)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int x = i % WIDTH, y = i / WIDTH;
        float v = y == 0                                 ? 60
                  : y == 5 && (x == 0 || x == WIDTH - 1) ? 200
                  : x == 20 && y == 3                    ? 900
                                                         : 0.5f + 0.1f * (float)(x % 3);
        for (int c = 0; c < 3; c++) pixels[3 * i + c] = v * (1 - 0.2f * (float)c);
    }
}

static float3 sphere_direction(int i, int count)
{
    float z = 1 - 2 * ((float)i + 0.5f) / (float)count, phi = (float)i * 2.39996323f, r = sqrtf(1 - z * z);
    return vec3(r * cosf(phi), r * sinf(phi), z);
}

static void environment_split(void **state)
{
    (void)state;
    float pixels[3 * WIDTH * HEIGHT];
    fill_sky(pixels);
    struct image image = {.width = WIDTH, .height = HEIGHT, .channel_count = 3, .pixels = pixels};
    struct scene_texture texture = {.type = TEXTURE_IMAGE};
    struct scene scene = {.textures = &texture, .texture_count = 1, .image_count = 1};
    struct textures textures = {.scene = &scene, .images = &image};
    scene.world = (struct scene_world){{2, 2, 2}, 0, {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}};
    struct environment e;
    assert_true(environment_build(&scene.world, &textures, &e));
    assert_true(e.strong_flux > 0);

    enum { DIRECTIONS = 400000 };
    double strong = 0, chance = 0;
    for (int i = 0; i < DIRECTIONS; i++) {
        float3 dir = sphere_direction(i, DIRECTIONS),
               local = {dir.y, -dir.x, dir.z}; /* the world turned by +90 degrees */
        rgb a = environment_strong(&e, dir), b = environment_rest(&e, dir);
        float2 uv = {0.5f - atan2f(local.y, local.x) / (2 * PI), 0.5f + asinf(local.z) / PI};
        float seen = texture_image(&image, uv, TEXTURE_LINEAR, TEXTURE_REPEAT, false).y;
        if (uv.y > 0.5f / HEIGHT && uv.y < 1 - 0.5f / HEIGHT) assert_float_equal((a.y + b.y) / (2 * seen), 1, 2e-3f);
        float pdf = environment_pdf(&e, dir);
        assert_true(is_black(a) || pdf > 0);
        assert_true(max3(b) <= e.threshold);
        strong += luminance(a);
        chance += pdf;
    }
    strong *= 4 * (double)PI / DIRECTIONS;
    assert_float_equal(chance * 4 * PI / DIRECTIONS, 1, 2e-3);

    double by_samples = 0;
    struct rng rng = rng_seed(4, 4, 4);
    int agreeing = 0;
    for (int i = 0; i < DIRECTIONS; i++) {
        float u[2] = {rng_float(&rng), rng_float(&rng)}, pdf;
        rgb along;
        float3 dir = environment_sample(&e, u, &pdf, &along);
        by_samples += (double)luminance(along) / pdf / DIRECTIONS;
        agreeing += fabsf(environment_pdf(&e, dir) / pdf - 1) < 1e-4f &&
                    fabsf(along.y - environment_strong(&e, dir).y) < 1e-3f * e.threshold;
    }
    assert_float_equal(by_samples / strong, 1, 5e-3);
    assert_true(agreeing > DIRECTIONS - DIRECTIONS / 1000);
    environment_free(&e);

    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) pixels[i] = 1;
    assert_true(environment_build(&scene.world, &textures, &e));
    assert_true(e.strong_flux == 0 && environment_pdf(&e, UP) == 0);
    assert_float_equal(environment_rest(&e, UP).x, 2, 1e-6f);
    environment_free(&e);
}

/* The strong light in cells: all of it, and what it sends to surfaces at any tilt, against quadrature. One cell an
 * eighth of the sphere's size would be 5 % off at some. The same by the places in the cells, each with its share. */
static void environment_in_cells(void **state)
{
    (void)state;
    enum { CELLS = 64, DIRECTIONS = 400000, TILTS = 40 };
    float pixels[3 * WIDTH * HEIGHT];
    fill_sky(pixels);
    struct image image = {.width = WIDTH, .height = HEIGHT, .channel_count = 3, .pixels = pixels};
    struct scene_texture texture = {.type = TEXTURE_IMAGE};
    struct scene scene = {.textures = &texture, .texture_count = 1, .image_count = 1};
    struct textures textures = {.scene = &scene, .images = &image};
    struct environment e;
    scene.world = (struct scene_world){{2, 2, 2}, 0, {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}};
    assert_true(environment_build(&scene.world, &textures, &e));
    struct environment_cell cells[CELLS];
    float3 places[CELLS * ENVIRONMENT_PLACES];
    int count = environment_cells(&e, CELLS, cells, places);
    assert_true(count > 20 && count <= CELLS);
    float exact[TILTS] = {0}, largest = 0;
    for (int i = 0; i < DIRECTIONS; i++) {
        float3 dir = sphere_direction(i, DIRECTIONS);
        float y = environment_strong(&e, dir).y * 4 * PI / DIRECTIONS;
        for (int k = 0; k < TILTS && y > 0; k++) exact[k] += y * maxf(dot(sphere_direction(k, TILTS), dir), 0);
    }
    for (int k = 0; k < TILTS; k++) largest = maxf(largest, exact[k]);
    for (int k = 0; k < TILTS; k++) {
        float sum = 0, by_places = 0;
        for (int i = 0; i < count; i++) {
            sum += cells[i].flux.y * cells[i].spread * maxf(dot(sphere_direction(k, TILTS), cells[i].wi), 0);
            for (int j = 0; j < ENVIRONMENT_PLACES; j++)
                by_places += cells[i].flux.y / ENVIRONMENT_PLACES *
                             maxf(dot(sphere_direction(k, TILTS), places[i * ENVIRONMENT_PLACES + j]), 0);
        }
        assert_float_equal(sum / largest, exact[k] / largest, .01f);
        assert_float_equal(by_places / largest, exact[k] / largest, .02f); /* texels are wide */
    }
    environment_free(&e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(point_lamps),
                                       cmocka_unit_test(spot_lamps),
                                       cmocka_unit_test(area_lamps),
                                       cmocka_unit_test(area_spread),
                                       cmocka_unit_test(suns),
                                       cmocka_unit_test(many_lamps),
                                       cmocka_unit_test(environment_split),
                                       cmocka_unit_test(environment_in_cells)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
