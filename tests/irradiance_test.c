/* SPDX-License-Identifier: Apache-2.0 */
/* Irradiance and its gradients, from samples of scenes whose form factors are known. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>

#include "eas/irradiance.h"
#include "render/rng.h"

/* What a ray from p along dir meets: its radiance, and how far it is. */
typedef rgb scene(float3 p, float3 dir, float *distance);

static struct irradiance gather(scene *radiance, float3 p, float3 n, int count)
{
    struct gather_grid grid = gather_grid(count);
    struct frame frame = frame_about(n);
    struct gather_sample *samples = calloc((size_t)(grid.rows * grid.columns), sizeof *samples);
    assert_non_null(samples);
    struct rng rng = rng_seed(7, 8, 9);
    for (int i = 0; i < grid.rows * grid.columns; i++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        float3 dir = to_world(frame, gather_direction(grid, i / grid.columns, i % grid.columns, u, v));
        struct gather_sample *s = &samples[i];
        *s = (struct gather_sample){.dir = dir, .omega = 2 * PI / (float)(grid.rows * grid.columns)};
        s->radiance = radiance(p, dir, &s->distance);
    }
    struct irradiance irradiance = irradiance_of(samples, grid, frame);
    free(samples);
    return irradiance;
}

static void assert_vector(float3 value, float3 exact, float tolerance)
{
    float off = length(sub(value, exact));
    if (!(off <= tolerance))
        fail_msg("(%g %g %g), expected (%g %g %g)", value.x, value.y, value.z, exact.x, exact.y, exact.z);
}

/* Strata: at least as many as asked, equal in solid angle, as wide as high within a factor. */
static void grid(void **state)
{
    (void)state;
    for (int count = 1; count < 3000; count += 97) {
        struct gather_grid g = gather_grid(count);
        assert_true(g.rows * g.columns >= count && g.rows >= 2);
        assert_true(count < 64 || g.rows * g.columns < 2 * count);
        for (int k = 0; k < 4; k++) {
            float u = .999f * (float)(k & 1), v = .999f * (float)(k >> 1);
            float3 d = gather_direction(g, g.rows - 1, g.columns / 4, u, v);
            assert_float_equal(length(d), 1, 1e-5f);
            assert_true(d.z >= 0 && d.z <= 1.001f / (float)g.rows);
            float phi = atan2f(d.y, d.x), width = 2 * PI / (float)g.columns;
            assert_true(phi >= PI / 2 - 1e-4f && phi <= PI / 2 + width);
        }
    }
}

static rgb even(float3 p, float3 dir, float *distance)
{
    (void)p, (void)dir;
    *distance = 2;
    return vec3(1, 2, .5f);
}

/* E = pi L; the vector irradiance is pi L n, so a surface turned by t receives pi L cos(t) of this hemisphere; nothing
 * moves. */
static void even_hemisphere(void **state)
{
    (void)state;
    float3 n = normalize(vec3(1, 2, -1)), t = frame_about(n).t;
    struct irradiance e = gather(even, vec3(0, 0, 0), n, 1024);
    assert_vector(e.e, scale(vec3(1, 2, .5f), PI), .01f);
    assert_vector(e.vector[1], scale(n, 2 * PI), .02f);
    for (int i = 0; i < 3; i++) assert_vector(e.translation[i], vec3(0, 0, 0), 1e-4f);
    rgb turned = irradiance_at(&e, vec3(0, 0, 0), n, vec3(0, 0, 0), add(scale(n, cosf(.3f)), scale(t, sinf(.3f))));
    assert_float_equal(turned.y, 2 * PI * cosf(.3f), .02f);
}

/* Half of a ball's inside lit, y > 0: the border at phi = 0 and that at pi each give the integral of d(sin theta). */
static rgb half(float3 p, float3 dir, float *distance)
{
    (void)p;
    *distance = 2;
    return dir.y > 0 ? vec3(1, 1, 1) : vec3(0, 0, 0);
}

static void borders(void **state)
{
    (void)state;
    struct irradiance e = gather(half, vec3(0, 0, 0), vec3(0, 0, 1), 256);
    assert_vector(e.translation[0], vec3(0, 2.0f / 2, 0), 1e-4f);
    assert_float_equal(e.e.x, PI / 2, .02f);
}

/* A wall of radiance 1, infinitely long, at x = 0 and up to z = 2; the rest is black and far. Hottel: E = pi/2 (1 -
 * x/sqrt(x^2 + 4)) at (x, y, 0). */
static rgb wall(float3 p, float3 dir, float *distance)
{
    float t = dir.x < 0 ? -p.x / dir.x : INFINITY;
    bool hit = p.z + t * dir.z <= 2;
    *distance = hit ? t : INFINITY;
    return hit ? vec3(1, 1, 1) : vec3(0, 0, 0);
}

static float wall_exact(float x) { return PI / 2 * (1 - x / sqrtf(x * x + 4)); }

/* An edge of strata moves at the nearer sample's distance, which is that of the object's edge to the first order of
 * their width: the slope errs by 40 %, 20 %, 10 % and 7 % with 256, 1024, 4096 and 16384 strata at x = .5. */
