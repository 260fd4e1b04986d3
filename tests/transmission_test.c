/* SPDX-License-Identifier: Apache-2.0 */
/* Light through surfaces, by the path tracer and through the caches: panes, veils, glass, rough and clear, whose answer
 * is known or the path tracer's. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tests/picture.h"

/* Hybrid differs from EAS in what its records hold alone: two scenes ask it, too. */
enum { METHODS = 3 };
static const enum render_method METHOD[METHODS] = {RENDER_PATH, RENDER_EAS, RENDER_HYBRID};

static double all(struct light light) { return light.direct + light.indirect + light.emission; }

static struct scene_material material_with(enum closure_type type, float colour)
{
    struct scene_closure closure = scene_closure_of(type);
    closure.colour = (struct scene_colour){{colour, colour, colour}, SCENE_NONE};
    return material_of(closure);
}

static struct scene_material glass(float roughness)
{
    struct scene_material material = material_with(CLOSURE_GLASS, 1);
    material.closures[0].roughness.value = roughness;
    material.closures[0].ior.value = 1.5f;
    return material;
}

/* A square of half side `half` at height z that looks up; the camera looks down on it from 0. */
static void add_floor(struct stage *s, float z, float half, struct scene_material material)
{
    add_quad(s, vec3(0, 0, z), vec3(half, 0, 0), vec3(0, half, 0), material);
}

static struct stage *new_view(int pixels)
{
    struct stage *s = new_stage();
    s->scene.camera.width = s->scene.camera.height = pixels;
    for (int i = 0; i < 4; i++) s->scene.camera.window[i] = i % 2 ? .3f : -.3f;
    return s;
}

/* Through two panes of .5 and .8 a glowing wall has .4 of its radiance, and so has what is lit behind them. */
static void panes_before_a_light(void **state)
{
    (void)state;
    for (int k = 0; k < METHODS; k++) {
        struct stage *s = new_view(16);
        add_floor(s, -1, 3, material_with(CLOSURE_TRANSPARENT, .5f));
        add_floor(s, -2, 3, material_with(CLOSURE_TRANSPARENT, .8f));
        add_floor(s, -3, 5, grey(0, 0, 0, 10));
        struct model model = build(s);
        assert_true(model.panes);
        assert_float_equal(all(draw(&model, (struct render_options){METHOD[k], .spp = 16})), 4, 1e-3f);
        end(s, &model);
    }
}

/* A floor lit through a pane: each kind of light loses what the pane takes, and that twice where it is seen through it,
 * too. */
static void floor_under_a_pane(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++)
        for (int k = 0; k < METHODS - 1; k++) {
            double sums[2];
            for (int pane = 0; pane < 2; pane++) {
                struct stage *s = new_view(16);
                add_floor(s, -2, 2, grey(.5f, .2f, 20, 0));
                if (pane) add_floor(s, -1, 50, material_with(CLOSURE_TRANSPARENT, .6f));
                struct scene_light light = {.transform = {1, 0, 0, .5f, 0, 1, 0, 0, 0, 0, 1, .5f},
                                            .power = {100, 100, 100},
                                            .size = {2, 1.6f},
                                            .spread = PI};
                light.type = kind == 0 ? LIGHT_POINT : kind == 1 ? LIGHT_AREA : LIGHT_SUN;
                light.shape = kind == 1 ? LIGHT_RECTANGLE : LIGHT_SPHERE;
                if (kind == 2) light.angle = .5f, light.power[0] = light.power[1] = light.power[2] = 3;
                if (kind == 3) add_quad(s, vec3(.5f, 0, .5f), vec3(1, 0, 0), vec3(0, -.8f, 0), grey(0, 0, 0, 20));
                else s->lights[s->scene.light_count++] = light;
                struct model model = build(s);
                sums[pane] = all(draw(&model, (struct render_options){METHOD[k], .spp = 64}));
                end(s, &model);
            }
            if (!(fabs(sums[1] / sums[0] / .36 - 1) < .03))
                fail_msg("light %d, method %d: %g of %g", kind, k, sums[1], sums[0]);
        }
}

/* A veil that reflects .2 and lets .5 pass diffusely has .7 of an even sky; lit from behind alone, by a glowing square
 * of half side 2 in 2 m, .5 of its form factor. */
