/* SPDX-License-Identifier: Apache-2.0 */
#include "render/solid_angle.h"

/* Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983; from the edges, so that narrow ones keep
 * their digits. */
float solid_angle(const struct seen_triangle *t)
{
    float3 a = t->a, b = add(a, t->ab), c = add(a, t->ac);
    float x = length(a), y = length(b), z = length(c);
    float sine = fabsf(dot(a, cross(t->ab, t->ac))),
          cosine = x * y * z + dot(a, b) * z + dot(a, c) * y + dot(b, c) * x;
    return sine > 0 ? 2 * atan2f(sine, cosine) : 0;
}

/* The unit tangent at `from` of the arc to `to`, both unit. */
static float3 tangent(float3 from, float3 to)
{
    float3 d = sub(to, from);
    return normalize(mad(d, from, dot(d, d) / 2)); /* to - (to . from) from, near by too */
}

/* Arvo, "Stratified Sampling of Spherical Triangles", 1995: u[0] moves the corner c along its side until the triangle
 * has that share of the solid angle, u[1] goes from b toward it. The side b' of a triangle with the excess E, the side
 * c and the angle alpha between them is here by tan(b'/2) = sin(E/2) / (tan(c/2) sin(alpha - E/2)), which is exact for
 * small ones, too. */
float2 solid_angle_place(const struct seen_triangle *t, float omega, const float u[static 2])
{
    float3 a = normalize(t->a), b = normalize(add(t->a, t->ab)), c = normalize(add(t->a, t->ac));
    float3 to_b = tangent(a, b), to_c = tangent(a, c);
    float half = u[0] * omega / 2, s = sinf(half);
    float turned = length(cross(to_b, to_c)) * cosf(half) - dot(to_b, to_c) * s;
    float3 chord = sub(b, a), middle = add(b, a);
    float tan_half = s / maxf(sqrtf(dot(chord, chord) / maxf(dot(middle, middle), 1e-30f)) * turned, 1e-30f);
    float cosine = 2 / (1 + sqr(tan_half)) - 1, sine = 2 * tan_half / (1 + sqr(tan_half));
    float3 moved = mad(scale(a, cosine), to_c, sine), d = sub(moved, b);
    float height = u[1] * dot(d, d) / 2; /* 1 - cosine from b */
    float3 wi = mad(scale(b, 1 - height), tangent(b, moved), sqrtf(maxf(height * (2 - height), 0)));

    /* Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997; rounding may lead outside. */
    float3 from = scale(t->a, -1), p = cross(wi, t->ac), q = cross(from, t->ab);
    float det = dot(t->ab, p), x = det != 0 ? clampf(dot(from, p) / det, 0, 1) : 0;
    return (float2){x, det != 0 ? clampf(dot(wi, q) / det, 0, 1 - x) : 0};
}
