/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/sheen.h"

/* The lobe's frame: its tangent on the viewer's side. */
static struct frame frame_toward(float3 n, float3 wo)
{
    float3 t = mad(wo, n, -dot(n, wo));
    if (dot(t, t) < 1e-12f) return frame_about(n);
    t = normalize(t);
    return (struct frame){t, cross(n, t), n};
}

struct lobe sheen_lobe(float roughness, float cos_o)
{
    /* Below .05 the closed form has left the tables, whose albedo is below .03 but at the horizon. */
    float x = clampf(cos_o, 0, 1), y = clampf(roughness, .05f, 1);
    float a = (2.58126f * x + .813703f * y) * y / (1 + .310327f * x * x + 2.60994f * x * y);
    float b = sqrtf(1 - x) * (y - 1) * y * y * y / (.0000254053f + 1.71228f * x - 1.71506f * x * y + 1.34174f * y * y);
    float width = y * (.0206607f + 1.58491f * y) / (.0379424f + y * (1.32227f + y));
    float middle = y * (-.193854f + y * (-1.14885f + y * (1.7932f - .95943f * y * y))) / (.046391f + y);
    float rest = y * (.000654023f + (-.0207818f + .119681f * y) * y) / (1.26264f + y * (-1.92021f + y));
    float albedo = expf(-.5f * sqr((x - middle) / width)) / (width * sqrtf(2 * PI)) + rest;
    albedo = clampf(albedo, 0, 1);
    return (struct lobe){.type = LOBE_SHEEN, .weight = {albedo, albedo, albedo}, .ltc = {a, b}};
}

rgb sheen_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf)
{
    float3 w = to_local(frame_toward(n, wo), wi);
    float a = lobe->ltc.x, b = lobe->ltc.y, length2 = sqr(a * w.x + b * w.z) + sqr(a * w.y) + sqr(w.z);
    float f = sqr(a / length2) / PI;
    *pdf = w.z * f;
    return scale(lobe->weight, f);
}

float3 sheen_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2])
{
    float r = sqrtf(u[0]), phi = 2 * PI * u[1], z = sqrtf(1 - u[0]);
    float3 w = {r * cosf(phi) - z * lobe->ltc.y, r * sinf(phi), z * lobe->ltc.x};
    return to_world(frame_toward(n, wo), normalize(w));
}
