/* SPDX-License-Identifier: Apache-2.0 */
/* The equivalent area source (EAS; the paper's SSE): a group of incident light at a record, with a place of its own, so
 * that other points see it from where they are.
 *
 * World space, metres, W/m2/sr. Values only: any thread may call.
 */
#ifndef EAS_EAS_H
#define EAS_EAS_H

#include <assert.h>
#include <stdint.h>

#include "eas/mean_brdf.h"

struct eas {
    float3 position; /* or its unit direction, at infinity */
    float3 normal;   /* unit, on the record's side; 0 at infinity */
    float area;      /* at infinity: solid angle, sr. Else d^2 tan^2(theta_c)/cos(alpha): its disc's area over pi, m2 */
    float visible;   /* share of the solid angle that is seen from x: visible + uncovered.x, 1 at its record */
    float3 uncovered;  /* 1/m: the visibility gradient (occlusion.h) */
    rgb radiance;      /* mean over the group */
    uint32_t infinite; /* 0 or 1; no bool, so that there is no padding */
};
static_assert(sizeof(struct eas) == 60, "written to files as it stands");

#define EAS_GRAZING .1f
/* m: nearer than this is no distance to divide by. */
#define EAS_NEAREST 1e-15f
/* The widest disc, tan(87 deg): a disc cannot fill the hemisphere. */
#define EAS_MAX_TANGENT 20.0f
/* The visibility gradient may uncover as much again as the record saw. */
#define EAS_MOST_UNCOVERED 2.0f

/* An EAS seen under `omega` sr from `origin`, without a visibility gradient. `normal` needn't be unit. */
struct eas eas_make(float3 origin, float3 position, float3 normal, rgb radiance, float omega, bool infinite);

/* eas_translate by components, infinite 0 or 1. Without branches, so that loops over it become vector code. */
static inline struct cap eas_seen(float3 position, float3 normal, float area, float visible, float3 uncovered,
                                  float infinite, float3 x)
{
    float3 v = mad(position, x, infinite - 1);
    float per_d2 = 1 / maxf(dot(v, v), EAS_NEAREST * EAS_NEAREST);
    v = scale(v, sqrtf(per_d2));
    float cos_alpha = -dot(normal, v);
    float tan2 = minf(area * maxf(cos_alpha, EAS_GRAZING) * per_d2, EAS_MAX_TANGENT * EAS_MAX_TANGENT);
    float omega = 2 * PI * tan2 / (1 + tan2 + sqrtf(1 + tan2));
    omega = cos_alpha > 0 ? omega : 0; /* at infinity 0, too */
    float share = minf(maxf(visible + dot(uncovered, x), 0), EAS_MOST_UNCOVERED);
    return (struct cap){v, share * (omega + infinite * area)};
}

/* The cap under which x sees the EAS (paper, eq. 19): tan^2(theta') = area cos(alpha')/d'^2. Departures from the paper:
 * no receiver's cosine, which a solid angle doesn't have; a disc's tangent instead of its small-angle form, so that
 * omega stays below 2 pi as d' goes to 0; cos(alpha) is kept above EAS_GRAZING; seen from behind it is empty (omega 0).
 * From its record the cap is that of the samples. Past the paper, its solid angle changes by the visibility gradient.
 */
static inline struct cap eas_translate(const struct eas *eas, float3 x)
{
    return eas_seen(eas->position, eas->normal, eas->area, eas->visible, eas->uncovered, eas->infinite, x);
}

/* Radiance that a lobe reflects of `count` EAS at x (paper, eq. 9). */
rgb eas_reflect(const struct eas *eas, uint32_t count, const struct mean_lobe *lobe, float3 x);

#endif
