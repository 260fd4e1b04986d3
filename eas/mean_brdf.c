/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/mean_brdf.h"

#include <stdlib.h>

enum { EXPONENTS = 15, CAPS = 64, OFFSETS = 64, RINGS = 96 };

/* A lobe reaches this many sigmas: exp(-4.5^2/2) = 4e-5 of its peak. */
#define REACH 4.5f
/* Cap radii are tabulated over s/(CAP_KNEE + s), s in sigmas. */
#define CAP_KNEE 2.0f

/* [exponent 2^i][cap][offset][A, B], both as means over the cap. */
struct mean_brdf { float table[EXPONENTS][CAPS][OFFSETS][2]; };

static float sigma(float exponent) { return 1 / sqrtf(exponent + 1); }

/* The part of delta that the table covers for a cap: from where the lobe is wholly inside to where it is wholly outside. */
static void offset_range(float theta, float width, float *first, float *span)
{
    *first = maxf(0, theta - REACH * width);
    *span = theta + REACH * width - *first;
}

/* A and B of METHOD's reduction for modified Phong over a cap of half-angle theta at delta from the mirror direction R:
 *     integral of f cos = (n+2)/2pi [ (N.R) A + (N.e) B ],  e the unit part of the cap's axis orthogonal to R.
 * The rings t about R lie inside the cap over |phi| < phi(t). Midpoint rule in a variable that flattens the square-root
 * ends of phi(t). */
static void phong_reduction(double exponent, double theta, double delta, double *A, double *B)
{
    double first = fabs(delta - theta), last = fmin(delta + theta, PI / 2);
    last = fmin(last, fmax(first, 6.5 / sqrt(exponent + 1)));
    *A = *B = 0;
    if (delta < theta) {
        first = fmin(first, PI / 2);
        *A = 2 * PI * (1 - pow(cos(first), exponent + 2)) / (exponent + 2);
    }
    if (last <= first)
        return;
    for (int i = 0; i < RINGS; i++) {
        double s = (i + .5) / RINGS, t = first + (last - first) * .5 * (1 - cos(PI * s));
        double dt = (last - first) * .5 * PI * sin(PI * s) / RINGS;
        double cos_phi = (cos(theta) - cos(t) * cos(delta)) / fmax(sin(t) * sin(delta), 1e-12);
        double phi = acos(fmax(-1, fmin(1, cos_phi))), lobe = pow(fmax(cos(t), 0), exponent);
        *A += 2 * phi * lobe * cos(t) * sin(t) * dt;
        *B += 2 * sin(phi) * lobe * sin(t) * sin(t) * dt;
    }
}

struct mean_brdf *mean_brdf_build(void)
{
    struct mean_brdf *tables = malloc(sizeof *tables);
    if (!tables)
        return NULL;
    for (int i = 0; i < EXPONENTS; i++) {
        float exponent = ldexpf(1, i), width = sigma(exponent);
        for (int j = 0; j < CAPS; j++) {
            float c = (float)j / CAPS; /* < 1: s finite */
            float theta = maxf(minf(width * CAP_KNEE * c / (1 - c), PI / 2), 1e-3f * width), first, span;
            offset_range(theta, width, &first, &span);
            double omega = 4 * PI * sqr(sinf(theta / 2));
            for (int k = 0; k < OFFSETS; k++) {
                double A, B;
                phong_reduction(exponent, theta, first + span * (double)k / (OFFSETS - 1), &A, &B);
                tables->table[i][j][k][0] = (float)(A / omega);
                tables->table[i][j][k][1] = (float)(B / omega);
            }
        }
    }
    return tables;
}

void mean_brdf_free(struct mean_brdf *tables) { free(tables); }

struct mean_lobe mean_lobe(const struct mean_brdf *tables, const struct lobe *lobe, float3 n, float3 wo)
{
    struct mean_lobe m = {.lobe = lobe, .n = n, .wo = wo, .mirror = reflect(wo, n)};
    if (lobe->type == LOBE_PHONG) {
        float level = clampf(log2f(maxf(lobe->exponent, 1)), 0, EXPONENTS - 1.001f);
        int i = (int)level;
        m.width = sigma(lobe->exponent);
        m.slice0 = &tables->table[i][0][0][0];
        m.slice1 = &tables->table[i + 1][0][0][0];
        m.blend = level - (float)i;
        m.peak = (lobe->exponent + 2) / (2 * PI);
        m.reach = REACH * m.width;
    } else {
        m.width = lobe_width(lobe);
        m.reach = PI; /* GGX has long tails */
    }
    m.n_dot_mirror = dot(n, m.mirror);
    return m;
}

/* Abramowitz and Stegun 4.4.45: absolute error below 7e-5. */
static float fast_acos(float x)
{
    float a = fabsf(x);
    float y = sqrtf(maxf(1 - a, 0)) * (1.5707288f + a * (-.2121144f + a * (.0742610f - .0187293f * a)));
    return x < 0 ? PI - y : y;
}

/* Half-angle of a cap of solid angle omega, at most 90 degrees: 2 asin(s) by its series, 1e-3 off at the most. */
static float cap_angle(float omega)
{
    float s2 = minf(omega * (1 / (4 * PI)), .5f);
    return 2 * sqrtf(s2) * (1 + s2 * (1 / 6.0f + s2 * (3 / 40.0f + s2 * (15 / 336.0f + s2 * .0304f))));
}

