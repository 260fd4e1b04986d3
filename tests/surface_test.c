/* SPDX-License-Identifier: Apache-2.0 */
/* Materials at a place: sums of closures and their sides, bent normals, light from textures. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "render/bumps.h"
#include "render/path.h"
#include "render/rng.h"
#include "render/surface.h"
#include "tests/stage.h"

static const struct texture_place FRONT = {.cosine = 1, .front = true}, BACK = {.cosine = 1};

static struct scene_closure coloured(enum closure_type type, float r, float g, float b)
{
    struct scene_closure closure = scene_closure_of(type);
    closure.colour = (struct scene_colour){{r, g, b}, SCENE_NONE};
    return closure;
}

static void closures_add_up(void **state)
{
    (void)state;
    struct scene scene = {0};
    struct textures none = {.scene = &scene};
    struct scene_closure closures[] = {
        coloured(CLOSURE_DIFFUSE, .4f, .2f, 0),     coloured(CLOSURE_DIFFUSE, 0, .4f, .8f),
        coloured(CLOSURE_TRANSLUCENT, .1f, .2f, 1), coloured(CLOSURE_TRANSPARENT, 1, .5f, .25f),
        coloured(CLOSURE_GLOSSY, .5f, .5f, .5f),
    };
    closures[0].weight = (struct scene_colour){{.5f, .5f, .5f}, SCENE_NONE};
    closures[1].weight = (struct scene_colour){{.25f, .5f, .25f}, SCENE_NONE};
    closures[2].back = false;
    closures[3].front = false;
    closures[4].roughness.value = .5f;
    struct scene_material material = {.closure_count = 5, .closures = closures};
    const float3 up = {0, 0, 1}, wo = {.6f, 0, .8f}, no_tangent = {0};
    struct brdf front, back;
    surface_brdf(&none, &material, &FRONT, up, wo, no_tangent, &front);
    assert_float_equal(front.kd.x, .2f, 1e-6f);
    assert_float_equal(front.kd.y, .3f, 1e-6f);
    assert_float_equal(front.kd.z, .2f, 1e-6f);
    assert_float_equal(front.kt.z, 1, 1e-6f);
    assert_true(is_black(front.through) && front.lobe_count == 1);
    assert_float_equal(front.lobes[0].alpha_x, .25f, 1e-6f);
    surface_brdf(&none, &material, &BACK, up, wo, no_tangent, &back);
    assert_true(is_black(back.kt));
    assert_float_equal(back.through.z, .25f, 1e-6f);
    assert_true(surface_is_glossy(&material) && surface_may_pass(&material) && !surface_has_tangent(&material));
    material.closure_count = 3;
    assert_true(!surface_is_glossy(&material) && !surface_may_pass(&material));
}

/* A quarter of a turn takes the tangent from x to y; positive anisotropy is sharper along it. */
static void tangents_turn(void **state)
{
    (void)state;
    struct scene scene = {0};
    struct textures none = {.scene = &scene};
    struct scene_closure closure = coloured(CLOSURE_PRINCIPLED, 1, 1, 1);
    closure.metallic.value = 1;
    closure.roughness.value = .5f;
    closure.anisotropy.value = .8f;
    closure.rotation.value = .25f;
    struct scene_material material = {.closure_count = 1, .closures = &closure};
    assert_true(surface_has_tangent(&material));
    const float3 up = {0, 0, 1}, x = {3, 0, 1}; /* not unit, not at right angles */
    struct brdf brdf;
    surface_brdf(&none, &material, &FRONT, up, up, x, &brdf);
    assert_true(brdf.lobe_count == 1 && brdf.lobes[0].alpha_x != brdf.lobes[0].alpha_y);
    assert_float_equal(brdf.lobes[0].tangent.x, 0, 1e-6f);
    assert_float_equal(brdf.lobes[0].tangent.y, 1, 1e-6f);
}

