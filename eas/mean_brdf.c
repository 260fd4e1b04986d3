/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/mean_brdf.h"

#include <stdlib.h>

#include "eas/ggx.h"

struct mean_brdf {
    struct mean_phong phong;
};

struct mean_brdf *mean_brdf_build(void)
{
    struct mean_brdf *tables = malloc(sizeof *tables);
    if (tables) mean_phong_fill(&tables->phong);
    return tables;
}

void mean_brdf_free(struct mean_brdf *tables) { free(tables); }

struct mean_lobe mean_lobe(const struct mean_brdf *tables, const struct lobe *lobe, float3 n, float3 wo)
{
    struct mean_lobe m = {.lobe = lobe, .n = n, .wo = wo, .mirror = reflect(wo, n), .n_dot_mirror = dot(n, wo)};
    if (lobe->type == LOBE_PHONG) m.phong = mean_phong_lobe(&tables->phong, lobe->exponent);
    else m.width = lobe_width(lobe);
    return m;
}

static rgb phong_cap(const struct mean_lobe *m, struct cap cap)
{
    struct mean_phong_caps one;
    one.omega[0] = cap.omega;
    one.cos_mirror[0] = dot(cap.axis, m->mirror);
    one.up[0] = dot(cap.axis, m->n);
    one.mirror_up[0] = m->n_dot_mirror;
    return mean_phong_caps(&m->phong, &one, 1) ? scale(m->lobe->weight, one.value[0]) : vec3(0, 0, 0);
}

/* Half-angle of a cap of solid angle omega, at most 90 degrees: 2 asin(s) by its series, 1e-3 off at the most. */
static float cap_angle(float omega)
{
    float s2 = minf(omega * (1 / (4 * PI)), .5f);
    return 2 * sqrtf(s2) * (1 + s2 * (1 / 6.0f + s2 * (3 / 40.0f + s2 * (15 / 336.0f + s2 * .0304f))));
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
    float share = 1, alpha2 = sqr(lobe->alpha);
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
    /* About the axis; x is up, so that a ring is above the horizon where |phi| < open. */
    float3 a = cap.axis, y = cross(n, a);
    y = dot(y, y) > 1e-10f ? normalize(y) : frame_about(a).t;
    struct frame frame = {cross(a, y), y, a};
    double up = dot(a, n), level = dot(frame.t, n), theta = acos(1 - cap.omega / (2 * PI)), sum[3] = {0};
    double first = fmin(fmax(-atan2(up, level), 0), theta), step = (theta - first) / rings;
    for (int i = 0; i < rings; i++) {
        double t = first + step * (i + .5), sine = sin(t), ring_up = cos(t) * up, rise = sine * level;
        double open = ring_up >= rise ? M_PI : acos(fmin(-ring_up / rise, 1));
        double cell = 4 * open * sine * sin(step * .5) / sectors;
        for (int j = 0; j < sectors; j++) {
            double phi = open * ((2 * j + 1) / (double)sectors - 1), cosine = ring_up + rise * cos(phi);
            float3 wi = vec3((float)(sine * cos(phi)), (float)(sine * sin(phi)), (float)cos(t));
            rgb f = lobe_eval(lobe, n, wo, to_world(frame, wi));
            sum[0] += f.x * cosine * cell;
            sum[1] += f.y * cosine * cell;
            sum[2] += f.z * cosine * cell;
        }
    }
    return vec3((float)sum[0], (float)sum[1], (float)sum[2]);
}
