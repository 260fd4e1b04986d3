/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/mean_brdf.h"

#include <stdlib.h>

#include "eas/ggx.h"

typedef float float4 __attribute__((vector_size(16)));

enum { SPANS = 8, CAPS = 56, OFFSETS = 48, RINGS = 24 };

/* A lobe reaches this many sigmas: exp(-4^2/2) = 3e-4 of its peak. */
#define REACH 4.0f
/* Cap radii u are tabulated over u/(CAP_KNEE + u). */
#define CAP_KNEE 1.2f
/* Below the horizon the cosine of f cos is negative. The part of a cap there is let be where it counts for little:
 * where the sine of the axis' elevation is over sqrt(CLEAR) of the radius' sine; sqrt(CLEAR_HIGH) of it where R is HIGH
 * sigmas up; 0 where the sine of R's elevation is over TOP; and everywhere where the lobe doesn't reach down. */
#define CLEAR .64f
#define CLEAR_HIGH .04f
#define HIGH 2.5f
#define TOP .87f

/* Modified Phong over a cap, mirror direction R, normal N:
 *     integral of f cos = (n+2)/2pi N . integral of cos^n(alpha) w dw = u^2/(CAP_KNEE + u)^2 (P N.R + Q N.axis).
 * P and Q, of order 1, depend on three numbers. Lengths are chords (no arc functions), in sigmas; sigma^2 = 1/(n+1).
 *     sigma^2: linear between the ends of SPANS spans; both ends of a span are in one texel, as P Q P Q;
 *     u: the cap's radius;
 *     v: the axis from R, from where the cap holds all of the lobe to where it holds none. */
struct mean_brdf {
    float4 table[SPANS][CAPS][OFFSETS];
};

static inline float variance(float exponent) { return 1 / (exponent + 1); }
static inline float span_end(int i) { return sqr((float)i / SPANS); }

/* max(x, 0) without the branch that compilers make of it: it would be mispredicted. */
static inline float positive(float x) { return .5f * (x + fabsf(x)); }
/* Where the offsets of a cap begin; they end at u + REACH. */
static inline float first_offset(float u) { return positive(u - REACH); }

/* The integral of cos^n(alpha) w over a cap of half-angle theta at delta from R, as p R + q axis: from rings alpha
 * about R, of which the cap holds the azimuths |phi| < phi(alpha). Midpoints in a variable that flattens the
 * square-root ends of phi(alpha). */
static void integrate_cap(double exponent, double theta, double delta, double *p, double *q)
{
    double first = fabs(delta - theta), last = fmin(fmin(delta + theta, PI / 2), first + 4.8 / sqrt(exponent + 1));
    double along = 0, across = 0; /* along R; at right angles to it, to the axis */
    if (delta < theta) along = 2 * PI / (exponent + 2) * (1 - pow(cos(fmin(first, PI / 2)), exponent + 2));
    for (int i = 0; i < RINGS && first < last; i++) {
        double s = PI * (i + .5) / RINGS, alpha = first + (last - first) * .5 * (1 - cos(s));
        double c = cos(alpha), sine = sin(alpha), cos_phi = (cos(theta) - c * cos(delta)) / (sine * sin(delta));
        double weight = (last - first) * .5 * PI / RINGS * sin(s) * pow(c, exponent) * sine;
        cos_phi = fmax(-1, fmin(1, cos_phi));
        along += 2 * acos(cos_phi) * c * weight;
        across += 2 * sqrt(1 - cos_phi * cos_phi) * sine * weight;
    }
    *q = across / sin(delta);
    *p = fmax(along - cos(delta) * *q, 0);
}

static void fill_span_end(struct mean_brdf *tables, int i)
{
    double width = sqrt(fmax(span_end(i), 1e-8)), exponent = 1 / (width * width) - 1;
    for (int j = 0; j < CAPS; j++) {
        double y = fmax(1e-3, fmin((double)j / (CAPS - 1), .99)), u = fmin(CAP_KNEE * y / (1 - y), sqrt(2) / width);
        double peak = (exponent + 2) / (2 * PI * y * y);
        for (int k = 0; k < OFFSETS; k++) {
            double first = first_offset((float)u), v = first + (REACH + u - first) * k / (OFFSETS - 1), p, q;
            integrate_cap(exponent, 2 * asin(u * width / 2), 2 * asin(fmin(fmax(v, 1e-3) * width / 2, 1)), &p, &q);
            for (int end = 0; end < 2; end++)
                if (i - end >= 0 && i - end < SPANS) {
                    tables->table[i - end][j][k][2 * end] = (float)(p * peak);
                    tables->table[i - end][j][k][2 * end + 1] = (float)(q * peak);
                }
        }
    }
}