/* A picture whose one row of texels is a ramp from 0 to 1 in u, and a map that tilts by (x, y, z). */
struct pictures {
    float ramp[64], map[3];
    struct image images[2];
    bool encoded[2];
    struct scene_texture list[2];
    struct scene scene;
    struct textures textures;
};

static void draw(struct pictures *p, float3 tilt)
{
    *p = (struct pictures){.map = {.5f + tilt.x / 2, .5f + tilt.y / 2, .5f + tilt.z / 2}};
    for (int i = 0; i < 64; i++) p->ramp[i] = ((float)i + .5f) / 64;
    p->images[0] = (struct image){.width = 64, .height = 1, .channel_count = 1, .pixels = p->ramp};
    p->images[1] = (struct image){.width = 1, .height = 1, .channel_count = 3, .pixels = p->map};
    for (int i = 0; i < 2; i++)
        p->list[i] = (struct scene_texture){
            .type = TEXTURE_IMAGE, .image = i, .extension = TEXTURE_EXTEND, .uv_transform = {1, 0, 0, 0, 1, 0}};
    p->scene = (struct scene){.textures = p->list, .texture_count = 2, .image_count = 2};
    p->textures = (struct textures){&p->scene, p->images, p->encoded};
}

static void same(float3 found, float3 expected)
{
    float3 off = sub(found, normalize(expected));
    if (!(dot(off, off) < 1e-7f))
        fail_msg("found %g %g %g, expected %g %g %g", found.x, found.y, found.z, normalize(expected).x,
                 normalize(expected).y, normalize(expected).z);
}

static void normal_maps(void **state)
{
    (void)state;
    struct pictures p;
    draw(&p, vec3(.6f, .48f, .64f));
    const float3 up = {0, 0, 1}, down = {0, 0, -1};
    /* u runs along y, v along -x: both 2 m long for 1. */
    const float3 corners[3] = {{0, 0, 0}, {0, 2, 0}, {-2, 0, 0}};
    const float2 uvs[3] = {{0, 0}, {1, 0}, {0, 1}}, swapped[3] = {{0, 0}, {1, 0}, {0, -1}};
    struct uv_axes axes = uv_axes(corners, uvs), mirror = uv_axes(corners, swapped);
    assert_float_equal(axes.du.y, 2, 1e-6f);
    assert_float_equal(axes.dv.x, -2, 1e-6f);
    struct scene_normal bumps = {.type = NORMAL_MAP, .texture = 1, .strength = 1};
    same(bumps_normal(&p.textures, &bumps, &FRONT, &axes, up, 1), vec3(-.48f, .6f, .64f));
    same(bumps_normal(&p.textures, &bumps, &FRONT, &mirror, up, 1), vec3(.48f, .6f, .64f));
    same(bumps_normal(&p.textures, &bumps, &BACK, &axes, down, 1), vec3(.48f, -.6f, -.64f));
    bumps.strength = .5f;
    same(bumps_normal(&p.textures, &bumps, &FRONT, &axes, up, 1), vec3(-.24f, .3f, .82f));
    bumps.strength = 2;
    same(bumps_normal(&p.textures, &bumps, &FRONT, &axes, up, 1), vec3(-.96f, 1.2f, .64f));
    same(bumps_normal(&p.textures, &bumps, &FRONT, &(struct uv_axes){0}, up, 1), up);
}

