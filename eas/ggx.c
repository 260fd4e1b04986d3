/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/ggx.h"

#include "eas/beckmann.h"

static inline float saturate(float x) { return clampf(x, 0, 1); }

/* Smith's Lambda from the squared tangent of a direction stretched by the alphas. */
static inline float lambda(const struct lobe *lobe, float stretched)
{
    return lobe->beckmann ? beckmann_lambda(stretched) : ggx_lambda(stretched);
}
/* That tangent of any direction in the lobe's frame. */
static inline float stretched_tan2(const struct lobe *lobe, float3 w)
{
    return (sqr(lobe->alpha_x * w.x) + sqr(lobe->alpha_y * w.y)) / sqr(w.z);
}

/* Kutz et al. 2021, "Novel aspects of the Adobe Standard Material": Schlick less b cos (1-cos)^6, with b such that the
 * factor at cos = 1/7 is f82. */
rgb ggx_f82_dip(rgb f0, rgb f82)
{
    const rgb white = {1, 1, 1};
    const float edge = 6.0f / 7, edge5 = edge * edge * edge * edge * edge;
    return scale(mul(lerp3(f0, white, edge5), sub(white, f82)), 7 / (edge5 * edge));
}

rgb ggx_fresnel_from(const struct lobe *lobe, struct ggx_terms terms)
{
    const rgb white = {1, 1, 1};
    if (lobe->type == LOBE_DIELECTRIC) return lerp3(lobe->f0, white, ggx_share(terms.dielectric, lobe->ior));
    rgb f = mad(lerp3(lobe->f0, white, terms.schlick), ggx_f82_dip(lobe->f0, lobe->f82), -terms.dip);
    return vec3(saturate(f.x), saturate(f.y), saturate(f.z));
}

rgb ggx_fresnel(const struct lobe *lobe, float c) { return ggx_fresnel_from(lobe, ggx_fresnel_terms(lobe, c)); }

struct frame ggx_frame(const struct lobe *lobe, float3 n)
{
    if (lobe->alpha_x == lobe->alpha_y) return frame_about(n);
    float3 b = normalize(cross(n, lobe->tangent));
    return (struct frame){cross(b, n), b, n};
}

rgb ggx_transmittance(const struct lobe *lobe, float c)
{
    float f = ggx_fresnel_dielectric(c, lobe->ior);
    const rgb white = {1, 1, 1};
    if (lobe->type == LOBE_BARE_REFRACTION) return f < 1 ? white : (rgb){0};
    return scale(sub(white, lobe->f0), 1 - ggx_share(f, lobe->ior));
}

/* The density of normals, h not of unit length, and Smith's Lambda of both directions. */
struct facets {
    float d, lambda_i, lambda_o;
};

static inline struct facets facets(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float3 h, float h2)
{
    struct facets f;
    if (lobe->alpha_x == lobe->alpha_y) {
        float alpha2 = sqr(lobe->alpha_x);
        /* The sine from the cross product: 1 - cos^2 would lose a narrow lobe's width in rounding. */
        float3 perpendicular = cross(n, h);
        float sin2 = dot(perpendicular, perpendicular) / h2, cos2 = sqr(dot(n, h)) / h2;
        f.d = lobe->beckmann ? beckmann_d(sin2 / (alpha2 * cos2), cos2) / alpha2
                             : alpha2 / (PI * sqr(sin2 + alpha2 * cos2));
        f.lambda_i = lambda(lobe, ggx_tan2(alpha2, dot(n, wi)));
        f.lambda_o = lambda(lobe, ggx_tan2(alpha2, dot(n, wo)));
    } else { /* Heitz 2014: the isotropic lobe, stretched */
        struct frame frame = ggx_frame(lobe, n);
        float3 slope = to_local(frame, h);
        slope.x /= lobe->alpha_x, slope.y /= lobe->alpha_y;
        float area = lobe->alpha_x * lobe->alpha_y;
        f.d = lobe->beckmann ? beckmann_d((sqr(slope.x) + sqr(slope.y)) / sqr(slope.z), sqr(slope.z) / h2) / area
                             : sqr(h2 / dot(slope, slope)) / (PI * area);
        f.lambda_i = lambda(lobe, stretched_tan2(lobe, to_local(frame, wi)));
        f.lambda_o = lambda(lobe, stretched_tan2(lobe, to_local(frame, wo)));
    }
    return f;
}

rgb ggx_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf)
{
    float cos_i = dot(n, wi), cos_o = dot(n, wo);
    float3 h = add(wi, wo);
    float h2 = dot(h, h);
    struct facets f = facets(lobe, n, wo, wi, h, h2);
    *pdf = f.d / (4 * cos_o * (1 + f.lambda_o));
    rgb fresnel = ggx_fresnel(lobe, dot(h, wo) / sqrtf(h2));
    return mul(lobe->weight, scale(fresnel, f.d / (4 * cos_i * cos_o * (1 + f.lambda_i + f.lambda_o))));
}

/* Walter et al. 2007, eq. 16, 17 and 21, with the viewer where they have the light, and without the square of the
 * index that radiance would be scaled by: what arrives from all directions then adds up to the transmittance. */
rgb ggx_eval_refracted(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf)
{
    float cos_i = -dot(n, wi), cos_o = dot(n, wo);
    float3 h = mad(wo, wi, lobe->ior);
    if (dot(h, n) < 0) h = scale(h, -1);
    float h2 = dot(h, h), h_o = dot(h, wo), h_i = -dot(h, wi); /* both times h's length */
    *pdf = 0;
    if (h_o <= 0 || h_i <= 0) return (rgb){0};
    struct facets f = facets(lobe, n, wo, wi, h, h2);
    float common = f.d * h_o * h_i * sqr(lobe->ior) / (cos_o * sqr(h2));
    *pdf = common / (1 + f.lambda_o);
    rgb passed = ggx_transmittance(lobe, h_o / sqrtf(h2));
    return mul(lobe->weight, scale(passed, common / (cos_i * (1 + f.lambda_i + f.lambda_o))));
}

float3 ggx_visible_normal(float alpha_x, float alpha_y, float3 w, const float u[static 2])
{
    float3 s = normalize(vec3(alpha_x * w.x, alpha_y * w.y, w.z));
    float phi = 2 * PI * u[0], z = (1 - u[1]) * (1 + s.z) - s.z, r = sqrtf(saturate(1 - z * z));
    float3 h = add(vec3(r * cosf(phi), r * sinf(phi), z), s);
    return normalize(vec3(alpha_x * h.x, alpha_y * h.y, maxf(h.z, 0)));
}

float3 ggx_refract(float3 wo, float3 h, float eta)
{
    float c = dot(wo, h), cos2 = 1 - (1 - c * c) / sqr(eta);
    return cos2 > 0 ? mad(scale(h, c / eta - sqrtf(cos2)), wo, -1 / eta) : wo;
}

float3 ggx_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2])
{
    struct frame frame = ggx_frame(lobe, n);
    float3 w = to_local(frame, wo);
    float3 h = to_world(frame, lobe->beckmann ? beckmann_visible_normal(lobe->alpha_x, lobe->alpha_y, w, u)
                                              : ggx_visible_normal(lobe->alpha_x, lobe->alpha_y, w, u));
    return lobe_transmits(lobe) ? ggx_refract(wo, h, lobe->ior) : reflect(wo, h);
}