static void veil(void **state)
{
    (void)state;
    for (int k = 0; k < METHODS; k++)
        for (int behind = 0; behind < 2; behind++) {
            struct stage *s = new_view(16);
            struct scene_closure both[2] = {scene_closure_of(CLOSURE_DIFFUSE), scene_closure_of(CLOSURE_TRANSLUCENT)};
            struct scene_material sheet = material_of(both[0]);
            for (int i = 0; i < 3; i++) both[0].colour.value[i] = .2f, both[1].colour.value[i] = .5f;
            sheet.closure_count = 2;
            sheet.closures = both;
            add_floor(s, -1, behind ? 30 : 2, sheet);
            if (behind) add_floor(s, -3, 2, grey(0, 0, 0, 1));
            else s->scene.world = (struct scene_world){{1, 1, 1}, SCENE_NONE, {0}};
            struct model model = build(s);
            const float form = 4 / PI * sqrtf(.5f) * atanf(sqrtf(.5f));
            double sum = all(draw(&model, (struct render_options){METHOD[k], .spp = 16}));
            if (!(fabs(sum - (behind ? .5f * form : .7f)) < .01)) fail_msg("behind %d, method %d: %g", behind, k, sum);
            end(s, &model);
        }
}

/* Clear glass takes nothing away: in an even sky it can't be seen, nor in a furnace, where all is 1/(1 - a). What rough
 * glass loses from inside (tests/closures_test.c) all methods lose; paths through it need many samples. */
static void furnace(void **state)
{
    (void)state;
    for (int rough = 0; rough < 2; rough++) {
        struct stage *s = new_view(16);
        add_cube(s, .3f, glass(.3f * (float)rough));
        memcpy(s->objects[0].transform, (float[12]){.8f, -.6f, 0, 0, .48f, .64f, -.6f, 0, .36f, .48f, .8f, -1.2f},
               sizeof(float[12]));
        s->scene.world = (struct scene_world){{1, 1, 1}, SCENE_NONE, {0}};
        struct model sky = build(s);
        double truth[2] = {1, 2};
        for (int k = 0; k < METHODS - 1; k++) {
            double sum = all(draw(&sky, (struct render_options){METHOD[k], .spp = 64}));
            if (k == 0 && rough) truth[0] = sum;
            if (!(fabs(sum / truth[0] - 1) < (rough ? .03 : .005)))
                fail_msg("sky, method %d, rough %d: %g", k, rough, sum);
        }
        assert_true(truth[0] > .9);
        model_free(&sky);
        add_cube(s, 2, grey(.5f, 0, 0, 1));
        struct model room = build(s);
        for (int k = 0; k < METHODS - 1; k++) {
            double sum = all(draw(&room, (struct render_options){METHOD[k], .spp = k == 0 && rough ? 512 : 64}));
            if (k == 0 && rough) truth[1] = sum;
            if (!(fabs(sum / truth[1] - 1) < .03))
                fail_msg("room, method %d, rough %d: %g of %g", k, rough, sum, truth[1]);
        }
        assert_true(truth[1] > 1.8);
        end(s, &room);
    }
}

/* A glass block, a glossy floor and a lamp in a room: the caches' mean is the path tracer's. */
static void block_in_a_room(void **state)
{
    (void)state;
    struct stage *s = new_view(48);
    add_cube(s, .3f, glass(0));
    memcpy(s->objects[0].transform, (float[12]){.8f, -.6f, 0, .2f, .48f, .64f, -.6f, .1f, .36f, .48f, .8f, -1.4f},
           sizeof(float[12]));
    add_floor(s, -2, 2, grey(.4f, .3f, 30, 0));
    add_quad(s, vec3(-2, 0, 0), vec3(0, 2, 0), vec3(0, 0, 2), grey(.6f, 0, 0, 0));
    add_quad(s, vec3(.5f, 0, 1), vec3(1, 0, 0), vec3(0, -1, 0), grey(0, 0, 0, 5));
    struct model model = build(s);
    double truth = all(draw(&model, (struct render_options){RENDER_PATH, .spp = 256, .seed = 3}));
    for (int k = 1; k < METHODS; k++) {
        double sum = all(draw(&model, (struct render_options){METHOD[k], .spp = 16}));
        if (!(fabs(sum / truth - 1) < .03)) fail_msg("method %d: %g, by path tracing %g", k, sum, truth);
    }
    end(s, &model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(panes_before_a_light), cmocka_unit_test(floor_under_a_pane),
                                       cmocka_unit_test(veil), cmocka_unit_test(furnace),
                                       cmocka_unit_test(block_in_a_room)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
