/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/brdf.h"

#include "eas/ggx.h"

static inline float saturate(float x) { return clampf(x, 0, 1); }
static inline float average(rgb c) { return (c.x + c.y + c.z) / 3; }

struct brdf brdf_phong(rgb kd, rgb ks, float exponent)
{
    struct brdf brdf = {.kd = kd};
    if (max3(ks) > 0)
        brdf.lobes[brdf.lobe_count++] = (struct lobe){.type = LOBE_PHONG, .weight = ks, .exponent = exponent};
    return brdf;
}

/* Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks", appendix: the cosine-weighted mean of the
 * dielectric Fresnel curve. */
static float fresnel_mean(float eta)
{
    if (eta < 1) return 0.997118f + eta * (0.1014f - eta * (0.965241f + eta * 0.130607f));
    return (eta - 1) / (4.08567f + 1.00071f * eta);
}

/* What multiple scattering adds to a lobe whose Fresnel factor has the mean `fresnel`, as a factor of single
 * scattering: 1 + Fms (1-E)/E, Fms from Kulla and Conty with one bounce taken out (Turquin 2019). *darkening is that
 * factor without the 1/E of a white lobe: Cycles' layering takes the lobe's albedo with it alone. */
static rgb compensation(float roughness, float mu, rgb fresnel, rgb *darkening)
{
    float e = ggx_albedo(roughness, mu), mean = ggx_albedo_mean(roughness), missing = (1 - e) / e;
    rgb bounced = {fresnel.x * mean / (1 - fresnel.x * (1 - mean)), fresnel.y * mean / (1 - fresnel.y * (1 - mean)),
                   fresnel.z * mean / (1 - fresnel.z * (1 - mean))};
    rgb factor = mad(vec3(1, 1, 1), bounced, missing);
    *darkening = scale(factor, e);
    return factor;
}

static struct lobe metal_lobe(rgb f0, rgb f82, float weight, float roughness, float mu)
{
    float2 alpha = ggx_alphas(roughness, 0);
    struct lobe lobe = {.type = LOBE_METAL, .alpha_x = alpha.x, .alpha_y = alpha.y, .f0 = f0, .f82 = f82};
    /* The cosine-weighted mean of the F82-tint curve: Schlick's at 1/21 of the way to 1, less b/126. */
    const float edge = 6.0f / 7, edge5 = edge * edge * edge * edge * edge;
    const rgb white = {1, 1, 1};
    rgb b = scale(mul(lerp3(f0, white, edge5), sub(white, f82)), 7 / (edge5 * edge));
    rgb mean = mad(lerp3(f0, white, 1.0f / 21), b, -1.0f / 126), darkening;
    lobe.weight = scale(compensation(roughness, mu, mean, &darkening), weight);
    return lobe;
}

struct brdf brdf_principled(const struct principled *p, float cos_o)
{
    struct brdf brdf = {0};
    const rgb white = {1, 1, 1};
    float roughness = saturate(p->roughness), metallic = saturate(p->metallic), base = 1 - metallic;
    float mu = saturate(cos_o);
    rgb tint = p->specular_tint, colour = p->base_colour;
    if (metallic > 0) {
        rgb f0 = {saturate(colour.x), saturate(colour.y), saturate(colour.z)};
        rgb f82 = {minf(tint.x, 1), minf(tint.y, 1), minf(tint.z, 1)};
        brdf.lobes[brdf.lobe_count++] = metal_lobe(f0, f82, metallic, roughness, mu);
    }
    float eta = maxf(p->ior, 1e-5f), f0 = ggx_f0(eta);
    if (p->specular_level != 0.5f) { /* f0 scaled, and the index that has it */
        f0 *= 2 * p->specular_level;
        float root = sqrtf(clampf(f0, 0, 0.99f));
        eta = p->ior < 1 ? (1 - root) / (1 + root) : (1 + root) / (1 - root);
    }
    if (base > 0 && eta != 1) {
        float2 alpha = ggx_alphas(roughness, 0);
        struct lobe lobe = {.type = LOBE_DIELECTRIC,
                            .alpha_x = alpha.x,
                            .alpha_y = alpha.y,
                            .ior = eta,
                            .f0 = {saturate(f0 * tint.x), saturate(f0 * tint.y), saturate(f0 * tint.z)}};
        float real_f0 = ggx_f0(eta), share = saturate((fresnel_mean(eta) - real_f0) / (1 - real_f0));
        rgb darkening, factor = compensation(roughness, mu, lerp3(lobe.f0, white, share), &darkening);
        lobe.weight = scale(factor, base);
        brdf.lobes[brdf.lobe_count++] = lobe;
        rgb albedo = mul(darkening, lerp3(lobe.f0, white, ggx_fresnel_share(roughness, mu, eta)));
        base *= saturate(1 - max3(albedo));
    }
    brdf.kd = scale(colour, base);
    return brdf;
}

static inline float phong_pdf(float exponent, float3 n, float3 wo, float3 wi, float *power)
{
    float c = dot(reflect(wo, n), wi);
    *power = c > 0 ? powf(c, exponent) : 0;
    return (exponent + 1) / (2 * PI) * *power;
}

