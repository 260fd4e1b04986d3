/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes for tests, and what holds for all triangles. Include after cmocka.h. */
#ifndef TESTS_MESHES_H
#define TESTS_MESHES_H

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "import/tessellate.h"

#define GRID 8 /* faces a side */

static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/* The cube [-1, 1]^3, faces counter-clockwise from outside. */
static const float cube_positions[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                                         -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};
static const uint32_t cube_sizes[6] = {4, 4, 4, 4, 4, 4};
static const uint32_t cube_corners[24] = {3, 2, 1, 0, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
static const uint32_t cube_edges[24] = {0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 0, 4, 1, 5, 2, 6, 3, 7};
static const float sharp[12] = {10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10};

static inline struct scene_mesh cube(void)
{
    return (struct scene_mesh){.name = "cube",
                               .vertex_count = 8,
                               .face_count = 6,
                               .corner_count = 24,
                               .positions = cube_positions,
                               .face_sizes = cube_sizes,
                               .corners = cube_corners,
                               .subdivided = true,
                               .smooth = true};
}

/* A grid of unit squares over [0, GRID]^2 with heights; uv = (x, y) / GRID. */
struct grid {
    float positions[3 * (GRID + 1) * (GRID + 1)], uvs[8 * GRID * GRID], normals[12 * GRID * GRID];
    uint32_t sizes[GRID * GRID], corners[4 * GRID * GRID];
    struct scene_mesh mesh;
};

static inline void make_grid(struct grid *g, double height(int x, int y))
{
    for (int y = 0, v = 0; y <= GRID; y++)
        for (int x = 0; x <= GRID; x++, v++) {
            const float p[3] = {x, y, height(x, y)};
            memcpy(g->positions + 3 * v, p, sizeof p);
        }
    for (int y = 0, f = 0; y < GRID; y++)
        for (int x = 0; x < GRID; x++, f++) {
            g->sizes[f] = 4;
            for (int i = 0; i < 4; i++) {
                int cx = x + (i == 1 || i == 2), cy = y + (i > 1);
                g->corners[4 * f + i] = cy * (GRID + 1) + cx;
                g->uvs[8 * f + 2 * i] = (float)cx / GRID;
                g->uvs[8 * f + 2 * i + 1] = (float)cy / GRID;
                memcpy(g->normals + 12 * f + 3 * i, (float[3]){0, 0, 2}, 3 * sizeof(float));
            }
        }
    g->mesh = (struct scene_mesh){.name = "grid",
                                  .vertex_count = (GRID + 1) * (GRID + 1),
                                  .face_count = GRID * GRID,
                                  .corner_count = 4 * GRID * GRID,
                                  .positions = g->positions,
                                  .face_sizes = g->sizes,
                                  .corners = g->corners,
                                  .uvs = g->uvs,
                                  .subdivided = true,
                                  .smooth = true};
}

static inline double flat_height(int x, int y) { return 0 * (x + y); }
static inline double bumpy_height(int x, int y) { return ((x * 7 + y * 13 + x * y * 5) % 11) / 8.; }

static inline double triangle_area(const struct triangles *t, uint32_t i, double normal[3])
{
    const float *p[3];
    double u[3], v[3];
    for (int k = 0; k < 3; k++) p[k] = t->positions + 3 * (size_t)t->indices[3 * i + k];
    for (int k = 0; k < 3; k++) {
        u[k] = (double)p[1][k] - p[0][k];
        v[k] = (double)p[2][k] - p[0][k];
    }
    for (int k = 0; k < 3; k++) normal[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int k = 0; k < 3 && length > 0; k++) normal[k] /= length;
    return length / 2;
}

static inline double dot(const float *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Tessellates; normals are finite and of length 1, indices in range. */
static inline struct triangles tessellated(const struct scene_mesh *mesh, int level)
{
    struct triangles t;
    char error[SCENE_ERROR];
    if (!tessellate(mesh, level, &t, error)) fail_msg("%s", error);
    assert_true(!t.uvs == !mesh->uvs);
    for (uint32_t i = 0; i < 3 * t.triangle_count; i++) assert_true(t.indices[i] < t.vertex_count);
    for (uint32_t i = 0; i < t.vertex_count; i++) {
        const float *n = t.normals + 3 * i;
        assert_true(fabs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.) < 1e-5);
        for (int k = 0; k < 3; k++) assert_true(isfinite(t.positions[3 * i + k]));
        for (int k = 0; t.uvs && k < 2; k++) assert_true(isfinite(t.uvs[2 * i + k]));
    }
    return t;
}

static inline double total_area(const struct triangles *t)
{
    double sum = 0, normal[3];
    for (uint32_t i = 0; i < t->triangle_count; i++) sum += triangle_area(t, i, normal);
    return sum;
}

/* The vertex at a place, whose distance must be below 1e-6. */
static inline uint32_t vertex_at(const struct triangles *t, double x, double y, double z)
{
    for (uint32_t i = 0; i < t->vertex_count; i++) {
        const float *p = t->positions + 3 * i;
        if (fabs(p[0] - x) < 1e-6 && fabs(p[1] - y) < 1e-6 && fabs(p[2] - z) < 1e-6) return i;
    }
    fail_msg("no vertex at (%g, %g, %g)", x, y, z);
    return 0;
}

#endif
