/* SPDX-License-Identifier: Apache-2.0 */
/* The shift experiment: the EAS of one record of a glossy room's wall, seen from points about it, against fresh gathers
 * there. What translation must beat is the record's light left where it is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "eas/occlusion.h"
#include "eas/select.h"
#include "render/gather.h"
#include "tests/stage.h"

enum { RECORD_RAYS = 4000, TRUTH_RAYS = 16000, POINTS = 24, DIRECTIONS = 128, MOST_EAS = 4000 };

/* The record, on the back wall, and how far the points are from it: 5 % of the room's 2 m. */
static const float3 RECORD = {.35f, 1, .9f}, NORMAL = {0, -1, 0};
#define SHIFT .1f

struct room {
    struct stage *stage;
    struct model model;
    struct diffuse_cache cache;
    struct mean_brdf *tables;
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
    material.colour = (struct scene_colour){{r, g, b}, SCENE_NONE};
    return material;
}

/* scenes/cornell_glossy/cornell_glossy.blend, by hand. */
static int setup(void **state)
{
    struct room *room = calloc(1, sizeof *room);
    struct stage *s = room->stage = new_stage();
    const float3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    struct scene_material lamp = grey(0, 0, 0, 15);
    lamp.emission_front_only = true;
    s->scene.camera =
        (struct scene_camera){{1, 0, 0, 0, 0, 0, -1, -4, 0, 1, 0, 1}, {-.325f, .325f, -.325f, .325f}, 384, 384};
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
    room->tables = mean_brdf_build();
    *state = room;
    return diffuse_cache_build(&room->model, 5, &quiet, &room->cache, error) && room->tables ? 0 : -1;
}

static int teardown(void **state)
{
    struct room *room = *state;
    diffuse_cache_free(&room->cache);
    mean_brdf_free(room->tables);
    end(room->stage, &room->model);
    free(room);
    return 0;
}

/* Light that arrives at a point of the wall: so many rays' samples, on surfaces and in mirrors. */
struct samples {
    uint32_t count;
    struct gather_sample surface[TRUTH_RAYS + 400], mirrored[TRUTH_RAYS + 400];
};

static void gather_samples(const struct room *room, float3 p, int rays, uint64_t seed, struct samples *out)
{
    struct gather_grid grid = gather_grid(rays);
    struct frame frame = frame_about(NORMAL);
    int count = grid.rows * grid.columns;
    float omega = 2 * PI / (float)count;
    out->count = (uint32_t)count;
#pragma omp parallel for schedule(dynamic, 64)
    for (int i = 0; i < count; i++) {
        struct rng rng = rng_seed(seed, 7, (uint64_t)i);
        float u = rng_float(&rng), v = rng_float(&rng);
        float3 dir = to_world(frame, gather_direction(grid, i / grid.columns, i % grid.columns, u, v));
        struct ray ray = {trace_offset(p, NORMAL), dir};
        struct gathered light = gather(&room->model, &room->cache, ray, &rng, NULL);
        out->surface[i] =
            (struct gather_sample){dir, light.distance, light.normal, light.surface, omega, vec3(0, 0, 0)};
        out->mirrored[i] =
            (struct gather_sample){dir, light.mirrored_distance, scale(dir, -1), light.mirrored, omega, vec3(0, 0, 0)};
    }
}

/* Viewers: DIRECTIONS over the hemisphere but its rim. */
static float3 viewer(int i)
{
    float z = 1 - .95f * ((float)i + .5f) / DIRECTIONS, r = sqrtf(1 - z * z), phi = 2.3999632f * (float)i;
    return to_world(frame_about(NORMAL), vec3(r * cosf(phi), r * sinf(phi), z));
}

/* A sunflower's ring of points about the record, all SHIFT away. */
static float3 shifted(int i)
{
    float phi = 2 * PI * ((float)i + .3f) / POINTS;
    return add(RECORD, vec3(SHIFT * cosf(phi), 0, SHIFT * sinf(phi)));
}

/* All samples' light in one lobe. */
static double reflected(const struct samples *samples, const struct lobe *lobe, float3 wo)
{
    double sum = 0;
    for (uint32_t i = 0; i < samples->count; i++) {
        const struct gather_sample *s = &samples->surface[i];
        double light = luminance(add(s->radiance, samples->mirrored[i].radiance)) * s->omega;
        if (light > 0) sum += light * lobe_eval(lobe, NORMAL, wo, s->dir).x * dot(s->dir, NORMAL);
    }
    return sum;
}

/* The ways to see a record from elsewhere. */
enum { STAY, PINNED, IMAGES, TRANSLATED, WAYS };
static const char *const names[WAYS] = {"not moved", "pinned to what was hit (the paper)", "mirrors' images apart",
                                        "with the visibility gradient"};