/* f and pdf of a lobe; 0 where wi or wo is below the horizon. Phong's pdf goes on below it. */
static inline rgb lobe_both(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf)
{
    *pdf = 0;
    if (dot(n, wo) <= 0 || dot(n, wi) <= 0) return (rgb){0};
    if (lobe->type != LOBE_PHONG) return ggx_eval(lobe, n, wo, wi, pdf);
    float power;
    *pdf = phong_pdf(lobe->exponent, n, wo, wi, &power);
    return scale(lobe->weight, (lobe->exponent + 2) / (2 * PI) * power);
}

/* About the lobe's albedo at n.wo: how often it is chosen. */
static inline float lobe_share(const struct lobe *lobe, float cos_o)
{
    if (lobe->type == LOBE_PHONG) return average(lobe->weight);
    return average(mul(lobe->weight, ggx_fresnel(lobe, cos_o)));
}

/* The chances of diffuse, [0], and the lobes; all 0 for a black surface. */
static inline int choices(const struct brdf *brdf, float cos_o, float chance[static 3])
{
    float sum = chance[0] = average(brdf->kd);
    for (int i = 0; i < brdf->lobe_count; i++)
        sum += chance[1 + i] = cos_o > 0 ? lobe_share(&brdf->lobes[i], cos_o) : 0;
    if (sum > 0)
        for (int i = 0; i <= brdf->lobe_count; i++) chance[i] /= sum;
    return 1 + brdf->lobe_count;
}

rgb brdf_eval_pdf(const struct brdf *brdf, float3 n, float3 wo, float3 wi, float *pdf)
{
    float cos_i = dot(n, wi), chance[3], one;
    *pdf = 0;
    if (cos_i <= 0) return (rgb){0};
    choices(brdf, dot(n, wo), chance);
    rgb f = scale(brdf->kd, 1 / PI);
    *pdf = chance[0] * cos_i / PI;
    for (int i = 0; i < brdf->lobe_count; i++) {
        f = add(f, lobe_both(&brdf->lobes[i], n, wo, wi, &one));
        *pdf += chance[1 + i] * one;
    }
    return f;
}

rgb brdf_eval(const struct brdf *brdf, float3 n, float3 wo, float3 wi)
{
    if (dot(n, wi) <= 0) return (rgb){0};
    float pdf;
    rgb f = scale(brdf->kd, 1 / PI);
    for (int i = 0; i < brdf->lobe_count; i++) f = add(f, lobe_both(&brdf->lobes[i], n, wo, wi, &pdf));
    return f;
}

float brdf_pdf(const struct brdf *brdf, float3 n, float3 wo, float3 wi)
{
    float pdf;
    brdf_eval_pdf(brdf, n, wo, wi, &pdf);
    return pdf;
}

static inline float3 lobe_direction(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2])
{
    if (lobe->type != LOBE_PHONG) return ggx_sample(lobe, n, wo, u);
    float c = powf(1 - u[0], 1 / (lobe->exponent + 1)), s = sqrtf(maxf(1 - c * c, 0)), phi = 2 * PI * u[1];
    return to_world(frame_about(reflect(wo, n)), vec3(s * cosf(phi), s * sinf(phi), c));
}

rgb brdf_sample(const struct brdf *brdf, float3 n, float3 wo, const float u[static 3], float3 *wi, float *pdf)
{
    float chance[3], x = u[0];
    int count = choices(brdf, dot(n, wo), chance), i = 0;
    while (i < count - 1 && x >= chance[i]) x -= chance[i++];
    *pdf = 0;
    if (chance[i] <= 0) return (rgb){0};
    *wi = i == 0 ? cosine_direction(n, u + 1) : lobe_direction(&brdf->lobes[i - 1], n, wo, u + 1);
    rgb f = brdf_eval_pdf(brdf, n, wo, *wi, pdf);
    return *pdf > 0 ? scale(f, dot(n, *wi) / *pdf) : (rgb){0};
}

rgb lobe_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi)
{
    float pdf;
    return lobe_both(lobe, n, wo, wi, &pdf);
}

rgb lobe_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2], float3 *wi, float *pdf)
{
    *pdf = 0;
    if (dot(n, wo) <= 0) return (rgb){0};
    *wi = lobe_direction(lobe, n, wo, u);
    rgb f = lobe_both(lobe, n, wo, *wi, pdf);
    return *pdf > 0 ? scale(f, dot(n, *wi) / *pdf) : (rgb){0};
}

float lobe_pdf(const struct lobe *lobe, float3 n, float3 wo, float3 wi)
{
    float pdf;
    lobe_both(lobe, n, wo, wi, &pdf);
    return pdf;
}

float lobe_width(const struct lobe *lobe)
{
    float n = lobe->type == LOBE_PHONG ? lobe->exponent : (2 / sqr(minf(lobe->alpha_x, lobe->alpha_y)) - 2) / 4;
    return acosf(n > 0 ? expf(-1 / n) : 0);
}