/* The ramp raises the surface by `distance` over the 2 m that u takes along y. */
static void heights(void **state)
{
    (void)state;
    struct pictures p;
    draw(&p, vec3(0, 0, 1));
    const float3 up = {0, 0, 1}, down = {0, 0, -1}, corners[3] = {{0, 0, 0}, {0, 2, 0}, {-2, 0, 0}};
    const float2 uvs[3] = {{0, 0}, {1, 0}, {0, 1}};
    struct uv_axes axes = uv_axes(corners, uvs);
    struct texture_place front = {.uv = {.4f, .3f}, .front = true}, back = {.uv = {.4f, .3f}};
    struct scene_normal bumps = {.type = NORMAL_HEIGHT, .strength = 1, .distance = .5f};
    same(bumps_normal(&p.textures, &bumps, &front, &axes, up, .01f), vec3(0, -.25f, 1));
    same(bumps_normal(&p.textures, &bumps, &front, &axes, up, 1e-9f), vec3(0, -.25f, 1)); /* no smaller than it can */
    bumps.invert = true;
    same(bumps_normal(&p.textures, &bumps, &front, &axes, up, .01f), vec3(0, .25f, 1));
    /* From below it is seen as raised toward the viewer, as Cycles has it. */
    bumps.invert = false;
    same(bumps_normal(&p.textures, &bumps, &back, &axes, down, .01f), vec3(0, -.25f, -1));
    bumps.strength = .25f;
    float3 full = normalize(vec3(0, -.25f, 1));
    same(bumps_normal(&p.textures, &bumps, &front, &axes, up, .01f), add(scale(full, .25f), scale(up, .75f)));
}

/* A step across y = 1 m, not interpolated: seen by the directions that Cycles compares heights along, which for a
 * surface that looks up are (1, -1, 0) and (1, 1, 0). */
static void heights_of_steps(void **state)
{
    (void)state;
    struct pictures p;
    draw(&p, vec3(0, 0, 1));
    for (int i = 0; i < 64; i++) p.ramp[i] = i < 32 ? 0 : 1;
    p.list[0].interpolation = TEXTURE_CLOSEST;
    const float3 up = {0, 0, 1}, corners[3] = {{0, 0, 0}, {0, 2, 0}, {-2, 0, 0}};
    const float2 uvs[3] = {{0, 0}, {1, 0}, {0, 1}};
    struct uv_axes axes = uv_axes(corners, uvs);
    struct scene_normal bumps = {.type = NORMAL_HEIGHT, .strength = 1, .distance = .05f};
    const float from_step[] = {-.08f, -.05f, .05f, .08f}; /* m along y */
    const float s = .5f * sqrtf(.5f);                     /* a step of 1 in .1 m, .05 high */
    const float3 expected[] = {up, {-s, -s, 1}, {s, -s, 1}, up};
    for (int i = 0; i < 4; i++) {
        struct texture_place place = {.uv = {.5f + from_step[i] / 2, .3f}, .front = true};
        same(bumps_normal(&p.textures, &bumps, &place, &axes, up, .1f), expected[i]);
    }
}

static const float lamp_uvs[8] = {0, 0, 1, 0, 1, 1, 0, 1};

/* A square lamp of side 2 at height 1, 2 x 2 checks of radiance 8 and 2 on its front, which looks down. */
static struct stage *checked_lamp(struct scene_texture *checks)
{
    struct stage *s = new_stage();
    *checks = (struct scene_texture){.type = TEXTURE_CHECKER,
                                     .colour1 = {8, 8, 8},
                                     .colour2 = {2, 2, 2},
                                     .scale = 2,
                                     .uv_transform = {1, 0, 0, 0, 1, 0}};
    s->scene.textures = checks;
    s->scene.texture_count = 1;
    struct scene_material lamp = grey(0, 0, 0, 0);
    lamp.emission.texture = 0;
    lamp.emission_back = false;
    add_quad(s, vec3(0, 0, 0), vec3(4, 0, 0), vec3(0, 4, 0), grey(1, 0, 0, 0));
    add_quad(s, vec3(0, 0, 1), vec3(0, 1, 0), vec3(1, 0, 0), lamp);
    s->meshes[1].uvs = lamp_uvs;
    return s;
}

/* Light that a textured lamp sends to a white floor beside its middle, by quadrature over the lamp, by samples of it,
 * and by paths that weigh those against rays that meet it. */