static rgb phong_cap(const struct mean_lobe *m, struct cap cap)
{
    float cos_delta = dot(cap.axis, m->mirror), delta = fast_acos(cos_delta);
    float theta = cap_angle(cap.omega), first, span;
    if (delta > theta + m->reach)
        return vec3(0, 0, 0);
    offset_range(theta, m->width, &first, &span);
    float s = theta / m->width, y = minf(s / (CAP_KNEE + s) * CAPS, CAPS - 1.001f);
    float x = clampf((delta - first) / span, 0, .9999f) * (OFFSETS - 1);
    int j = (int)y, k = (int)x;
    float fy = y - (float)j, fx = x - (float)k, ab[2];
    const float *p = m->slice0 + (j * OFFSETS + k) * 2, *q = m->slice1 + (j * OFFSETS + k) * 2;
    for (int c = 0; c < 2; c++) {
        float p0 = p[c] + fx * (p[c + 2] - p[c]), p1 = p[c + 2 * OFFSETS] + fx * (p[c + 2 * OFFSETS + 2] - p[c + 2 * OFFSETS]);
        float q0 = q[c] + fx * (q[c + 2] - q[c]), q1 = q[c + 2 * OFFSETS] + fx * (q[c + 2 * OFFSETS + 2] - q[c + 2 * OFFSETS]);
        float a = p0 + fy * (p1 - p0), b = q0 + fy * (q1 - q0);
        ab[c] = a + m->blend * (b - a);
    }
    float sin_delta = sqrtf(maxf(1 - cos_delta * cos_delta, 1e-12f));
    float n_dot_e = (dot(cap.axis, m->n) - cos_delta * m->n_dot_mirror) / sin_delta;
    float value = m->peak * cap.omega * (m->n_dot_mirror * ab[0] + n_dot_e * ab[1]);
    return scale(m->lobe->weight, maxf(value, 0));
}

/* GGX over the cap by one point or seven (a centre and a ring of six). Each point stands for a disc of radius r under a lobe of
 * alpha'^2 = alpha^2 + r^2/5: between r^2/8, which keeps the variance of a Gaussian, and r^2/4, which keeps the mean over a disc at GGX's peak. */
static rgb ggx_cap(const struct mean_lobe *m, struct cap cap)
{
    float theta = cap_angle(cap.omega);
    struct lobe wide = *m->lobe;
    bool small = theta < .3f * m->width;
    float part = small ? theta : theta / sqrtf(7);
    wide.alpha = minf(1, sqrtf(sqr(wide.alpha) + part * part / 5));
    float cosine = dot(cap.axis, m->n);
    rgb sum = cosine > 0 ? scale(lobe_eval(&wide, m->n, m->wo, cap.axis), cosine) : vec3(0, 0, 0);
    if (small)
        return scale(sum, cap.omega);
    struct frame frame = frame_about(cap.axis);
    float ring = theta * .7559289f, sin_ring = sinf(ring), cos_ring = cosf(ring); /* centroid of the outer 6/7 */
    for (int i = 0; i < 6; i++) {
        float phi = (float)i * (PI / 3);
        float3 wi = to_world(frame, vec3(sin_ring * cosf(phi), sin_ring * sinf(phi), cos_ring));
        cosine = dot(wi, m->n);
        if (cosine > 0)
            sum = mad(sum, lobe_eval(&wide, m->n, m->wo, wi), cosine);
    }
    return scale(sum, cap.omega / 7);
}

/* The part of a cap above the horizon as a cap of its own: as high as that part, of its solid angle. */
static bool clip_cap(float3 n, struct cap *cap)
{
    float sin_elevation = dot(cap->axis, n), sin2_theta = cap->omega / PI * (1 - cap->omega / (4 * PI));
    if (sin_elevation > 0 && sqr(sin_elevation) >= sin2_theta)
        return true;
    float theta = asinf(sqrtf(minf(sin2_theta, 1))), elevation = asinf(clampf(sin_elevation, -1, 1));
    if (cap->omega > 2 * PI)
        theta = PI - theta;
    if (elevation <= -theta)
        return false;
    /* The planar segment of a disc cut at -elevation/theta of its radius. */
    float h = elevation / maxf(theta, 1e-6f), share = (acosf(-h) + h * sqrtf(maxf(1 - h * h, 0))) / PI;
    float centre = .5f * (elevation + theta);
    float3 level = sub(cap->axis, scale(n, sin_elevation));
    if (dot(level, level) < 1e-12f)
        return true;
    cap->axis = mad(scale(normalize(level), cosf(centre)), n, sinf(centre));
    cap->omega *= share;
    return cap->omega > 0;
}

rgb mean_lobe_cap(const struct mean_lobe *m, struct cap cap)
{
    if (!clip_cap(m->n, &cap))
        return vec3(0, 0, 0);
    return m->lobe->type == LOBE_PHONG ? phong_cap(m, cap) : ggx_cap(m, cap);
}

rgb mean_lobe_quadrature(const struct lobe *lobe, float3 n, float3 wo, struct cap cap, int rings, int sectors)
{
    struct frame frame = frame_about(cap.axis);
    double sum[3] = {0};
    for (int i = 0; i < rings; i++) {
        double z = 1 - cap.omega / (2 * PI) * (i + .5) / rings, sine = sqrt(fmax(1 - z * z, 0));
        for (int j = 0; j < sectors; j++) {
            double phi = 2 * PI * (j + .5) / sectors;
            float3 wi = to_world(frame, vec3((float)(sine * cos(phi)), (float)(sine * sin(phi)), (float)z));
            float cosine = dot(wi, n);
            if (cosine <= 0)
                continue;
            rgb f = lobe_eval(lobe, n, wo, wi);
            sum[0] += f.x * cosine;
            sum[1] += f.y * cosine;
            sum[2] += f.z * cosine;
        }
    }
    double cell = cap.omega / ((double)rings * sectors);
    return vec3((float)(sum[0] * cell), (float)(sum[1] * cell), (float)(sum[2] * cell));
}
