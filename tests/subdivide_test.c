/* SPDX-License-Identifier: Apache-2.0 */
/* Refined cages against what is known of the limit surface: masks by hand, B-splines, planes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/meshes.h"

/* A corner of the cube (valence n = 3) moves to (n^2 v + 4 sum e + sum f) / (n (n + 5)) = (9 + 4 - 1) / 24 = 1/2 on
 * each axis; the centre of a face, where the first step puts a vertex of valence 4 between edge points (3/4, 3/4, 0)
 * and vertex points 5/9, to (16 + 4 * 3 + 4 * 5/9) / 36 = 68/81. Halstead, Kass, DeRose 1993, section 3. */
static void cube_reaches_its_limit(void **state)
{
    (void)state;
    struct scene_mesh mesh = cube();
    for (int level = 0; level <= 5; level++) {
        struct triangles t = tessellated(&mesh, level);
        assert_int_equal(t.triangle_count, 12 << 2 * level);
        assert_int_equal(t.vertex_count, (6 << 2 * level) + 2); /* Euler */
        for (int k = 0; k < 8; k++) {
            const float *p = cube_positions + 3 * k;
            const float *n = t.normals + 3 * vertex_at(&t, .5 * p[0], .5 * p[1], .5 * p[2]);
            for (int axis = 0; axis < 3; axis++) assert_true(fabs(n[axis] - p[axis] / sqrt(3)) < 1e-6);
        }
        for (int k = 0; k < 6 && level > 0; k++) {
            double centre[3] = {0};
            centre[k / 2] = k % 2 ? 1 : -1;
            uint32_t i = vertex_at(&t, 68. / 81 * centre[0], 68. / 81 * centre[1], 68. / 81 * centre[2]);
            assert_true(dot(t.normals + 3 * i, centre) > 1 - 1e-6);
        }
        /* Outward, and near the facets' own. */
        for (uint32_t i = 0; i < t.triangle_count; i++) {
            double facet[3];
            triangle_area(&t, i, facet);
            assert_true(dot(t.positions + 3 * t.indices[3 * i], facet) > 0);
            assert_true(dot(t.normals + 3 * t.indices[3 * i], facet) > cos(2.5 / (1 << level)));
        }
        triangles_free(&t);
    }
}

/* Uniform cubic B-spline basis: value and derivative at t in [0, 1] of the span's four weights. */
static void b_spline(double t, double value[4], double slope[4])
{
    const double s = 1 - t;
    const double v[4] = {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
                         t * t * t / 6};
    const double d[4] = {-s * s / 2, (3 * t * t - 4 * t) / 2, (4 * s - 3 * s * s) / 2, t * t / 2};
    memcpy(value, v, sizeof v);
    memcpy(slope, d, sizeof d);
}

/* Inside a regular grid the limit surface is the bicubic B-spline of the heights, exact normals included; x and y,
 * being linear, and the UVs, where no boundary is in reach, stay as they are. */
static void grid_is_a_b_spline(void **state)
{
    (void)state;
    struct grid g;
    make_grid(&g, bumpy_height);
    for (int level = 0; level <= 4; level += 2) {
        struct triangles t = tessellated(&g.mesh, level);
        int checked = 0;
        for (uint32_t i = 0; i < t.vertex_count; i++) {
            const float *p = t.positions + 3 * i;
            if (p[0] < 2 || p[0] > GRID - 2 || p[1] < 2 || p[1] > GRID - 2) continue;
            int x = fmin(floor(p[0]), GRID - 3), y = fmin(floor(p[1]), GRID - 3);
            double bx[4], by[4], dx[4], dy[4], z = 0, zx = 0, zy = 0;
            b_spline(p[0] - x, bx, dx);
            b_spline(p[1] - y, by, dy);
            for (int k = 0; k < 16; k++) {
                double height = g.positions[3 * ((y - 1 + k / 4) * (GRID + 1) + x - 1 + k % 4) + 2];
                z += height * bx[k % 4] * by[k / 4];
                zx += height * dx[k % 4] * by[k / 4];
                zy += height * bx[k % 4] * dy[k / 4];
            }
            double length = sqrt(zx * zx + zy * zy + 1);
            assert_true(fabs(p[2] - z) < 2e-6);
            assert_true(dot(t.normals + 3 * i, (double[3]){-zx / length, -zy / length, 1 / length}) > 1 - 1e-6);
            assert_true(fabs(t.uvs[2 * i] - p[0] / GRID) < 1e-6 && fabs(t.uvs[2 * i + 1] - p[1] / GRID) < 1e-6);
            checked++;
        }
        assert_int_equal(checked, (((GRID - 4) << level) + 1) * (((GRID - 4) << level) + 1));
        triangles_free(&t);
    }
}

