/* SPDX-License-Identifier: Apache-2.0 */
/* Photons bring what gather rays would find of lamps in glossy surfaces: in the middle of a surface, at its edge, at a
 * wall, on a curved one. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/gather.h"
#include "stage.h"

/* A ceiling at z = 2 that bends upwards about the x axis. */
static void add_vault(struct stage *s, float radius)
{
    enum { STRIPS = 15 };
    float3 points[4 * STRIPS];
    for (int i = 0; i < 4 * STRIPS; i++) {
        float turn = ((float)(i / 4 + (i % 4 > 1)) - .5f * STRIPS) * PI / STRIPS, x = i % 4 == 1 || i % 4 == 2 ? 1 : -1;
        points[i] = vec3(x, radius * sinf(turn), 2 + radius * (cosf(.5f * PI / STRIPS) - cosf(turn)));
    }
    add_mesh(s, points, 4, STRIPS, grey(.7f, 0, 0, 0));
}

/* A glossy floor under a ceiling that a lamp half-way up doesn't light but by way of it. At y = 0, about which all
 * light is symmetrical, the ceiling goes on, or ends 2 cm on; or a wall 1 cm on, to the floor, hides half of the lamp;
 * or the ceiling bends. The camera's pixels are 8 mm wide there. */
enum place { OPEN, EDGE, WALL, VAULT, PLACES };

static struct model room(struct stage *s, struct scene_material floor, enum place place)
{
    struct scene_material lamp = grey(0, 0, 0, 20);
    lamp.emission_back = false;
    add_quad(s, vec3(0, 0, 0), vec3(2, 0, 0), vec3(0, 2, 0), floor);
    if (place == VAULT) add_vault(s, .4f);
    else add_quad(s, vec3(0, place == EDGE ? -.98f : 0, 2), vec3(0, 1, 0), vec3(1, 0, 0), grey(.7f, 0, 0, 0));
    if (place == WALL) add_quad(s, vec3(0, .01f, 1), vec3(2, 0, 0), vec3(0, 0, 1), grey(0, 0, 0, 0));
    float far = place == WALL ? 0 : .2f;
    add_quad(s, vec3(.2f, .5f * far - .1f, 1), vec3(0, .5f * far + .1f, 0), vec3(.2f, 0, 0), lamp); /* shines down */
    s->scene.camera.width = s->scene.camera.height = 512;
    return build(s);
}

/* A point of the ceiling at y = 0, seen from below. */
static float3 somewhere(struct rng *rng, struct side *side)
{
    const float3 down = {0, 0, -1}, p = {-.5f + .4f * rng_float(rng), 0, 2};
    *side = (struct side){sub(p, vec3(0, 0, 1e-5f)), down, down};
    return p;
}

/* Mean irradiance about there, of the light that photons hold, by rays, and its standard deviation. */
static float by_rays(const struct model *model, float *sigma)
{
    enum { RAYS = 60000 };
    const struct diffuse_cache none = {.zones = cache_empty(1)};
    struct rng rng = rng_seed(1, 2, 3);
    double sum = 0, squares = 0;
    for (int i = 0; i < RAYS; i++) {
        struct side side;
        somewhere(&rng, &side);
        float u[2] = {rng_float(&rng), rng_float(&rng)};
        struct ray ray = {side.origin, cosine_direction(side.n, u)};
        double e = PI * gather(model, &none, ray, &rng, NULL).caustic.x;
        sum += e / RAYS;
        squares += e * e / RAYS;
    }
    *sigma = (float)sqrt((squares - sum * sum) / RAYS);
    return (float)sum;
}

static void test_photons_bring_what_rays_find(void **state)
{
    (void)state;
    enum { MAPS = 4, QUERIES = 128 };
    struct scene_closure metal = scene_closure_of(CLOSURE_GLOSSY);
    metal.colour = (struct scene_colour){{.8f, .8f, .8f}, SCENE_NONE};
    metal.roughness.value = .5f;
    const struct scene_material floors[] = {grey(.1f, .8f, 30, 0), material_of(metal)};
    for (int i = 0; i < 2 * PLACES; i++) {
        struct stage *s = new_stage();
        struct model model = room(s, floors[i / PLACES], (enum place)(i % PLACES));
        struct rng rng = rng_seed(4, 5, 6);
        float sigma, rays = by_rays(&model, &sigma), photons = 0;
        for (int map = 0; map < MAPS; map++) {
            struct caustics caustics;
            assert_true(caustics_build(&model, (uint64_t)map, &caustics));
            assert_true(caustics.count > 1000);
            for (int k = 0; k < QUERIES; k++) {
                struct side side;
                float3 p = somewhere(&rng, &side);
                photons += caustics_irradiance(&model, &caustics, p, side, NULL, &rng).x / (MAPS * QUERIES);
            }
            caustics_free(&caustics);
        }
        assert_true(rays > .05f);
        /* They blur: beside a wall light that comes from one side alone falls off. */
        assert_float_equal(photons, rays, (i % PLACES == WALL ? .2f : .08f) * rays + 3 * sigma);
        end(s, &model);
    }
}

/* Nothing glossy, or no lamp: rays are left to find what there is. */
static void test_without_lobes_there_are_none(void **state)
{
    (void)state;
    struct stage *s = new_stage();
    struct model model = room(s, grey(.5f, 0, 0, 0), OPEN);
    struct caustics caustics;
    struct rng rng = rng_seed(1, 1, 1);
    const float3 up = {0, 0, 1};
    assert_true(caustics_build(&model, 3, &caustics));
    assert_int_equal(caustics.count, 0);
    assert_true(is_black(caustics_irradiance(&model, &caustics, up, (struct side){up, up, up}, NULL, &rng)));
    caustics_free(&caustics);
    end(s, &model);
}

/* A diffuse ground of 1 km2 below a floor that mirrors takes no places from it: of 64 estimates none stands out, as
 * bright spots would where few places send all the light. */
static void test_a_wide_ground_takes_no_places(void **state)
{
    (void)state;
    enum { QUERIES = 64 };
    struct stage *s = new_stage();
    add_quad(s, vec3(0, 0, -1), vec3(500, 0, 0), vec3(0, 500, 0), grey(.5f, 0, 0, 0));
    struct model model = room(s, grey(.1f, .8f, 1000, 0), OPEN);
    struct rng rng = rng_seed(7, 8, 9);
    struct caustics caustics;
    float most = 0, sum = 0;
    assert_true(caustics_build(&model, 1, &caustics));
    for (int k = 0; k < QUERIES; k++) {
        struct side side;
        float3 p = somewhere(&rng, &side);
        float e = caustics_irradiance(&model, &caustics, p, side, NULL, &rng).x;
        most = maxf(most, e);
        sum += e;
    }
    assert_true(most < 2 * sum / QUERIES);
    caustics_free(&caustics);
    end(s, &model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_photons_bring_what_rays_find),
        cmocka_unit_test(test_without_lobes_there_are_none),
        cmocka_unit_test(test_a_wide_ground_takes_no_places),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
