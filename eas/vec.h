/* SPDX-License-Identifier: Apache-2.0 */
/* Three floats by value: a point or vector (float3) or a colour (rgb, linear Rec. 709); an orthonormal frame; a cap. */
#ifndef EAS_VEC_H
#define EAS_VEC_H

#include <math.h>
#include <stdbool.h>

#define PI 3.14159265358979323846f

typedef struct {
    float x, y;
} float2;
typedef struct {
    float x, y, z;
} float3;
typedef float3 rgb;

/* Not fmaxf: without -ffinite-math-only that is a call. The second wins where the first is no number. */
static inline float maxf(float a, float b) { return a > b ? a : b; }
static inline float minf(float a, float b) { return a < b ? a : b; }
static inline float3 vec3(float x, float y, float z) { return (float3){x, y, z}; }
static inline float3 vec_from(const float v[3]) { return (float3){v[0], v[1], v[2]}; }
static inline float3 add(float3 a, float3 b) { return (float3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline float3 sub(float3 a, float3 b) { return (float3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline float3 mul(float3 a, float3 b) { return (float3){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline float3 scale(float3 a, float s) { return (float3){a.x * s, a.y * s, a.z * s}; }
/* a + b s */
static inline float3 mad(float3 a, float3 b, float s) { return (float3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s}; }
static inline float3 lerp3(float3 a, float3 b, float t) { return mad(scale(a, 1 - t), b, t); }
static inline float dot(float3 a, float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline float3 cross(float3 a, float3 b)
{
    return (float3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline float length(float3 a) { return sqrtf(dot(a, a)); }
static inline float3 normalize(float3 a) { return scale(a, 1 / sqrtf(maxf(dot(a, a), 1e-38f))); }
/* The mirror direction of w about the unit normal n, both leaving the surface. */
static inline float3 reflect(float3 w, float3 n) { return mad(scale(w, -1), n, 2 * dot(w, n)); }
static inline float clampf(float x, float lo, float hi) { return x < lo ? lo : x > hi ? hi : x; }
static inline float sqr(float x) { return x * x; }

static inline float max3(rgb c) { return maxf(c.x, maxf(c.y, c.z)); }
static inline bool is_black(rgb c) { return c.x == 0 && c.y == 0 && c.z == 0; }
/* Y of linear Rec. 709 */
static inline float luminance(rgb c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

/* A right-handed orthonormal frame about n (unit). */
struct frame {
    float3 t, b, n;
};

/* Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017. */
static inline struct frame frame_about(float3 n)
{
    float sign = copysignf(1.0f, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    return (struct frame){{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}
static inline float3 to_world(struct frame f, float3 v) { return mad(mad(scale(f.t, v.x), f.b, v.y), f.n, v.z); }
static inline float3 to_local(struct frame f, float3 v) { return (float3){dot(f.t, v), dot(f.b, v), dot(f.n, v)}; }

/* A spherical cap: unit axis, solid angle in sr (0 … 2 pi). */
struct cap {
    float3 axis;
    float omega;
};

/* A direction about n with density cos/pi; u: two numbers in [0, 1). */
static inline float3 cosine_direction(float3 n, const float u[2])
{
    float r = sqrtf(u[0]), phi = 2 * PI * u[1];
    return to_world(frame_about(n), vec3(r * cosf(phi), r * sinf(phi), sqrtf(1 - u[0])));
}

#endif
