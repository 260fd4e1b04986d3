/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles by solid angle: closed forms, and what places spread over one bring. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "render/solid_angle.h"

static float3 corner(const struct seen_triangle *t, int i)
{
    return i == 0 ? t->a : add(t->a, i == 1 ? t->ab : t->ac);
}

/* The integral of the direction over a triangle (Lambert 1760): half of each side's angle along its plane's normal. */
static float3 vector_irradiance(const struct seen_triangle *t)
{
    float3 sum = {0, 0, 0}, across = cross(t->ab, t->ac);
    for (int i = 0; i < 3; i++) {
        float3 a = normalize(corner(t, i)), b = normalize(corner(t, (i + 1) % 3)), n = cross(a, b);
        sum = mad(sum, normalize(n), atan2f(length(n), dot(a, b)) / 2);
    }
    return scale(sum, dot(across, t->a) > 0 ? 1 : -1);
}

/* An octant of the sphere; the faces of a cube, two triangles each, from anywhere in it. */
static void closed_forms(void **state)
{
    (void)state;
    assert_float_equal(solid_angle(&(struct seen_triangle){{1, 0, 0}, {-1, 1, 0}, {-1, 0, 1}}), PI / 2, 1e-5f);
    assert_true(solid_angle(&(struct seen_triangle){{1, 0, 0}, {1, 0, 0}, {0, 1, 0}}) == 0); /* seen edge on */
    const float3 at = {.3f, -.9f, .999f};
    float sum = 0;
    for (int face = 0; face < 12; face++) {
        float x[3] = {0, 0, 0}, u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
        float sign = face & 1 ? 1 : -1, half = face & 2 ? 1 : -1;
        int axis = face / 4;
        x[axis] = sign;
        x[(axis + 1) % 3] = x[(axis + 2) % 3] = half;
        u[(axis + 1) % 3] = v[(axis + 2) % 3] = -2 * half;
        sum += solid_angle(&(struct seen_triangle){sub(vec_from(x), at), vec_from(u), vec_from(v)});
    }
    assert_float_equal(sum, 4 * PI, 1e-4f);
}

/* Places on triangles of all kinds: large, narrow, far, seen from within 1e-3 of their plane. Their directions' mean
 * times the solid angle is the vector irradiance; each corner's half-sized triangle has its share of them. */
static void places(void **state)
{
    (void)state;
    static const struct seen_triangle triangles[] = {{{1, 0, 0}, {-1, 1, 0}, {-1, 0, 1}},
                                                     {{-2, -1, .01f}, {5, 0, 0}, {0, 5, 0}},
                                                     {{.01f, -.5f, 1e-3f}, {0, 1, 0}, {1, 0, 0}},
                                                     {{.3f, .2f, .1f}, {10, 0, 0}, {10, .02f, 0}},
                                                     {{20, 30, 40}, {1, 0, 0}, {0, 1, 1}}};
    enum { SIDE = 256 };
    for (int k = 0; k < 5; k++) {
        const struct seen_triangle *t = &triangles[k];
        float omega = solid_angle(t);
        double x = 0, y = 0, z = 0;
        int inside[3] = {0, 0, 0};
        for (int i = 0; i < SIDE * SIDE; i++) {
            float u[2] = {((float)(i % SIDE) + .5f) / SIDE, ((float)(i / SIDE) + .5f) / SIDE};
            float2 place = solid_angle_place(t, omega, u);
            float3 wi = normalize(mad(mad(t->a, t->ab, place.x), t->ac, place.y));
            assert_true(place.x >= 0 && place.y >= 0 && place.x + place.y <= 1.00001f);
            inside[0] += place.x + place.y < .5f;
            inside[1] += place.x > .5f;
            inside[2] += place.y > .5f;
            x += wi.x;
            y += wi.y;
            z += wi.z;
        }
        float share = omega / (SIDE * SIDE);
        float3 mean = {(float)x * share, (float)y * share, (float)z * share};
        float3 truth = vector_irradiance(t);
        assert_true(length(sub(mean, truth)) < 1e-3f * length(truth));
        for (int i = 0; i < 3; i++) {
            struct seen_triangle half = {t->a, scale(t->ab, .5f), scale(t->ac, .5f)};
            if (i > 0) half.a = add(half.a, i == 1 ? half.ab : half.ac);
            assert_float_equal((float)inside[i] / (SIDE * SIDE), solid_angle(&half) / omega, 2e-3f);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(closed_forms), cmocka_unit_test(places)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
