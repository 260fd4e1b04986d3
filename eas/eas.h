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
    float3 normal;   /* unit, on the record's side */
    rgb radiance;    /* mean over the group */
    float area;      /* at infinity: solid angle, sr. Else d^2 tan^2(theta_c)/cos(alpha): its disc's area over pi, m2 */
    uint32_t infinite; /* 0 or 1; no bool, so that there is no padding */
};
static_assert(sizeof(struct eas) == 44, "written to files as it stands");

/* An EAS seen under `omega` sr from `origin`. `normal` needn't be unit. */
struct eas eas_make(float3 origin, float3 position, float3 normal, rgb radiance, float omega, bool infinite);

/* The cap under which x sees the EAS (paper, eq. 19): tan^2(theta') = area cos(alpha')/d'^2. Departures from the paper:
 * no receiver's cosine, which a solid angle doesn't have; a disc's tangent instead of its small-angle form, so that
 * omega stays below 2 pi as d' goes to 0; cos(alpha) is kept above EAS_GRAZING; seen from behind it is empty (omega 0).
 * From its record the cap is that of the samples. */
struct cap eas_translate(const struct eas *eas, float3 x);

#define EAS_GRAZING .1f

/* Radiance that a lobe reflects of `count` EAS at x (paper, eq. 9). */
rgb eas_reflect(const struct eas *eas, uint32_t count, const struct mean_lobe *lobe, float3 x);

#endif
