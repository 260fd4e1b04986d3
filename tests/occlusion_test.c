/* SPDX-License-Identifier: Apache-2.0 */
/* The visibility gradient of surfaces whose edges are known. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "eas/occlusion.h"
#include "render/rng.h"

enum { MOST = 5000 };

/* A plane p.normal = height about the origin; it ends where p.end > 0, if end isn't 0. */
struct plane {
    float3 normal;
    float height;
    float3 end;
};

static float plane_distance(const struct plane *plane, float3 dir)
{
    float slope = dot(dir, plane->normal), t = plane->height / slope;
    return t > 0 && dot(scale(dir, t), plane->end) <= 0 ? t : INFINITY;
}

/* What a step uncovers behind edges, sr/m, seen from the origin with z up: the sum over strata. */
static float3 uncovered(const struct plane *planes, int count, int rays, float turn)
{
    static struct gather_sample samples[MOST];
    static struct occlusion occlusions[MOST];
    struct gather_grid grid = gather_grid(rays);
    struct frame frame = {vec3(cosf(turn), sinf(turn), 0), vec3(-sinf(turn), cosf(turn), 0), vec3(0, 0, 1)};
    struct rng rng = rng_seed(1, 2, 3);
    int strata = grid.rows * grid.columns;
    float omega = 2 * PI / (float)strata;
    assert_true(strata <= MOST);
    for (int i = 0; i < strata; i++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        float3 dir = to_world(frame, gather_direction(grid, i / grid.columns, i % grid.columns, u, v));
        samples[i] = (struct gather_sample){.dir = dir, .distance = INFINITY, .omega = omega};
        for (int k = 0; k < count; k++) {
            float t = plane_distance(&planes[k], dir);
            if (t >= samples[i].distance) continue;
            samples[i].distance = t;
            samples[i].normal = scale(planes[k].normal, -1);
        }
    }
    occlusion_of(samples, grid, frame, occlusions);
    float3 sum = {0};
    for (int i = 0; i < strata; i++)
        sum = mad(sum, occlusion_uncovered(&occlusions[i], samples[i].distance, omega), omega);
    return sum;
}

/* A roof at height 1 that ends at x = 0 under a ceiling at height h: along the edge, theta from the zenith, roof and
 * ceiling are 1/cos(theta) and h/cos(theta) away, and a step along x uncovers the integral of cos(theta) (1 - 1/h) from
 * -90 to 90 degrees: 2 (1 - 1/h) sr/m; all other steps nothing. However the grid lies. */
static void roof(void **state)
{
    (void)state;
    const float heights[] = {2, 5, INFINITY};
    for (int k = 0; k < 3; k++)
        for (int j = 0; j < 6; j++) {
            struct plane planes[] = {{vec3(0, 0, 1), 1, vec3(1, 0, 0)}, {vec3(0, 0, 1), heights[k], vec3(0, 0, 0)}};
            float3 u = uncovered(planes, isinf(heights[k]) ? 1 : 2, 4000, .3f * (float)j);
            float exact = 2 * (1 - 1 / heights[k]);
            assert_float_equal(u.x / exact, 1, .12f);
            assert_float_equal(u.y / exact, 0, .05f);
        }
}

/* Walls that meet in corners, seen from inside, and a ship's keel, seen from below, hide nothing, whatever their
 * distances and wherever the rays fall. */
static void no_edges(void **state)
{
    (void)state;
    const float3 none = {0, 0, 0};
    const struct plane corner[] = {{vec3(1, 0, 0), 1, none},
                                   {vec3(0, 1, 0), .4f, none},
                                   {vec3(0, 0, 1), 2, none},
                                   {vec3(-1, 0, 0), .1f, none},
                                   {vec3(0, -1, 0), 3, none}};
    for (int j = 0; j < 6; j++) assert_true(length(uncovered(corner, 5, 1000, .3f * (float)j)) < 1e-6f);
    const float3 left = vec3(.5f, 0, 1), right = vec3(-.5f, 0, 1);
    const float height = 1 / sqrtf(1.25f);
    const struct plane keel[] = {{normalize(left), height, vec3(1, 0, 0)}, {normalize(right), height, vec3(-1, 0, 0)}};
    /* Along the keel, where the sides end at infinity, strata are too coarse: 1 % of what the roof's edge uncovers. */
    for (int j = 0; j < 6; j++) assert_true(length(uncovered(keel, 2, 4000, .3f * (float)j)) < .02f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(roof), cmocka_unit_test(no_edges)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
