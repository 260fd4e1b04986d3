/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/eas.h"

#include <assert.h>
#include <stddef.h>
#include <string.h>

typedef float float4 __attribute__((vector_size(16)));

struct eas eas_make(float3 origin, float3 position, float3 normal, rgb radiance, float omega, bool infinite)
{
    struct eas eas = {.position = position, .visible = 1, .radiance = radiance, .infinite = infinite};
    if (infinite) {
        eas.position = normalize(position);
        eas.area = omega;
        return eas;
    }
    float3 to_record = sub(origin, position);
    float d2 = dot(to_record, to_record);
    normal = dot(normal, normal) > 1e-38f ? normalize(normal) : vec3(0, 0, 1); /* means may cancel */
    /* In a corner it may lie where the record is. */
    to_record = d2 > EAS_NEAREST * EAS_NEAREST ? scale(to_record, 1 / sqrtf(d2)) : normal;
    d2 = maxf(d2, EAS_NEAREST * EAS_NEAREST);
    float cos_alpha = dot(normal, to_record);
    if (!(cos_alpha > 0)) { /* a mean of normals that looks away: let it face the record */
        normal = to_record;
        cos_alpha = 1;
    }
    float height = minf(omega * (1 / (2 * PI)), 1 - 1 / EAS_MAX_TANGENT),
          tan2 = height * (2 - height) / sqr(1 - height);
    eas.normal = normal;
    eas.area = d2 * tan2 / maxf(cos_alpha, EAS_GRAZING);
    return eas;
}

/* A block at a time: translated and looked up as vectors. */
static rgb reflect_phong(const struct eas *eas, uint32_t count, const struct mean_lobe *lobe, float3 x)
{
    /* The head of each EAS, in rows of eight and of four: strides that compilers load as vectors, which theirs isn't.
     */
    float rows[MEAN_PHONG_BLOCK][8], edges[MEAN_PHONG_BLOCK][4];
    static_assert(offsetof(struct eas, uncovered) == 8 * sizeof(float),
                  "what translation needs leads, and another float follows");
    struct mean_phong_caps caps;
    const float3 n = lobe->n, mirror = lobe->mirror;
    const float mirror_up = lobe->n_dot_mirror;
    float4 sum = {0};
    for (uint32_t first = 0; first < count; first += MEAN_PHONG_BLOCK) {
        const struct eas *block = eas + first;
        int size = count - first < MEAN_PHONG_BLOCK ? (int)(count - first) : MEAN_PHONG_BLOCK;
        for (int i = 0; i < size; i++) {
            memcpy(rows[i], &block[i], sizeof rows[i]);
            memcpy(edges[i], &block[i].uncovered, sizeof edges[i]);
        }
#pragma omp simd
        for (int i = 0; i < size; i++) {
            const float *r = rows[i], *e = edges[i];
            float3 position = {r[0], r[1], r[2]}, normal = {r[3], r[4], r[5]};
            struct cap cap =
                eas_seen(position, normal, r[6], r[7], vec3(e[0], e[1], e[2]), dot(normal, normal) > 0 ? 0 : 1, x);
            caps.omega[i] = cap.omega;
            caps.cos_mirror[i] = dot(cap.axis, mirror);
            caps.up[i] = dot(cap.axis, n);
            caps.mirror_up[i] = mirror_up;
        }
        int hits = mean_phong_caps(&lobe->phong, &caps, size);
        for (int h = 0; h < hits; h++) {
            int i = caps.hit[h];
            rgb l = block[i].radiance;
            sum += caps.value[i] * (float4){l.x, l.y, l.z, 0};
        }
    }
    return mul(vec3(sum[0], sum[1], sum[2]), lobe->lobe->weight);
}

static rgb reflect_ggx(const struct eas *eas, uint32_t count, const struct mean_lobe *lobe, float3 x)
{
    enum { BLOCK = 64 };
    struct cap caps[BLOCK];
    rgb values[BLOCK], sum = {0};
    for (uint32_t first = 0; first < count; first += BLOCK) {
        int size = count - first < BLOCK ? (int)(count - first) : BLOCK;
        for (int i = 0; i < size; i++) caps[i] = eas_translate(&eas[first + (uint32_t)i], x);
        mean_lobe_caps(lobe, caps, size, values);
        for (int i = 0; i < size; i++) sum = add(sum, mul(eas[first + (uint32_t)i].radiance, values[i]));
    }
    return sum;
}

rgb eas_reflect(const struct eas *eas, uint32_t count, const struct mean_lobe *lobe, float3 x)
{
    return lobe->lobe->type == LOBE_PHONG ? reflect_phong(eas, count, lobe, x) : reflect_ggx(eas, count, lobe, x);
}
