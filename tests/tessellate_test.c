/* SPDX-License-Identifier: Apache-2.0 */
/* Vertices that are shared, meshes that are odd, and the level that a cage is refined to. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "import/level.h"
#include "tests/meshes.h"

#define LENGTH(a) (sizeof(a) / sizeof(a)[0])

static void polygons_share_what_agrees(void **state)
{
    (void)state;
    struct grid g;
    make_grid(&g, flat_height);
    g.mesh.subdivided = false;
    g.mesh.normals = g.normals; /* of length 2 */
    const uint32_t shared = (GRID + 1) * (GRID + 1);
    struct triangles t = tessellated(&g.mesh, 0);
    assert_int_equal(t.vertex_count, shared);
    assert_int_equal(t.triangle_count, 2 * GRID * GRID);
    assert_true(fabs(total_area(&t) - GRID * GRID) < 1e-5);
    triangles_free(&t);

    g.uvs[8 * 20 + 4] += 1; /* one corner has another uv */
    t = tessellated(&g.mesh, 0);
    assert_int_equal(t.vertex_count, shared + 1);
    triangles_free(&t);

    memcpy(g.normals + 12 * 40 + 6, (float[3]){0, 1, 1}, 3 * sizeof(float)); /* another another normal */
    memset(g.normals + 12 * 50, 0, 3 * sizeof(float)); /* none: the face's own, here the same as its neighbours' */
    t = tessellated(&g.mesh, 0);
    assert_int_equal(t.vertex_count, shared + 2);
    triangles_free(&t);

    g.mesh.normals = NULL; /* flat */
    t = tessellated(&g.mesh, 0);
    assert_int_equal(t.vertex_count, 4 * GRID * GRID);
    triangles_free(&t);
    make_grid(&g, bumpy_height);
    g.mesh.subdivided = false;
    t = tessellated(&g.mesh, 0); /* bent quads: each triangle has its own normal */
    for (uint32_t i = 0; i < t.triangle_count; i++) {
        double facet[3];
        triangle_area(&t, i, facet);
        for (int k = 0; k < 3; k++) assert_true(dot(t.normals + 3 * t.indices[3 * i + k], facet) > 1 - 1e-6);
    }
    triangles_free(&t);
}

/* Repeated vertices, faces without area, three faces at an edge, two cones at a vertex, loose vertices, nothing at all.
 */
static void odd_meshes_survive(void **state)
{
    (void)state;
    const float positions[] = {0, 0, 0, 1,  0, 0, 0,  1, 0,  0, 0, 1, 0, -1, 0,
                               2, 2, 2, -1, 0, 1, -1, 0, -1, 0, 0, 0, 0, 0,  0};
    const uint32_t three_at_edge[] = {0, 1, 2, 0, 1, 3, 0, 1, 4}, repeated[] = {0, 1, 1, 2, 0, 2, 2, 2, 3, 3};
    const uint32_t bow_tie[] = {0, 1, 2, 0, 6, 7}, pointlike[] = {0, 8, 9, 0, 9, 8}, turned[] = {0, 1, 2, 0, 1, 2};
    const uint32_t threes[] = {3, 3, 3}, four_six[] = {4, 6};
    const struct {
        const uint32_t *corners, *sizes;
        uint32_t count, faces;
    } cases[] = {
        {three_at_edge, threes, 9, 3}, {repeated, four_six, 10, 2}, {bow_tie, threes, 6, 2},
        {pointlike, threes, 6, 2},     {turned, threes, 6, 2},      {turned, threes, 0, 0},
    };
    float uvs[2 * 10] = {0}, normals[3 * 10] = {0};
    for (size_t i = 0; i < LENGTH(cases); i++)
        for (int kind = 0; kind < 32; kind++) {
            bool cage = kind & 1;
            struct scene_mesh mesh = {.name = "odd",
                                      .vertex_count = 10,
                                      .face_count = cases[i].faces,
                                      .corner_count = cases[i].count,
                                      .positions = positions,
                                      .face_sizes = cases[i].sizes,
                                      .corners = cases[i].corners,
                                      .subdivided = cage,
                                      .smooth = kind & 2,
                                      .uvs = kind & 4 ? uvs : NULL,
                                      .normals = cage || !(kind & 2) ? NULL : normals,
                                      .scheme = kind & 8 ? SUBDIVISION_BILINEAR : SUBDIVISION_CATMULL_CLARK,
                                      .boundary = kind & 16 ? BOUNDARY_EDGE_AND_CORNER : BOUNDARY_EDGE_ONLY};
            struct triangles t = tessellated(&mesh, 2);
            assert_int_equal(t.triangle_count, cage ? 8 * cases[i].count : cases[i].count - 2 * cases[i].faces);
            triangles_free(&t);
        }
}

