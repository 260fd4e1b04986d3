/* SPDX-License-Identifier: Apache-2.0 */
/* The GGX lobes of brdf.h: Walter et al. 2007, with two alphas and the height-correlated Smith term of Heitz 2014,
 * sampled by visible normals (Heitz 2018; Dupuy and Benyoub 2023), under the two Fresnel curves of Cycles' Principled
 * BSDF; and the albedos that its energy compensation and layering look up.
 *
 * wi, wo, n as in brdf.h. Everything but the look-ups is a pure function; those fill their tables at the first call
 * (some 20 ms, once a process). Any thread may call any of it.
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

/* f of a GGX lobe, weight included, and in *pdf the density of ggx_sample. n.wi and n.wo must be above 0. */
rgb ggx_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf);

/* wi by the visible normals seen from wo; it may lie below the horizon. */
float3 ggx_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2]);

/* Fresnel reflectance of the lobe's microfacets at cosine c. */
rgb ggx_fresnel(const struct lobe *lobe, float c);

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

#endif