struct mean_brdf *mean_brdf_build(void)
{
    struct mean_brdf *tables = malloc(sizeof *tables);
    for (int i = 0; tables && i <= SPANS; i++) fill_span_end(tables, i);
    return tables;
}

void mean_brdf_free(struct mean_brdf *tables) { free(tables); }

struct mean_lobe mean_lobe(const struct mean_brdf *tables, const struct lobe *lobe, float3 n, float3 wo)
{
    struct mean_lobe m = {.lobe = lobe, .n = n, .wo = wo, .mirror = reflect(wo, n), .n_dot_mirror = dot(n, wo)};
    if (lobe->type != LOBE_PHONG) {
        m.width = lobe_width(lobe);
        m.reach = PI; /* GGX has long tails */
        return m;
    }
    float sigma2 = minf(variance(lobe->exponent), .999f);
    int i = (int)(sqrtf(sigma2) * SPANS);
    m.texels = tables->table[i];
    m.blend = (sigma2 - span_end(i)) / (span_end(i + 1) - span_end(i));
    m.width = sqrtf(sigma2);
    m.per_width = 1 / m.width;
    m.reach = REACH * m.width;
    m.clear = m.n_dot_mirror > TOP ? 0 : m.n_dot_mirror > HIGH * m.width ? CLEAR_HIGH : CLEAR;
    if (m.n_dot_mirror > m.reach) m.clear = -INFINITY;
    if (m.n_dot_mirror <= 0) m.clear = INFINITY;
    return m;
}

/* Half-angle of a cap of solid angle omega, at most 90 degrees: 2 asin(s) by its series, 1e-3 off at the most. */
static float cap_angle(float omega)
{
    float s2 = minf(omega * (1 / (4 * PI)), .5f);
    return 2 * sqrtf(s2) * (1 + s2 * (1 / 6.0f + s2 * (3 / 40.0f + s2 * (15 / 336.0f + s2 * .0304f))));
}

/* The error function: Abramowitz and Stegun 7.1.28, absolute error below 3e-7. */
static float fast_erf(float x)
{
    float a = fabsf(x), p = .0001520143f + a * (.0002765672f + a * .0000430638f);
    p = 1 + a * (.0705230784f + a * (.0422820123f + a * (.0092705272f + a * p)));
    return copysignf(1 - 1 / sqr(sqr(sqr(sqr(p)))), x);
}

/* The part of a cap above the horizon, by Gauss and Legendre's eight points over rows of equal elevation. Along a row
 * cos^n(alpha) is nearly a Gaussian of azimuth, whose integral is an error function. For few caps: 200 ns each. */