/* A square of side 1 whose edges' middles are 10 from the camera; 1000 pixels a unit of the window: 100 pixels an edge.
 */
static void level_counts_pixels(void **state)
{
    (void)state;
    const float depth = sqrtf(100 - .25f);
    float positions[12] = {-.5, -.5, -depth, .5, -.5, -depth, .5, .5, -depth, -.5, .5, -depth};
    const uint32_t corners[4] = {0, 1, 2, 3}, size = 4;
    struct scene_mesh mesh = {.name = "square",
                              .vertex_count = 4,
                              .face_count = 1,
                              .corner_count = 4,
                              .positions = positions,
                              .face_sizes = &size,
                              .corners = corners,
                              .subdivided = true};
    struct scene_camera camera = {.window = {-1, 1, -.5, .5}, .width = 2000, .height = 1000};
    memcpy(camera.transform, identity, sizeof identity);
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 1), 7);
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 99 / 8.f), 4);
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 101 / 8.f), 3);
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 101), 0);
    /* A longer lens, a larger object as far away, one behind the camera. */
    camera.window[2] = -.25, camera.window[3] = .25;
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 101), 1);
    camera.window[2] = -.5, camera.window[3] = .5;
    float transform[12];
    memcpy(transform, identity, sizeof identity);
    transform[0] = transform[5] = 4; /* 400 pixels, but for the longer way to the middles */
    assert_int_equal(level_by_edges(&mesh, transform, &camera, 101 / 8.f), 5);
    memcpy(transform, identity, sizeof identity);
    transform[11] = 2 * depth;
    assert_int_equal(level_by_edges(&mesh, transform, &camera, 1), 7);
    camera.transform[3] = 1000, camera.transform[11] = -depth; /* the camera leaves */
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 1.01f), 0);
    camera.transform[3] = .5; /* in the middle of an edge */
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 1), 10);
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 125.1f), 5); /* not above 4 units of the window */
    /* An edge that leads away from the camera, 8 long, its middle at 5. */
    memset(positions, 0, sizeof positions);
    camera.transform[3] = camera.transform[11] = 0;
    positions[2] = positions[11] = -1;
    positions[5] = positions[8] = -9;
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 801), 1);
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 799), 2);
    memset(positions, 0, sizeof positions);
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 1), 0);
    mesh.subdivided = false;
    assert_int_equal(level_by_edges(&mesh, identity, &camera, 1), 0);
}

static void level_has_a_bound(void **state)
{
    (void)state;
    struct grid g;
    make_grid(&g, flat_height);
    struct scene_camera camera = {.window = {-1, 1, -1, 1}, .width = 100000, .height = 100000};
    memcpy(camera.transform, identity, sizeof identity);
    camera.transform[11] = .5;
    int level = level_by_edges(&g.mesh, identity, &camera, 1);
    assert_true(2. * GRID * GRID * pow(4, level) <= LEVEL_TRIANGLES);
    assert_true(2. * GRID * GRID * pow(4, level + 1) > LEVEL_TRIANGLES);
}

static double parabola(int x, int y) { return .2 * x * x + 0 * y; }

/* Cubic B-splines reproduce parabolas: half way between corners h/2 apart one of height a x^2 lies a (h/4)^2 below
 * their mean. A sharp cube is flat. */
