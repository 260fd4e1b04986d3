/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/mean_brdf.h"

#include <stdlib.h>

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
    else m.ggx = mean_ggx(lobe, n, wo);
    return m;
}

static void phong_caps(const struct mean_lobe *m, const struct cap *caps, int count, rgb *values)
{
    struct mean_phong_caps block;
    for (int first = 0; first < count; first += MEAN_PHONG_BLOCK) {
        int size = count - first < MEAN_PHONG_BLOCK ? count - first : MEAN_PHONG_BLOCK;
        for (int i = 0; i < size; i++) {
            block.omega[i] = caps[first + i].omega;
            block.cos_mirror[i] = dot(caps[first + i].axis, m->mirror);
            block.up[i] = dot(caps[first + i].axis, m->n);
            block.mirror_up[i] = m->n_dot_mirror;
            values[first + i] = vec3(0, 0, 0);
        }
        int hits = mean_phong_caps(&m->phong, &block, size);
        for (int h = 0; h < hits; h++) values[first + block.hit[h]] = scale(m->lobe->weight, block.value[block.hit[h]]);
    }
}

void mean_lobe_caps(const struct mean_lobe *m, const struct cap *caps, int count, rgb *values)
{
    if (m->lobe->type == LOBE_PHONG) phong_caps(m, caps, count, values);
    else mean_ggx_caps(&m->ggx, caps, count, values);
}

rgb mean_lobe_cap(const struct mean_lobe *m, struct cap cap)
{
    rgb value;
    mean_lobe_caps(m, &cap, 1, &value);
    return value;
}

rgb mean_lobe_quadrature(const struct lobe *lobe, float3 n, float3 wo, struct cap cap, int rings, int sectors)
{
    /* About the axis; x is up, so that a ring is above the horizon where |phi| < open. */
    float3 a = cap.axis, y = cross(n, a);
    y = dot(y, y) > 1e-10f ? normalize(y) : frame_about(a).t;
    struct frame frame = {cross(a, y), y, a};
    double up = dot(a, n), level = dot(frame.t, n), theta = 2 * asin(sqrt(cap.omega / (4 * M_PI))), sum[3] = {0};
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
