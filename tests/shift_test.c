/* SPDX-License-Identifier: Apache-2.0 */
/* The shift experiment: the EAS of one record of a glossy room's wall, seen from points about it, against fresh gathers
 * there. What translation must beat is the record's light left where it is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "scenes/experiments/shift.h"
#include "tests/stage.h"

struct room {
    struct stage *stage;
    struct model model;
    struct diffuse_cache cache;
};

static void add_box(struct stage *s, float3 centre, float3 half, float degrees, struct scene_material material)
{
    float c = cosf(degrees * PI / 180), d = sinf(degrees * PI / 180);
    const float transform[12] = {half.x * c, -half.y * d, 0, centre.x, half.x * d, half.y * c,
                                 0,          centre.y,    0, 0,        half.z,     centre.z};
    add_cube(s, 1, material);
    memcpy(s->objects[s->scene.object_count - 1].transform, transform, sizeof transform);
}

static struct scene_material wall(float r, float g, float b)
{
    struct scene_material material = grey(0, .3f, 100, 0);
    material.closures->colour = (struct scene_colour){{r, g, b}, SCENE_NONE};
    return material;
}

/* scenes/cornell_glossy/cornell_glossy.blend, by hand. */
static int setup(void **state)
{
    struct room *room = calloc(1, sizeof *room);
    struct stage *s = room->stage = new_stage();
    const float3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    struct scene_material lamp = grey(0, 0, 0, 15);
    lamp.emission_back = false;
    s->scene.camera = (struct scene_camera){.transform = {1, 0, 0, 0, 0, 0, -1, -4, 0, 1, 0, 1},
                                            .window = {-.325f, .325f, -.325f, .325f},
                                            .width = 384,
                                            .height = 384};
    add_quad(s, vec3(0, 0, 0), x, y, wall(.6f, .6f, .6f));
    add_quad(s, vec3(0, 0, 2), y, x, wall(.6f, .6f, .6f));
    add_quad(s, vec3(-1, 0, 1), y, z, wall(.57f, .04f, .04f));
    add_quad(s, vec3(1, 0, 1), z, y, wall(.05f, .36f, .06f));
    add_quad(s, vec3(0, 1, 1), x, z, wall(.4f, .4f, .4f));
    add_box(s, vec3(-.35f, .35f, .6f), vec3(.3f, .3f, .6f), 17, grey(.2f, .5f, 200, 0));
    add_box(s, vec3(.37f, -.3f, .3f), vec3(.3f, .3f, .3f), -17, grey(.3f, .4f, 40, 0));
    add_quad(s, vec3(0, 0, 1.99f), scale(y, .25f), scale(x, .25f), lamp);
    char error[SCENE_ERROR];
    struct progress quiet = {.quiet = true};
    room->model = build(s);
    *state = room;
    return diffuse_cache_build(&room->model, 0, 5, &quiet, &room->cache, error) ? 0 : -1;
}

static int teardown(void **state)
{
    struct room *room = *state;
    diffuse_cache_free(&room->cache);
    end(room->stage, &room->model);
    free(room);
    return 0;
}

static void shift(void **state)
{
    const struct room *room = *state;
    struct shift_result results[SHIFT_EXPONENTS];
    assert_true(shift_measure(&room->model, &room->cache, results));
    for (int k = 0; k < SHIFT_EXPONENTS; k++) {
        const struct shift_result *result = &results[k];
        print_message("n = %g: CV of the lobe:", SHIFT_EXPONENT[k]);
        for (int way = 0; way < SHIFT_WAYS; way++)
            print_message(" %.3f %s (%u bytes)%s", result->cv[way], SHIFT_NAMES[way], result->bytes[way],
                          way < SHIFT_WAYS - 1 ? "," : "\n");
        assert_true(result->cv[SHIFT_TRANSLATED] <= .65 * result->cv[SHIFT_STAY]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(shift)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