static void bends_are_where_the_surface_bends(void **state)
{
    (void)state;
    struct grid g;
    struct bends bends;
    char error[SCENE_ERROR];
    make_grid(&g, parabola);
    assert_true(bends_measure(&g.mesh, &bends, error));
    assert_int_equal(bends.count, 4 * GRID * GRID);
    int inside = 0;
    for (uint32_t i = 0; i < bends.count; i++) {
        const struct bend *bend = &bends.quads[i];
        float x = bend->middle[0], y = bend->middle[1];
        if (x < 2 || x > GRID - 2 || y < 2 || y > GRID - 2) continue;
        inside++;
        assert_float_equal(bend->depth, .2 / 16, 1e-6);
        assert_float_equal(bend->middle[2], .2 * x * x + .2 / 3, 1e-4);
    }
    assert_int_equal(inside, 4 * (GRID - 4) * (GRID - 4));
    bends_free(&bends);
    struct scene_mesh box = cube();
    box.crease_count = 12;
    box.crease_edges = cube_edges;
    box.crease_sharpness = sharp;
    assert_true(bends_measure(&box, &bends, error));
    for (uint32_t i = 0; i < bends.count; i++) assert_float_equal(bends.quads[i].depth, 0, 1e-7);
    bends_free(&bends);
    box.smooth = false;
    assert_true(bends_measure(&box, &bends, error));
    assert_int_equal(bends.count, 0);
}

/* Seen at 64 pixels a metre, a rounded cube of which the deepest bend is so many pixels. */
static void level_follows_the_bends(void **state)
{
    (void)state;
    struct scene_mesh box = cube();
    struct bends bends;
    char error[SCENE_ERROR];
    assert_true(bends_measure(&box, &bends, error));
    struct scene_camera camera = {
        .type = CAMERA_ORTHOGRAPHIC, .window = {-2, 2, -2, 2}, .width = 256, .height = 256};
    memcpy(camera.transform, identity, sizeof identity);
    camera.transform[11] = 9;
    double depth = 0;
    for (uint32_t i = 0; i < bends.count; i++) depth = fmax(depth, bends.quads[i].depth);
    int expected = 1 + (int)ceil(log2(depth * 64 / .1) / 2);
    assert_in_range(expected, 3, 6);
    assert_int_equal(level_by_bends(&box, &bends, identity, &camera, 9), expected);
    assert_int_equal(level_by_bends(&box, &bends, identity, &camera, 2), 2);
    float transform[12];
    memcpy(transform, identity, sizeof identity);
    transform[0] = transform[5] = transform[10] = 4;
    assert_int_equal(level_by_bends(&box, &bends, transform, &camera, 9), expected + 1);
    transform[0] = transform[5] = transform[10] = 1;
    transform[3] = 40; /* beside the picture */
    assert_int_equal(level_by_bends(&box, &bends, transform, &camera, 9), expected - 1);
    transform[3] = 0, transform[11] = 40; /* behind the camera */
    assert_int_equal(level_by_bends(&box, &bends, transform, &camera, 9), expected - 1);
    camera.type = CAMERA_PANORAMIC; /* sees all, from 31 away; a pixel is 1/64 */
    assert_int_equal(level_by_bends(&box, &bends, transform, &camera, 9),
                     1 + (int)fmax(0, ceil(log2(depth * 64 / 30 / .1) / 2)));
    bends_free(&bends);
    /* Creases of sharpness 5 are round from there on. */
    const float sharpness[12] = {5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5};
    box.crease_count = 12;
    box.crease_edges = cube_edges;
    box.crease_sharpness = sharpness;
    assert_true(bends_measure(&box, &bends, error));
    assert_int_equal(level_by_bends(&box, &bends, transform, &camera, 9), 7);
    assert_in_range(level_by_bends(&box, &bends, transform, &camera, 4), 1, 3); /* too small to be seen */
    bends_free(&bends);
}

static void too_much_is_an_error(void **state)
{
    (void)state;
    struct scene_mesh mesh = cube();
    struct triangles t;
    char error[SCENE_ERROR] = "";
    assert_false(tessellate(&mesh, 14, &t, error));
    assert_non_null(strstr(error, "mesh \"cube\""));
    assert_true(!t.positions && !t.indices && !t.triangle_count);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(polygons_share_what_agrees), cmocka_unit_test(odd_meshes_survive),
        cmocka_unit_test(level_counts_pixels),        cmocka_unit_test(level_has_a_bound),
        cmocka_unit_test(bends_are_where_the_surface_bends), cmocka_unit_test(level_follows_the_bends),
        cmocka_unit_test(too_much_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
