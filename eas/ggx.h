/* SPDX-License-Identifier: Apache-2.0 */
/* The microfacet lobes of brdf.h: GGX, Walter et al. 2007, with two alphas and the height-correlated Smith term of
 * Heitz 2014, sampled by visible normals (Heitz 2018; Dupuy and Benyoub 2023), or Beckmann's distribution
 * (eas/beckmann.h); reflecting under the two Fresnel curves of Cycles' Principled BSDF, or refracting; and the albedos
 * that its energy compensation and layering look up (ggx_albedo.c).
 *
 * wi, wo, n as in brdf.h. Everything but the look-ups is a pure function; those fill their tables at the first call
 * (some 20 ms, once a process; glass's some 130). Any thread may call any of it.
 */
#ifndef EAS_GGX_H
#define EAS_GGX_H

#include "eas/brdf.h"

/* Below this alpha a lobe is a mirror to all eyes, and single precision can't tell its width from 0. */
#define GGX_ALPHA_MIN 1e-4f

/* The two alphas of Cycles' Principled BSDF: anisotropic, 0 to 1, makes the lobe longer along the tangent. */
static inline float2 ggx_alphas(float roughness, float anisotropic)
{
    float alpha = sqr(roughness), aspect = sqrtf(1 - 0.9f * anisotropic);
    return (float2){clampf(alpha / aspect, GGX_ALPHA_MIN, 1), clampf(alpha * aspect, GGX_ALPHA_MIN, 1)};
}

/* That of the isotropic lobe which stands in for one. */
static inline float ggx_mean_alpha(const struct lobe *lobe) { return sqrtf(lobe->alpha_x * lobe->alpha_y); }

/* The frame of a lobe's alphas about n: its tangent, or any where they are equal. */
struct frame ggx_frame(const struct lobe *lobe, float3 n);

/* f of a reflecting lobe, weight included, and in *pdf the density of ggx_sample. n.wi and n.wo must be above 0. */
rgb ggx_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf);

/* The same of a refracting one. n.wi must be below 0. */
rgb ggx_eval_refracted(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf);

/* wi by the visible normals seen from wo; it may lie on the wrong side of n, always where reflection is total. */
float3 ggx_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2]);

/* A visible normal seen from w, both in the frame where n is z: uniform in the cap that the stretched w sees. */
float3 ggx_visible_normal(float alpha_x, float alpha_y, float3 w, const float u[static 2]);

/* wo refracted by a facet h (h.wo > 0) into a relative index of eta; wo itself where reflection is total. */
float3 ggx_refract(float3 wo, float3 h, float eta);

/* Smith's Lambda (Heitz 2014, eq. 72) from the squared tangent of a direction stretched by the alphas; that tangent of
 * an isotropic lobe at cosine c. */
static inline float ggx_lambda(float stretched) { return 0.5f * (sqrtf(1 + stretched) - 1); }
static inline float ggx_tan2(float alpha2, float c) { return alpha2 * maxf(1 / (c * c) - 1, 0); }

/* Fresnel reflectance of a reflecting lobe's microfacets at cosine c, transmittance of a refracting one's. */
rgb ggx_fresnel(const struct lobe *lobe, float c);
rgb ggx_transmittance(const struct lobe *lobe, float c);

/* METAL: the factor b of cos (1-cos)^6 that is taken from Schlick's curve. */
rgb ggx_f82_dip(rgb f0, rgb f82);

/* The same in two steps, so that means over microfacets can be taken in between: what the two curves are made of. */
struct ggx_terms {
    float dielectric, schlick, dip; /* the unpolarised reflectance; (1-c)^5; c (1-c)^6 */
};
static inline struct ggx_terms ggx_fresnel_terms(const struct lobe *lobe, float c);
rgb ggx_fresnel_from(const struct lobe *lobe, struct ggx_terms terms);

/* Reflectance at normal incidence. */
static inline float ggx_f0(float eta) { return sqr((eta - 1) / (eta + 1)); }

/* Unpolarised reflectance of a dielectric of relative index eta at cosine c. */
static inline float ggx_fresnel_dielectric(float c, float eta)
{
    c = fabsf(c);
    float g2 = eta * eta - 1 + c * c, g = sqrtf(g2);
    float a = (g - c) / (g + c), b = (c * (g + c) - 1) / (c * (g - c) + 1);
    return g2 <= 0 ? 1 : 0.5f * a * a * (1 + b * b);
}

/* How far a dielectric's reflectance has gone from that at normal incidence, 0, to that at grazing, 1. */
static inline float ggx_share(float reflectance, float eta)
{
    float f0 = ggx_f0(eta);
    return clampf((reflectance - f0) / (1 - f0), 0, 1);
}

static inline struct ggx_terms ggx_fresnel_terms(const struct lobe *lobe, float c)
{
    float m = clampf(1 - c, 0, 1), m5 = m * m * m * m * m;
    return (struct ggx_terms){ggx_fresnel_dielectric(c, lobe->ior), m5, c * m5 * m};
}

/* Cycles' look-ups, on its grids (their interpolation error is part of its materials). roughness is sqrt(alpha).
 * The directional albedo of GGX with F = 1 at cosine mu, and its cosine-weighted mean. */
float ggx_albedo(float roughness, float mu);
float ggx_albedo_mean(float roughness);

/* How far the dielectric lobe's Fresnel factor, averaged over visible normals, has gone from f0 to 1. */
float ggx_fresnel_share(float roughness, float mu, float eta);

/* The directional albedo of white glass, both sides, and in *mean its cosine-weighted mean. */
float ggx_glass_albedo(float roughness, float mu, float eta, float *mean);

#endif
