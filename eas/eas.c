/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/eas.h"

/* The widest disc, tan(87 deg): a disc cannot fill the hemisphere. */
#define MAX_TANGENT 20.0f

struct eas eas_make(float3 origin, float3 position, float3 normal, rgb radiance, float omega, bool infinite)
{
    if (infinite) return (struct eas){normalize(position), vec3(0, 0, 0), radiance, omega, true};
    float3 to_record = sub(origin, position);
    float d2 = maxf(dot(to_record, to_record), 1e-12f);
    to_record = scale(to_record, 1 / sqrtf(d2));
    normal = normalize(normal);
    float cos_alpha = dot(normal, to_record);
    if (!(cos_alpha > 0)) { /* a mean of normals that looks away: let it face the record */
        normal = to_record;
        cos_alpha = 1;
    }
    float height = minf(omega * (1 / (2 * PI)), 1 - 1 / MAX_TANGENT), tan2 = height * (2 - height) / sqr(1 - height);
    return (struct eas){position, normal, radiance, d2 * tan2 / maxf(cos_alpha, EAS_GRAZING), false};
}

struct cap eas_translate(const struct eas *eas, float3 x)
{
    if (eas->infinite) return (struct cap){eas->position, eas->area};
    float3 v = sub(eas->position, x);
    float d2 = maxf(dot(v, v), 1e-12f);
    v = scale(v, 1 / sqrtf(d2));
    float cos_alpha = -dot(eas->normal, v);
    if (!(cos_alpha > 0)) return (struct cap){v, 0};
    float tan2 = minf(eas->area * maxf(cos_alpha, EAS_GRAZING) / d2, MAX_TANGENT * MAX_TANGENT);
    return (struct cap){v, 2 * PI * tan2 / (1 + tan2 + sqrtf(1 + tan2))};
}

/* Which of `count` EAS may send light into a lobe seen from x: near[i] > 0. Chords on the unit sphere: that between an
 * EAS's axis and the mirror direction against the most that its cap's radius can be, plus the lobe's reach. Most EAS
 * end here, several at a time. */
static void near_lobe(const struct eas *eas, uint32_t count, const struct mean_lobe *lobe, float3 x, float *near)
{
    const float3 mirror = lobe->mirror;
    const float reach = lobe->reach;
#pragma omp simd
    for (uint32_t i = 0; i < count; i++) {
        float there = eas[i].infinite ? 0.0f : 1.0f;
        float vx = eas[i].position.x - there * x.x, vy = eas[i].position.y - there * x.y;
        float vz = eas[i].position.z - there * x.z;
        float per_d2 = 1 / maxf(vx * vx + vy * vy + vz * vz, 1e-12f);
        float cos_delta = (vx * mirror.x + vy * mirror.y + vz * mirror.z) * sqrtf(per_d2);
        float most = sqrtf(eas[i].area * (eas[i].infinite ? 1 / PI : per_d2)) + reach;
        near[i] = most * most - (2 - 2 * cos_delta);
    }
}

rgb eas_reflect(const struct eas *eas, uint32_t count, const struct mean_lobe *lobe, float3 x)
{
    enum { BLOCK = 64 };
    float near[BLOCK];
    rgb sum = {0};
    for (uint32_t first = 0; first < count; first += BLOCK) {
        uint32_t block = count - first < BLOCK ? count - first : BLOCK;
        near_lobe(eas + first, block, lobe, x, near);
        for (uint32_t i = 0; i < block; i++) {
            if (near[i] <= 0) continue;
            struct cap cap = eas_translate(&eas[first + i], x);
            if (cap.omega > 0) sum = add(sum, mul(eas[first + i].radiance, mean_lobe_cap(lobe, cap)));
        }
    }
    return sum;
}
