/* SPDX-License-Identifier: Apache-2.0 */
/* Reflectance at a point: a diffuse part and at most two glossy lobes.
 *
 * wi points to the light, wo to the viewer; both leave the surface, unit, world space; n is the unit shading normal.
 * f is the BRDF in 1/sr, without the cosine, 0 where wi is below n's horizon; lobes are 0 too where wo is. pdf is per
 * solid angle of wi.
 * Everything is a value: any thread may call any of it.
 */
#ifndef EAS_BRDF_H
#define EAS_BRDF_H

#include "eas/vec.h"

enum lobe_type {
    LOBE_PHONG,      /* modified Phong: (n+2)/2pi cos^n alpha, alpha from the mirror direction of wo */
    LOBE_DIELECTRIC, /* GGX under Principled's specular Fresnel, f0 to 1 with the true dielectric curve */
    LOBE_METAL       /* GGX under the F82-tint Fresnel */
};

struct lobe {
    enum lobe_type type;
    rgb weight;             /* factor: ks for Phong; compensation and layering included for GGX */
    float exponent;         /* PHONG: n */
    float alpha_x, alpha_y; /* GGX: roughness squared along the tangent and across it, GGX_ALPHA_MIN to 1 */
    float3 tangent;         /* GGX: where the two differ: any direction but n's, its part at right angles to n counts */
    float ior;              /* DIELECTRIC: the curve that leads from f0 to 1 */
    rgb f0, f82;            /* GGX: reflectance at normal incidence; METAL: factor on Schlick's curve at 82 degrees */
};

struct brdf {
    rgb kd; /* diffuse albedo: f = kd/pi */
    int lobe_count;
    struct lobe lobes[2];
};

/* Principled's parameters at a point, as in import/FORMAT.md. */
struct principled {
    rgb base_colour, specular_tint;
    float metallic, roughness, ior, specular_level;
};

/* Modified Phong (Lafortune and Willems 1994): f = kd/pi + ks (n+2)/2pi cos^n alpha. */
struct brdf brdf_phong(rgb kd, rgb ks, float exponent);

/* Cycles 4.5's Principled BSDF for a viewer at cos_o = n.wo (> 0): the dielectric lobe's directional albedo takes from
 * the diffuse base, and GGX energy lost to multiple scattering is put back (Turquin 2019, as Cycles does it); both
 * depend on the viewer, so the value is good for this wo only. */
struct brdf brdf_principled(const struct principled *principled, float cos_o);

rgb brdf_eval(const struct brdf *brdf, float3 n, float3 wo, float3 wi);

/* brdf_eval and, in *pdf, brdf_pdf, at the price of one. */
rgb brdf_eval_pdf(const struct brdf *brdf, float3 n, float3 wo, float3 wi, float *pdf);

/* Samples wi by one of diffuse and lobes, chosen by their albedo, so that f cos / pdf is bounded. u: three numbers in
 * [0, 1). Returns f cos / pdf (the weight of the path) and the pdf of brdf_pdf; black where no direction came. */
rgb brdf_sample(const struct brdf *brdf, float3 n, float3 wo, const float u[static 3], float3 *wi, float *pdf);
float brdf_pdf(const struct brdf *brdf, float3 n, float3 wo, float3 wi);

/* The same for one lobe alone. lobe_sample returns f cos / pdf; black and pdf 0 where wi fell below the horizon. */
rgb lobe_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi);
rgb lobe_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2], float3 *wi, float *pdf);
float lobe_pdf(const struct lobe *lobe, float3 n, float3 wo, float3 wi);

/* Half-width of the lobe in radians: where Phong has fallen to 1/e; for GGX that of the Phong lobe alike near its peak
 * (n = 2/alpha^2 - 2 about the half vector, a quarter of it about the mirror direction), of the smaller alpha. */
float lobe_width(const struct lobe *lobe);

#endif
