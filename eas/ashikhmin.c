/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/ashikhmin.h"

#include "eas/ggx.h"

static inline float exponent_of(float alpha) { return 2 / sqr(alpha) - 2; }

rgb ashikhmin_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf)
{
    float3 h = normalize(add(wi, wo)), local = to_local(ggx_frame(lobe, n), h);
    float x = exponent_of(lobe->alpha_x), y = exponent_of(lobe->alpha_y), sin2 = sqr(local.x) + sqr(local.y);
    float e = sin2 > 0 ? (x * sqr(local.x) + y * sqr(local.y)) / sin2 : 0;
    /* cos^e by the sine, which keeps a narrow lobe's width. */
    float power = expf(.5f * e * log1pf(-minf(sin2, .9999999f)));
    *pdf = sqrtf((x + 1) * (y + 1)) / (8 * PI) * power / maxf(dot(h, wi), 1e-6f);
    return scale(lobe->weight, *pdf / maxf(dot(n, wi), dot(n, wo)));
}

float3 ashikhmin_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2])
{
    float x = exponent_of(lobe->alpha_x), y = exponent_of(lobe->alpha_y);
    float phi = atan2f(sqrtf(x + 1) * sinf(2 * PI * u[0]), sqrtf(y + 1) * cosf(2 * PI * u[0]));
    float c = cosf(phi), s = sinf(phi), e = x * c * c + y * s * s;
    float sin2 = -expm1f(2 * log1pf(-u[1]) / (e + 1)), level = sqrtf(sin2);
    return reflect(wo, to_world(ggx_frame(lobe, n), vec3(level * c, level * s, sqrtf(maxf(1 - sin2, 0)))));
}