static rgb phong_clipped(const struct mean_lobe *m, float axis_up, float cos_delta, float omega)
{
    static const float nodes[4][2] = {
        {.1834346f, .3626838f}, {.5255324f, .3137066f}, {.7966665f, .2223810f}, {.9602899f, .1012285f}};
    if (m->n_dot_mirror <= 0) return vec3(0, 0, 0);
    axis_up = clampf(axis_up, -1, 1);
    float mirror_up = minf(m->n_dot_mirror, 1), theta = cap_angle(omega), width = 3.3f * m->width;
    float elevation = asinf(axis_up), mirror_elevation = asinf(mirror_up);
    float low = maxf(maxf(elevation - theta, mirror_elevation - width), 0);
    float high = minf(minf(elevation + theta, mirror_elevation + width), PI / 2);
    if (low >= high) return vec3(0, 0, 0);
    float axis_level = sqrtf(maxf(1 - axis_up * axis_up, 1e-6f)),
          mirror_level = sqrtf(maxf(1 - mirror_up * mirror_up, 1e-6f));
    float azimuth = acosf(clampf((cos_delta - axis_up * mirror_up) / (axis_level * mirror_level), -1, 1));
    float exponent = m->lobe->exponent, cos_theta = 1 - omega * (1 / (2 * PI)), sum = 0;
    for (int i = 0; i < 8; i++) {
        float side = i & 1 ? .5f : -.5f, row = .5f * (low + high) + side * nodes[i / 2][0] * (high - low);
        float up = sinf(row), level = cosf(row), nearest = maxf(cosf(row - mirror_elevation), 1e-4f);
        float cos_half = (cos_theta - up * axis_up) / (level * axis_level);
        if (cos_half >= 1) continue;
        /* The half of n + 1/2 instead of n makes up for the Gaussian's tails, best at small n. */
        float half = acosf(maxf(cos_half, -1)), k = sqrtf(.5f * (exponent + .5f) * level * mirror_level / nearest);
        /* Azimuths from that of R: what reaches beyond pi comes in again from -pi. */
        float from = azimuth - half, to = azimuth + half, end = fast_erf(k * (to <= PI ? to : 2 * PI - to));
        if (to > PI) end = 2 * fast_erf(k * PI) - end;
        sum += nodes[i / 2][1] * up * level * powf(nearest, exponent) * (end - fast_erf(k * from)) / k;
    }
    /* (n+2)/2pi, half the interval, and sqrt(pi)/2 of the error function */
    return scale(m->lobe->weight, (exponent + 2) / (2 * PI) * .5f * (high - low) * .8862269f * sum);
}

static inline rgb phong_cap(const struct mean_lobe *m, struct cap cap)
{
    float cos_delta = dot(cap.axis, m->mirror), disc = cap.omega * (1 / PI); /* disc: squared chord of the radius */
    float u = sqrtf(disc) * m->per_width, v = sqrtf(fabsf(2 - 2 * cos_delta)) * m->per_width;
    if (v >= u + REACH) return vec3(0, 0, 0);
    float up = dot(cap.axis, m->n);
    if (up * fabsf(up) < m->clear * disc * (1 - .25f * disc)) /* against sin^2(theta) */
        return phong_clipped(m, up, cos_delta, cap.omega);
    float first = first_offset(u), size = u / (CAP_KNEE + u);
    float y = size * (CAPS - 1), x = positive(v - first) / (u + REACH - first) * (OFFSETS - 1.001f);
    int j = (int)y, k = (int)x;
    float fy = y - (float)j, fx = x - (float)k;
    const float4 *t = (const float4 *)m->texels + j * OFFSETS + k;
    float4 a = t[0] + fx * (t[1] - t[0]), b = t[OFFSETS] + fx * (t[OFFSETS + 1] - t[OFFSETS]), pq = a + fy * (b - a);
    float p = pq[0] + m->blend * (pq[2] - pq[0]), q = pq[1] + m->blend * (pq[3] - pq[1]);
    return scale(m->lobe->weight, size * size * (p * m->n_dot_mirror + q * up));
}

/* Smith's Lambda, as in ggx.c. */
static float smith(float alpha2, float c) { return .5f * (sqrtf(1 + alpha2 * maxf(1 / (c * c) - 1, 0)) - 1); }

/* f cos of a GGX lobe averaged over a small disc of radius r (rad) about wi, the part of it above the horizon; wo and
 * wi in a frame whose z is n. GGX is the density of an ellipsoid's normals, D = 1/(pi sqrt(det A) (h A^-1 h)^2) with A
 * = diag(alpha^2, alpha^2, 1). The half vectors of the disc fill an ellipse about h, long across at grazing incidence:
 * the disc seen along wi, projected along h. Its covariance is added to A. At normal incidence alpha^2 grows by r^2/5:
 * between r^2/8, which keeps a Gaussian's variance, and r^2/4, which keeps the mean at the peak. */