/* A sharp line across the grid, and its border, are cubic B-splines of their own vertices (x is linear inside). */
static void creases_are_b_spline_curves(void **state)
{
    (void)state;
    struct grid g;
    make_grid(&g, bumpy_height);
    uint32_t edges[2 * GRID];
    float sharpness[GRID];
    const int row = 3;
    for (int x = 0; x < GRID; x++) {
        edges[2 * x] = row * (GRID + 1) + x;
        edges[2 * x + 1] = row * (GRID + 1) + x + 1;
        sharpness[x] = 10;
    }
    g.mesh.crease_count = GRID;
    g.mesh.crease_edges = edges;
    g.mesh.crease_sharpness = sharpness;
    g.mesh.uvs = NULL;
    struct triangles t = tessellated(&g.mesh, 4);
    int on_crease = 0, on_border = 0;
    for (uint32_t i = 0; i < t.vertex_count; i++) {
        const float *p = t.positions + 3 * i;
        bool crease = fabs(p[1] - row) < 1e-6, border = fabs(p[1]) < 1e-6;
        if (!(crease || border) || p[0] < 1 || p[0] > GRID - 1) continue;
        int x = fmin(floor(p[0]), GRID - 2);
        double b[4], slope[4], z = 0;
        b_spline(p[0] - x, b, slope);
        for (int k = 0; k < 4; k++) z += b[k] * g.positions[3 * ((crease ? row : 0) * (GRID + 1) + x - 1 + k) + 2];
        if (crease && fabs(p[2] - z) > 2e-6) continue; /* another row may pass through this y */
        assert_true(fabs(p[2] - z) < 2e-6);
        on_crease += crease;
        on_border += border;
    }
    assert_int_equal(on_border, ((GRID - 2) << 4) + 1);
    assert_int_equal(on_crease, 2 * (((GRID - 2) << 4) + 1)); /* a vertex for each side's normal */
    triangles_free(&t);
}

static double roof_height(int x, int y) { return 0 * x + abs(y - GRID / 2); }

/* Two planes that meet in a crease stay planes, and the normals of each side hold up to it. */
static void crease_parts_the_normals(void **state)
{
    (void)state;
    struct grid g;
    make_grid(&g, roof_height);
    uint32_t edges[2 * GRID];
    for (int x = 0; x < GRID; x++) {
        edges[2 * x] = GRID / 2 * (GRID + 1) + x;
        edges[2 * x + 1] = edges[2 * x] + 1;
    }
    g.mesh.crease_count = GRID;
    g.mesh.crease_edges = edges;
    g.mesh.crease_sharpness = sharp;
    for (int with_uvs = 0; with_uvs < 2; with_uvs++) {
        g.mesh.uvs = with_uvs ? g.uvs : NULL;
        struct triangles t = tessellated(&g.mesh, 3);
        for (uint32_t i = 0; i < t.triangle_count; i++) {
            double facet[3];
            triangle_area(&t, i, facet);
            for (int k = 0; k < 3; k++) assert_true(dot(t.normals + 3 * t.indices[3 * i + k], facet) > 1 - 1e-6);
        }
        assert_int_equal(t.vertex_count, ((GRID << 3) + 1) * ((GRID << 3) + 2)); /* one row twice */
        triangles_free(&t);
    }
}

