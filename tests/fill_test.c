/* SPDX-License-Identifier: Apache-2.0 */
/* Whole pictures by the caches of small scenes, in each mode of the records: no light twice, none lost. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tests/picture.h"

/* A floor, its right half glossy, seen from above. */
static struct stage *new_floor(void)
{
    struct stage *s = new_stage();
    add_quad(s, vec3(-2, 0, -2), vec3(2, 0, 0), vec3(0, 4, 0), grey(.6f, 0, 0, 0));
    add_quad(s, vec3(2, 0, -2), vec3(2, 0, 0), vec3(0, 4, 0), grey(.3f, .5f, 20, 0));
    s->scene.camera = (struct scene_camera){.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                            .window = {-.35f, .35f, -.35f, .35f},
                                            .width = 64,
                                            .height = 64};
    return s;
}

/* Lights of all kinds, one at a time, above the floor and behind the camera. */
enum { MESH, AREA, SPHERE, DISC, SPOT, WIDE_SUN, SKY, EXTENDED, POINT = EXTENDED, SUN, POINT_AND_MESH, KINDS };

static void add_light(struct stage *s, int kind)
{
    struct scene_light *light = &s->lights[0];
    *light = (struct scene_light){.transform = {1, 0, 0, .8f, 0, 1, 0, .4f, 0, 0, 1, 1.2f},
                                  .power = {100, 100, 100},
                                  .radius = kind == POINT || kind == POINT_AND_MESH ? 0 : 1,
                                  .size = {2, 1.6f},
                                  .angle = kind == WIDE_SUN ? .8f
                                           : kind == SUN    ? 0
                                                            : 2,
                                  .blend = .5f,
                                  .spread = PI};
    light->type = kind == AREA ? LIGHT_AREA : kind == SPOT ? LIGHT_SPOT : LIGHT_POINT;
    light->shape = kind == AREA ? LIGHT_RECTANGLE : kind == DISC ? LIGHT_DISC : LIGHT_SPHERE;
    if (kind == WIDE_SUN || kind == SUN) {
        light->type = LIGHT_SUN;
        light->power[0] = light->power[1] = light->power[2] = 3;
    }
    s->scene.light_count = kind != MESH && kind != SKY;
    if (kind == MESH || kind == POINT_AND_MESH)
        add_quad(s, vec3(.8f, .4f, 1.2f), vec3(1, 0, 0), vec3(0, -.8f, 0), grey(0, 0, 0, 20));
    if (kind == SKY) add_sky(s);
}

/* With direct light in the records the picture's mean is the path tracer's, whatever lights it; nothing is left for the
 * pixel to sample but lamps that no ray can hit. */
static void lamps_in_records(void **state)
{
    (void)state;
    for (int kind = 0; kind < KINDS; kind++) {
        struct stage *s = new_floor();
        add_light(s, kind);
        struct model model = build(s);
        struct light path = draw(&model, (struct render_options){RENDER_PATH, .spp = 16, .seed = 1});
        double truth = path.direct + path.indirect;
        for (int method = RENDER_HYBRID; method <= RENDER_EAS; method++) {
            struct light light =
                draw(&model, (struct render_options){(enum render_method)method, .spp = 4, .lamps_in_records = true});
            double sum = light.direct + light.indirect;
            if (!(fabs(sum / truth - 1) <= .03))
                fail_msg("kind %d, method %d: %g, by path tracing %g", kind, method, sum, truth);
            if (kind < EXTENDED) assert_true(light.direct == 0);
            else if (kind < POINT_AND_MESH) assert_float_equal(light.direct / path.direct, 1, .03f);
            else assert_true(light.direct > 0 && light.direct < .5 * path.direct);
            assert_float_equal(light.emission, path.emission, .1f * path.emission + 1e-6f);
        }
        end(s, &model);
    }
}

/* Inside a closed box that glows with 1 and reflects a, a/(1 - a) arrives besides the glow. */
static void furnace(void **state)
{
    (void)state;
    const float a = .5f;
    struct stage *s = new_stage();
    add_cube(s, 1, grey(a, 0, 0, 1));
    s->scene.camera.width = s->scene.camera.height = 16;
    struct model model = build(s);
    for (int all = 0; all < 2; all++) {
        struct light light = draw(&model, (struct render_options){RENDER_EAS, .spp = 4, .lamps_in_records = all == 1});
        assert_float_equal(light.emission, 1, 1e-5f);
        assert_float_equal(light.direct + light.indirect, a / (1 - a), .03f);
        assert_float_equal(light.direct, all ? 0 : a, .02f);
    }
    end(s, &model);
}

/* Over all surfaces, of a floor and of a cube, whose inside gets none: zones by the size of a picture of it all. */
static void over_surfaces(void **state)
{
    (void)state;
    uint64_t records[2];
    for (int k = 0; k < 2; k++) {
        struct stage *s = new_floor();
        add_cube(s, .4f, grey(.5f, .3f, 20, 0));
        add_light(s, MESH);
        s->scene.camera.width = s->scene.camera.height = k ? 256 : 64;
        s->scene.camera.transform[11] = 1; /* not in the cube */
        struct model model = build(s);
        struct progress quiet = {.quiet = true};
        struct fill_options options = {.kind = FILL_EAS, .surfaces = true};
        struct fill fill;
        char error[SCENE_ERROR];
        assert_true(fill_build(&model, &options, &quiet, &fill, error));
        records[k] = fill_records(&fill);
        for (uint32_t i = 0; i < fill.glossy.zones.count; i++) {
            float3 p = fill.glossy.zones.zones[i].p, n = fill.glossy.zones.zones[i].n;
            bool on_cube = max3(vec3(fabsf(p.x), fabsf(p.y), fabsf(p.z))) < .41f;
            assert_true(!on_cube || dot(p, n) > 0);
        }
        fill_free(&fill);
        end(s, &model);
    }
    assert_true(records[0] > 50 && 1.2 * (double)records[0] < (double)records[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lamps_in_records), cmocka_unit_test(furnace),
                                       cmocka_unit_test(over_surfaces)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