static void choose(const struct room *room, struct samples *samples, const struct brdf *brdf, int way, struct eas *eas,
                   uint32_t *count)
{
    static const struct select_options options = SELECT_DEFAULTS;
    struct frame frame = frame_about(NORMAL);
    struct select_scratch scratch = {0};
    struct sample_tree trees[2] = {{0}};
    struct gather_sample *surface = malloc(2 * samples->count * sizeof *surface), *mirrored = surface + samples->count;
    uint32_t mirrored_count = 0;
    struct gather_grid grid = gather_grid(RECORD_RAYS);
    struct occlusion *occlusions = malloc(samples->count * sizeof *occlusions);
    occlusion_of(samples->surface, grid, frame, occlusions);
    for (uint32_t i = 0; i < samples->count; i++) {
        surface[i] = samples->surface[i];
        if (way < IMAGES) surface[i].radiance = add(surface[i].radiance, samples->mirrored[i].radiance);
        if (way == STAY) surface[i].distance = INFINITY;
        if (way == TRANSLATED)
            surface[i].uncovered = occlusion_uncovered(&occlusions[i], surface[i].distance, surface[i].omega);
        if (is_black(samples->mirrored[i].radiance)) continue;
        struct gather_sample *m = &mirrored[mirrored_count++];
        *m = samples->mirrored[i];
        if (way == TRANSLATED) m->uncovered = occlusion_uncovered(&occlusions[i], m->distance, m->omega);
    }
    assert_true(sample_tree_build(&trees[0], surface, samples->count, RECORD, frame));
    assert_true(sample_tree_build(&trees[1], mirrored, mirrored_count, RECORD, frame));
    struct select_place place = {RECORD, frame, viewer(40), way == STAY ? 0 : SHIFT, 0, 0};
    *count = select_eas(trees, way >= IMAGES ? 2 : 1, room->tables, brdf->lobes, 1, &place, &options, &scratch, eas);
    assert_true(*count > 0 && *count < UINT32_MAX);
    select_free(&scratch);
    for (int i = 0; i < 2; i++) sample_tree_free(&trees[i]);
    free(surface);
    free(occlusions);
}

static void shift(void **state)
{
    const struct room *room = *state;
    static const float exponents[] = {100, 200};
    struct samples *record = malloc(sizeof *record), *truth = malloc(sizeof *truth);
    struct eas *eas[2][WAYS];
    uint32_t counts[2][WAYS];
    struct brdf brdfs[2];
    double squares[2][WAYS + 1] = {{0}}, sums[2] = {0};
    gather_samples(room, RECORD, RECORD_RAYS, 1, record);
    for (int k = 0; k < 2; k++) {
        brdfs[k] = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), exponents[k]);
        for (int way = 0; way < WAYS; way++) {
            eas[k][way] = malloc(MOST_EAS * sizeof **eas[k]);
            choose(room, record, &brdfs[k], way, eas[k][way], &counts[k][way]);
        }
    }
    for (int i = 0; i < POINTS; i++) {
        float3 x = shifted(i);
        gather_samples(room, x, TRUTH_RAYS, 100 + (uint64_t)i, truth);
        gather_samples(room, x, RECORD_RAYS, 200 + (uint64_t)i, record);
        for (int k = 0; k < 2; k++)
            for (int j = 0; j < DIRECTIONS; j++) {
                const struct lobe *lobe = &brdfs[k].lobes[0];
                struct mean_lobe mean = mean_lobe(room->tables, lobe, NORMAL, viewer(j));
                double exact = reflected(truth, lobe, viewer(j));
                sums[k] += exact;
                for (int way = 0; way < WAYS; way++) {
                    rgb sum = eas_reflect(eas[k][way], counts[k][way], &mean, x);
                    squares[k][way] += (luminance(sum) - exact) * (luminance(sum) - exact);
                }
                double noisy = reflected(record, lobe, viewer(j)) - exact;
                squares[k][WAYS] += noisy * noisy;
            }
    }
    for (int k = 0; k < 2; k++) {
        double cv[WAYS + 1];
        for (int way = 0; way <= WAYS; way++) cv[way] = sqrt(squares[k][way] * POINTS * DIRECTIONS) / sums[k];
        print_message("n = %g: CV of the lobe from a record %g m away:", exponents[k], SHIFT);
        for (int way = 0; way < WAYS; way++) print_message(" %.3f %s (%u EAS),", cv[way], names[way], counts[k][way]);
        print_message(" noise of as many rays %.3f\n", cv[WAYS]);
        assert_true(cv[TRANSLATED] <= .65 * cv[STAY]);
        for (int way = 0; way < WAYS; way++) free(eas[k][way]);
    }
    free(record);
    free(truth);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(shift)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