static void creased_cube_stays_a_cube(void **state)
{
    (void)state;
    for (int bilinear = 0; bilinear < 2; bilinear++)
        for (int level = 0; level < 4; level++) {
            struct scene_mesh mesh = cube();
            mesh.crease_count = 12;
            mesh.crease_edges = cube_edges;
            mesh.crease_sharpness = sharp;
            mesh.scheme = bilinear ? SUBDIVISION_BILINEAR : SUBDIVISION_CATMULL_CLARK;
            struct triangles t = tessellated(&mesh, level);
            assert_true(fabs(total_area(&t) - 24) < 1e-5);
            for (uint32_t i = 0; i < t.vertex_count; i++)
                assert_true(fabsf(fmaxf(fabsf(t.positions[3 * i]),
                                        fmaxf(fabsf(t.positions[3 * i + 1]), fabsf(t.positions[3 * i + 2]))) -
                                  1) < 1e-6f);
            for (uint32_t i = 0; i < 3 * t.triangle_count; i++) {
                double facet[3];
                triangle_area(&t, i / 3, facet);
                assert_true(dot(t.normals + 3 * t.indices[i], facet) > 1 - 1e-6);
            }
            int side = (1 << level) + 1;
            assert_int_equal(t.vertex_count, 6 * side * side);
            triangles_free(&t);
        }
    /* Without creases the bilinear scheme rounds nothing either; its shared vertices have the mean normal. */
    struct scene_mesh mesh = cube();
    mesh.scheme = SUBDIVISION_BILINEAR;
    struct triangles t = tessellated(&mesh, 3);
    assert_true(fabs(total_area(&t) - 24) < 1e-5);
    assert_int_equal(t.vertex_count, 6 * 64 + 2);
    const float *n = t.normals + 3 * vertex_at(&t, 1, 1, 1);
    assert_true(fabs(n[0] - 1 / sqrt(3)) < 1e-6 && fabs(n[1] - 1 / sqrt(3)) < 1e-6);
    triangles_free(&t);
}

/* A semi-sharp edge of the cube lies between the smooth and the sharp one; a corner's sharpness holds the corner. */
static void sharpness_is_gradual(void **state)
{
    (void)state;
    double before = -1;
    for (int k = 0; k <= 4; k++) {
        float sharpness[12];
        for (int i = 0; i < 12; i++) sharpness[i] = k;
        struct scene_mesh mesh = cube();
        mesh.crease_count = 12;
        mesh.crease_edges = cube_edges;
        mesh.crease_sharpness = sharpness;
        struct triangles t = tessellated(&mesh, 5);
        double area = total_area(&t);
        assert_true(area > before && area < 24);
        before = area;
        triangles_free(&t);
    }
    struct scene_mesh mesh = cube();
    const uint32_t corner = 6;
    mesh.sharp_corner_count = 1;
    mesh.corner_vertices = &corner;
    mesh.corner_sharpness = sharp;
    struct triangles t = tessellated(&mesh, 3);
    vertex_at(&t, 1, 1, 1);
    const float *n = t.normals + 3 * vertex_at(&t, 1, 1, 1);
    assert_true(fabs(n[0] - 1 / sqrt(3)) < 1e-5 && fabs(n[1] - 1 / sqrt(3)) < 1e-5); /* by symmetry */
    triangles_free(&t);
}

static void boundary_rules(void **state)
{
    (void)state;
    struct grid g;
    make_grid(&g, flat_height);
    g.mesh.uvs = NULL;
    g.mesh.boundary = BOUNDARY_EDGE_AND_CORNER;
    struct triangles t = tessellated(&g.mesh, 2);
    vertex_at(&t, 0, 0, 0);
    vertex_at(&t, GRID, GRID, 0);
    assert_true(fabs(total_area(&t) - GRID * GRID) < 1e-4);
    triangles_free(&t);
    /* Edge only: the corner goes to the B-spline of its two borders, (v + (e1 + e2)) / 6 with v = 4. */
    g.mesh.boundary = BOUNDARY_EDGE_ONLY;
    t = tessellated(&g.mesh, 2);
    vertex_at(&t, 1. / 6, 1. / 6, 0);
    assert_true(total_area(&t) < GRID * GRID - .05);
    for (uint32_t i = 0; i < t.vertex_count; i++) assert_true(t.normals[3 * i + 2] > 1 - 1e-6f);
    triangles_free(&t);
    /* The corner of the UVs goes with it where nothing holds it. */
    g.mesh.uvs = g.uvs;
    for (int rule = UV_BOUNDARY_NONE; rule <= UV_BOUNDARY_ALL; rule++) {
        g.mesh.uv_boundary = rule;
        t = tessellated(&g.mesh, 2);
        uint32_t corner = vertex_at(&t, 1. / 6, 1. / 6, 0);
        double expected = rule == UV_BOUNDARY_NONE ? 1. / 6 / GRID : 0;
        assert_true(fabs(t.uvs[2 * corner] - expected) < 1e-6 && fabs(t.uvs[2 * corner + 1] - expected) < 1e-6);
        triangles_free(&t);
    }
}