static void light_from_a_texture(void **state)
{
    (void)state;
    enum { SIDE = 400, SAMPLES = 40000 };
    struct scene_texture checks;
    struct stage *s = checked_lamp(&checks);
    struct model model = build(s);
    struct ray ray = {vec3(.3f, -.6f, .5f), vec3(0, 0, -1)};
    struct hit hit;
    struct point point;
    assert_true(trace_closest(model.trace, ray.origin, ray.dir, INFINITY, &hit));
    shade_point(&model, ray, &hit, &point);
    double truth = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        float x = 2 * ((float)(i % SIDE) + .5f) / SIDE - 1, y = 2 * ((float)(i / SIDE) + .5f) / SIDE - 1;
        float3 to = sub(vec3(x, y, 1), point.p);
        float d2 = dot(to, to), radiance = (x > 0) == (y > 0) ? 8 : 2;
        truth += radiance / sqr(d2) / PI * 4 / (SIDE * SIDE);
    }
    struct rng rng = rng_seed(1, 2, 3);
    double sampled = 0, weighed = 0;
    for (int i = 0; i < SAMPLES; i++) {
        float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)};
        sampled += shade_direct(&model, &point, u, false).x / SAMPLES;
        weighed += path_radiance(&model, &point, NULL, &rng).direct.x / SAMPLES;
    }
    assert_float_equal(sampled / truth, 1, .01f);
    assert_float_equal(weighed / truth, 1, .01f);
    end(s, &model);
}

/* The same lamp, mirrored and shared by two objects: its picture is mirrored with it. */
static void light_from_a_mirrored_lamp(void **state)
{
    (void)state;
    enum { SAMPLES = 20000 };
    struct scene_texture checks;
    struct stage *s = checked_lamp(&checks);
    struct scene_object *copy = add_object(s, 1, 1);
    checks.uv_transform[4] = 0; /* stripes: other ones where u and v change places */
    s->objects[1].transform[3] = 100; /* far away */
    copy->transform[0] = -1;
    struct model model = build(s);
    struct rng rng = rng_seed(1, 2, 3);
    struct light_sample light;
    int counts[2] = {0};
    for (int i = 0; i < SAMPLES; i++) {
        float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)};
        const float3 p = {0, 0, .1f}, up = {0, 0, 1};
        if (!lights_sample(model.lights, p, up, u, &light) || light.distance > 10) continue;
        struct hit hit;
        struct point point;
        if (!trace_closest(model.trace, p, light.wi, 2 * light.distance, &hit)) continue;
        shade_point(&model, (struct ray){p, light.wi}, &hit, &point);
        counts[fabsf(light.weight.x * light.pdf / point.emission.x - 1) > 1e-3f]++;
    }
    assert_in_range(counts[0], SAMPLES / 3, SAMPLES);
    assert_in_range(counts[1], 0, SAMPLES / 500); /* at the borders of the checks */
    end(s, &model);
}

static void light_of_the_back(void **state)
{
    (void)state;
    struct scene scene = {0};
    struct textures none = {.scene = &scene};
    struct scene_material material = {.emission = {{3, 3, 3}, SCENE_NONE}, .emission_back = true};
    assert_true(is_black(surface_emission(&none, &material, &FRONT)));
    assert_float_equal(surface_emission(&none, &material, &BACK).x, 3, 0);
    /* A lamp that shines from its back alone lights what its back sees. */
    struct stage *s = new_stage();
    struct scene_material lamp = grey(0, 0, 0, 3);
    lamp.emission_front = false;
    add_quad(s, vec3(0, 0, 1), vec3(1, 0, 0), vec3(0, 1, 0), lamp); /* its front looks up */
    struct model model = build(s);
    struct light_sample light;
    const float u[3] = {.3f, .4f, .5f};
    assert_true(lights_sample(model.lights, vec3(0, 0, 0), vec3(0, 0, 1), u, &light));
    assert_false(lights_sample(model.lights, vec3(0, 0, 2), vec3(0, 0, -1), u, &light));
    end(s, &model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(closures_add_up),
                                       cmocka_unit_test(tangents_turn),
                                       cmocka_unit_test(normal_maps),
                                       cmocka_unit_test(heights),
                                       cmocka_unit_test(heights_of_steps),
                                       cmocka_unit_test(light_from_a_texture),
                                       cmocka_unit_test(light_from_a_mirrored_lamp),
                                       cmocka_unit_test(light_of_the_back)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
