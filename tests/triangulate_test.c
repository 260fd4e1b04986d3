/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles of a simple polygon all turn the same way and their areas add up to its own. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "import/triangulate.h"

#define SIZE_MAX_TEST 400
#define LENGTH(a) (sizeof(a) / sizeof(a)[0])

static double area2(const double *a, const double *b, const double *c)
{
    return ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
}

/* Puts a plane polygon into space, turned so that its normal is (x, y, z), and cuts it. */
static void cut_in_plane(const double (*polygon)[2], uint32_t size, const double normal[3], uint32_t *triangles)
{
    float positions[3 * SIZE_MAX_TEST];
    uint32_t corners[SIZE_MAX_TEST];
    double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    double n[3] = {normal[0] / length, normal[1] / length, normal[2] / length};
    double helper[3] = {fabs(n[0]) < .5, fabs(n[0]) >= .5, 0};
    double u[3] = {helper[1] * n[2], -helper[0] * n[2], helper[0] * n[1] - helper[1] * n[0]};
    length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    for (int i = 0; i < 3; i++) u[i] /= length;
    double v[3] = {n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]};
    for (uint32_t i = 0; i < size; i++) {
        corners[i] = size - 1 - i; /* vertex numbers differ from corner numbers */
        for (int axis = 0; axis < 3; axis++)
            positions[3 * corners[i] + axis] = (float)(polygon[i][0] * u[axis] + polygon[i][1] * v[axis] + n[axis]);
    }
    assert_true(triangulate_polygon(positions, corners, size, triangles));
}

/* Cuts the polygon in several planes; each corner is in a triangle, none is turned over, the area is kept. */
static void check_polygon(const double (*polygon)[2], uint32_t size)
{
    static const double normals[][3] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {1, 2, -3}, {-5, 1, 4}};
    double area = 0;
    for (uint32_t i = 0; i < size; i++) area += area2((double[2]){0, 0}, polygon[i], polygon[(i + 1) % size]);
    assert_true(area > 0);
    for (size_t k = 0; k < LENGTH(normals); k++) {
        uint32_t triangles[3 * SIZE_MAX_TEST];
        int uses[SIZE_MAX_TEST] = {0};
        cut_in_plane(polygon, size, normals[k], triangles);
        double sum = 0;
        for (uint32_t i = 0; i < 3 * (size - 2); i += 3) {
            double part = area2(polygon[triangles[i]], polygon[triangles[i + 1]], polygon[triangles[i + 2]]);
            assert_true(part > -1e-9 * area);
            sum += part;
            for (int j = 0; j < 3; j++) uses[triangles[i + j]]++;
        }
        assert_true(fabs(sum - area) < 1e-9 * area);
        for (uint32_t i = 0; i < size; i++) assert_true(uses[i] > 0);
    }
}

static void convex_and_concave_quads(void **state)
{
    (void)state;
    uint32_t triangles[6];
    const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    check_polygon(square, 4);
    cut_in_plane(square, 4, (double[3]){0, 0, 1}, triangles);
    const uint32_t along02[6] = {0, 1, 2, 0, 2, 3};
    assert_memory_equal(triangles, along02, sizeof along02);
    /* A dart: only the diagonal from its notch lies inside. */
    for (int notch = 0; notch < 4; notch++) {
        const double dart[4][2] = {{.2, .2}, {2, 0}, {3, 3}, {0, 2}};
        double turned[4][2];
        for (int i = 0; i < 4; i++) {
            turned[(i + notch) % 4][0] = i ? dart[i][0] : 1.2;
            turned[(i + notch) % 4][1] = i ? dart[i][1] : 1.2;
        }
        check_polygon(turned, 4);
    }
}

static void stars_combs_and_spirals(void **state)
{
    (void)state;
    double polygon[SIZE_MAX_TEST][2];
    const double pi = acos(-1);
    for (uint32_t size = 5; size <= 101; size += 3) {
        for (uint32_t i = 0; i < size; i++) {
            double radius = i % 2 ? .2 : 1;
            polygon[i][0] = radius * cos(2 * pi * i / size);
            polygon[i][1] = radius * sin(2 * pi * i / size);
        }
        check_polygon(polygon, size);
    }
    /* A comb of 20 teeth. */
    uint32_t size = 0;
    for (int i = 0; i < 20; i++) {
        polygon[size][0] = i, polygon[size++][1] = 0;
        polygon[size][0] = i + .4, polygon[size++][1] = -5;
    }
    polygon[size][0] = 20, polygon[size++][1] = 0;
    polygon[size][0] = 20, polygon[size++][1] = 1;
    polygon[size][0] = 0, polygon[size++][1] = 1;
    check_polygon(polygon, size);
    /* A spiral of three turns, out and back in. */
    size = 0;
    for (int i = 0; i <= 60; i++, size++)
        polygon[size][0] = (1 + .1 * i) * cos(.3 * i), polygon[size][1] = (1 + .1 * i) * sin(.3 * i);
    for (int i = 60; i >= 0; i--, size++)
        polygon[size][0] = (.7 + .1 * i) * cos(.3 * i), polygon[size][1] = (.7 + .1 * i) * sin(.3 * i);
    check_polygon(polygon, size);
}

/* Radii at random about a centre. */
static void random_polygons(void **state)
{
    (void)state;
    double polygon[SIZE_MAX_TEST][2];
    srand(7);
    for (int k = 0; k < 300; k++) {
        uint32_t size = 5 + rand() % 40;
        for (uint32_t i = 0; i < size; i++) {
            double angle = 2 * acos(-1) * i / size, radius = .05 + (double)rand() / RAND_MAX;
            polygon[i][0] = (float)(radius * cos(angle));
            polygon[i][1] = (float)(radius * sin(angle));
        }
        check_polygon(polygon, size);
    }
}

/* Corners in a row, and a hole that a slit joins to the border, so that two corners are twice in the same place. */
static void rows_and_slits(void **state)
{
    (void)state;
    const double row[7][2] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {1, 1}, {0, 1}};
    check_polygon(row, 7);
    const double ring[10][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
    check_polygon(ring, 10);
    const double hole[8][2] = {{0, 0}, {4, 0}, {2, 4}, {0, 0}, {1.8, 1}, {2, 1.4}, {2.2, 1}, {1.8, 1}};
    check_polygon(hole, 8);
}

static void degenerate_polygons_survive(void **state)
{
    (void)state;
    for (uint32_t size = 3; size < 12; size++) {
        float positions[36] = {0};
        uint32_t corners[12], triangles[30];
        for (int kind = 0; kind < 3; kind++) {
            for (uint32_t i = 0; i < size; i++) {
                corners[i] = i;
                positions[3 * i] = kind == 0   ? 1
                                   : kind == 1 ? (float)i
                                               : (float)(i % 2); /* a point, a line, a zigzag */
                positions[3 * i + 1] = kind == 2 ? (float)((i * i) % 3) : 0;
            }
            assert_true(triangulate_polygon(positions, corners, size, triangles));
            for (uint32_t i = 0; i < 3 * (size - 2); i += 3) {
                assert_true(triangles[i] < size && triangles[i + 1] < size && triangles[i + 2] < size);
                assert_true(triangles[i] != triangles[i + 1] && triangles[i + 1] != triangles[i + 2]);
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(convex_and_concave_quads),
        cmocka_unit_test(stars_combs_and_spirals),
        cmocka_unit_test(random_polygons),
        cmocka_unit_test(rows_and_slits),
        cmocka_unit_test(degenerate_polygons_survive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