static void floor_near_wall(void **state)
{
    (void)state;
    const float xs[] = {.5f, 1, 3}, tolerances[] = {.09f, .05f, .03f};
    for (int i = 0; i < 3; i++) {
        float x = xs[i], slope = -PI / 2 * 4 / powf(x * x + 4, 1.5f);
        struct irradiance e = gather(wall, vec3(x, 1, 0), vec3(0, 0, 1), 16384);
        assert_float_equal(e.e.x / wall_exact(x), 1, .01f);
        assert_vector(e.translation[0], vec3(slope, 0, 0), tolerances[i] * fabsf(slope));
        /* A step of 10 % of the way to the wall, and along it. */
        rgb there = irradiance_at(&e, vec3(x, 1, 0), vec3(0, 0, 1), vec3(.9f * x, 1.3f, 0), vec3(0, 0, 1));
        assert_float_equal((there.x - e.e.x) / (wall_exact(.9f * x) - wall_exact(x)), 1, .15f);
        assert_float_equal(irradiance_reach(&e) * fabsf(slope) / e.e.x, 1, tolerances[i]);
    }
}

/* A disc of radius 1 at z = 1 about the axis, facing down. Beside the axis at r: E = pi L/2 (1 - (r^2 + h^2 - a^2) /
 * sqrt((r^2 + h^2 + a^2)^2 - 4 a^2 r^2)), h = a = 1. */
static bool meets_disc(float3 p, float3 dir, float *distance)
{
    float t = (1 - p.z) / dir.z;
    *distance = t;
    return dir.z > 0 && sqr(p.x + t * dir.x) + sqr(p.y + t * dir.y) < 1;
}

static float disc_factor(float r) { return .5f * (1 - r * r / sqrtf(sqr(r * r + 2) - 4 * r * r)); }

static float disc_slope(float r) { return (disc_factor(r + .01f) - disc_factor(r - .01f)) / .02f; }

static rgb disc(float3 p, float3 dir, float *distance)
{
    if (meets_disc(p, dir, distance)) return vec3(3, 0, 1);
    *distance = INFINITY;
    return vec3(0, 0, 0);
}

/* The same disc, black, before an even sky: the edge moves at the distance of the nearer. */
static rgb blocker(float3 p, float3 dir, float *distance)
{
    if (meets_disc(p, dir, distance)) return vec3(0, 0, 0);
    *distance = INFINITY;
    return vec3(2, 2, 2);
}

static void under_a_disc(void **state)
{
    (void)state;
    const float rs[] = {0, .4f, 1, 1.7f};
    for (int i = 0; i < 4; i++) {
        float r = rs[i], c = .6f, s = .8f; /* anywhere about the axis */
        float3 p = {r * c, r * s, 0}, slope = scale(vec3(c, s, 0), PI * disc_slope(r));
        struct irradiance lit = gather(disc, p, vec3(0, 0, 1), 4096), shaded = gather(blocker, p, vec3(0, 0, 1), 4096);
        assert_float_equal(lit.e.x, 3 * PI * disc_factor(r), .06f);
        assert_float_equal(lit.e.y, 0, 0);
        assert_float_equal(shaded.e.x, 2 * PI * (1 - disc_factor(r)), .06f);
        assert_vector(lit.translation[0], scale(slope, 3), .25f);
        assert_vector(lit.translation[1], vec3(0, 0, 0), 0);
        assert_vector(lit.translation[2], slope, .25f / 3);
        assert_vector(shaded.translation[0], scale(slope, -2), .25f * 2 / 3);
    }
}

/* Never negative: beyond the light that a gradient promises there is none. */
static void not_negative(void **state)
{
    (void)state;
    struct irradiance e = {{1, 1, 1}, {{0, 0, 0}}, {{-2, 0, 0}, {1, 0, 0}, {0, 0, 0}}};
    rgb there = irradiance_at(&e, vec3(0, 0, 0), vec3(0, 0, 1), vec3(3, 0, 0), vec3(0, 0, 1));
    assert_vector(there, vec3(0, 4, 1), 1e-6f);
}

/* Only channels that would change by more than themselves are flattened, and just so much. */
static void limit(void **state)
{
    (void)state;
    struct irradiance e = {{1, 2, 0}, {{0, 0, 0}}, {{3, 4, 0}, {0, 1, 0}, {1, 0, 0}}};
    irradiance_limit(&e, .5f);
    assert_vector(e.translation[0], vec3(1.2f, 1.6f, 0), 1e-6f);
    assert_vector(e.translation[1], vec3(0, 1, 0), 0);
    assert_vector(e.translation[2], vec3(0, 0, 0), 0);
    /* At the rim of the zone nothing is below 0 or over twice e then. */
    for (int i = 0; i < 12; i++) {
        float3 p = {.5f * cosf((float)i), .5f * sinf((float)i), 0};
        rgb there = irradiance_at(&e, vec3(0, 0, 0), vec3(0, 0, 1), p, vec3(0, 0, 1));
        assert_true(there.x >= 0 && there.x <= 2 && there.y >= 0 && there.y <= 4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(grid),         cmocka_unit_test(even_hemisphere),
                                       cmocka_unit_test(borders),      cmocka_unit_test(floor_near_wall),
                                       cmocka_unit_test(under_a_disc), cmocka_unit_test(not_negative),
                                       cmocka_unit_test(limit)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