/* Each face of the cube has its own square of the picture: seams stay where they are, and across them only position and
 * normal are shared. */
static void uv_seams_are_kept(void **state)
{
    (void)state;
    float uvs[48];
    for (int i = 0; i < 24; i++) {
        uvs[2 * i] = i / 4 * 2 + (i % 4 == 1 || i % 4 == 2); /* next to the last face's */
        uvs[2 * i + 1] = i % 4 > 1;
    }
    struct scene_mesh mesh = cube();
    mesh.uvs = uvs;
    for (int rule = UV_BOUNDARY_CORNERS_ONLY; rule <= UV_BOUNDARY_ALL; rule++) {
        mesh.uv_boundary = rule;
        struct triangles t = tessellated(&mesh, 3);
        assert_int_equal(t.vertex_count, 6 * 9 * 9);
        double area = 0;
        for (uint32_t i = 0; i < t.triangle_count; i++) {
            const float *a = t.uvs + 2 * t.indices[3 * i], *b = t.uvs + 2 * t.indices[3 * i + 1];
            const float *c = t.uvs + 2 * t.indices[3 * i + 2];
            double part = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
            assert_true(part > 0);
            area += part;
        }
        assert_true(fabs(area - 6) < 1e-5);
        triangles_free(&t);
    }
}

/* Polygons in a cage: a prism of six sides, refined once at least; slots follow their faces. */
static void cages_of_polygons(void **state)
{
    (void)state;
    float positions[36];
    uint32_t sizes[8] = {6, 6, 4, 4, 4, 4, 4, 4}, corners[36], materials[8] = {5, 1, 2, 2, 2, 2, 2, 2};
    for (int i = 0; i < 12; i++) {
        positions[3 * i] = cos(i % 6 * M_PI / 3);
        positions[3 * i + 1] = sin(i % 6 * M_PI / 3);
        positions[3 * i + 2] = i / 6;
    }
    for (uint32_t i = 0; i < 6; i++) {
        corners[i] = 5 - i;
        corners[6 + i] = 6 + i;
        const uint32_t side[4] = {i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i};
        memcpy(corners + 12 + 4 * i, side, sizeof side);
    }
    struct scene_mesh mesh = {.name = "prism",
                              .vertex_count = 12,
                              .face_count = 8,
                              .corner_count = 36,
                              .positions = positions,
                              .face_sizes = sizes,
                              .corners = corners,
                              .face_materials = materials,
                              .subdivided = true,
                              .smooth = false,
                              .scheme = SUBDIVISION_BILINEAR};
    for (int level = 0; level < 3; level++) {
        struct triangles t = tessellated(&mesh, level);
        int refined = level > 1 ? level : 1;
        assert_int_equal(t.triangle_count, 2 * 36 << 2 * (refined - 1));
        double areas[6] = {0}, facet[3];
        for (uint32_t i = 0; i < t.triangle_count; i++) {
            areas[t.slots[i]] += triangle_area(&t, i, facet);
            for (int k = 0; k < 3; k++) assert_true(dot(t.normals + 3 * t.indices[3 * i + k], facet) > 1 - 1e-6);
        }
        assert_true(fabs(areas[5] - 1.5 * sqrt(3)) < 1e-5 && fabs(areas[1] - 1.5 * sqrt(3)) < 1e-5);
        assert_true(fabs(areas[2] - 6) < 1e-5);
        triangles_free(&t);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_reaches_its_limit),
        cmocka_unit_test(grid_is_a_b_spline),
        cmocka_unit_test(creases_are_b_spline_curves),
        cmocka_unit_test(crease_parts_the_normals),
        cmocka_unit_test(creased_cube_stays_a_cube),
        cmocka_unit_test(sharpness_is_gradual),
        cmocka_unit_test(boundary_rules),
        cmocka_unit_test(uv_seams_are_kept),
        cmocka_unit_test(cages_of_polygons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