static rgb ggx_disc(const struct lobe *lobe, float3 wo, float3 wi, float r)
{
    float share = 1, alpha2 = lobe->alpha_x * lobe->alpha_y;
    if (wi.z <= -r) return vec3(0, 0, 0);
    if (wi.z < r) { /* the middle of the height above stands for it */
        wi.z = .5f * (wi.z + r);
        share = wi.z / r;
        wi = normalize(wi);
    }
    float3 h = add(wi, wo);
    float per_length2 = 1 / dot(h, h), s = .8f * r * r * per_length2;
    h = scale(h, sqrtf(per_length2));
    float cos_h = dot(wi, h);
    float3 w = mad(wi, h, -cos_h);
    float xx = alpha2 + s * (1 - h.x * h.x - w.x * w.x), xy = -s * (h.x * h.y + w.x * w.y);
    float yy = alpha2 + s * (1 - h.y * h.y - w.y * w.y), xz = -s * (h.x * h.z + w.x * w.z);
    float zz = 1 + s * (1 - h.z * h.z - w.z * w.z), yz = -s * (h.y * h.z + w.y * w.z);
    float3 row = {yy * zz - yz * yz, xz * yz - xy * zz,
                  xy * yz - xz * yy}; /* of A's adjugate, and in `form` the rest */
    float det = xx * row.x + xy * row.y + xz * row.z;
    float form = h.x * (h.x * row.x + 2 * (h.y * row.y + h.z * row.z)) + h.y * h.y * (xx * zz - xz * xz) +
                 h.z * h.z * (xx * yy - xy * xy) + 2 * h.y * h.z * (xy * xz - xx * yz);
    float d = det * sqrtf(det) / (PI * form * form);
    float f = share * d / (4 * wo.z * (1 + smith(alpha2, wi.z) + smith(alpha2, wo.z)));
    return scale(ggx_fresnel(lobe, cos_h), f);
}

/* GGX over the cap by one disc or seven: a centre and a ring of six (paper, 6.1). */
static rgb ggx_cap(const struct mean_lobe *m, struct cap cap)
{
    float theta = cap_angle(cap.omega), sine = sinf(theta);
    if (m->n_dot_mirror <= 0 || dot(cap.axis, m->n) <= -sine) return vec3(0, 0, 0);
    struct frame local = frame_about(m->n);
    float3 wo = to_local(local, m->wo), axis = to_local(local, cap.axis);
    rgb sum;
    if (theta < .3f * m->width) {
        sum = ggx_disc(m->lobe, wo, axis, theta);
    } else {
        struct frame about = frame_about(axis);
        /* A seventh of the cap, and the centroid of the outer 6/7. */
        float part = theta * .3779645f, ring = theta * .7559289f, sin_ring = sinf(ring), cos_ring = cosf(ring);
        const float half[2] = {.5f * sin_ring, .8660254f * sin_ring}; /* cos and sin of 60 degrees */
        sum = ggx_disc(m->lobe, wo, axis, part);
        for (int i = 0; i < 6; i++) {
            float x = i % 3 == 0 ? sin_ring : half[0], y = i % 3 == 0 ? 0 : i % 3 == 1 ? half[1] : -half[1];
            float3 wi = to_world(about, vec3(i < 3 ? x : -x, y, cos_ring));
            sum = add(sum, ggx_disc(m->lobe, wo, wi, part));
        }
        sum = scale(sum, 1 / 7.0f);
    }
    return scale(mul(sum, m->lobe->weight), cap.omega);
}

rgb mean_lobe_cap(const struct mean_lobe *m, struct cap cap)
{
    return m->lobe->type == LOBE_PHONG ? phong_cap(m, cap) : ggx_cap(m, cap);
}

rgb mean_lobe_quadrature(const struct lobe *lobe, float3 n, float3 wo, struct cap cap, int rings, int sectors)
{
    struct frame frame = frame_about(cap.axis);
    double theta = acos(1 - cap.omega / (2 * PI)), sum[3] = {0};
    for (int i = 0; i < rings; i++) {
        double t = theta * (i + .5) / rings, sine = sin(t), cell = 4 * PI * sine * sin(theta * .5 / rings) / sectors;
        for (int j = 0; j < sectors; j++) {
            double phi = 2 * PI * (j + .5) / sectors;
            float3 wi = to_world(frame, vec3((float)(sine * cos(phi)), (float)(sine * sin(phi)), (float)cos(t)));
            float cosine = dot(wi, n);
            if (cosine <= 0) continue;
            rgb f = lobe_eval(lobe, n, wo, wi);
            sum[0] += f.x * cosine * cell;
            sum[1] += f.y * cosine * cell;
            sum[2] += f.z * cosine * cell;
        }
    }
    return vec3((float)sum[0], (float)sum[1], (float)sum[2]);
}
