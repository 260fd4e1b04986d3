/* SPDX-License-Identifier: Apache-2.0 */
/* Reflectance at a point: diffuse parts and a few glossy lobes, which reflect or, in glass, refract.
 *
 * wi points to the light, wo to the viewer; both leave the surface, unit, world space; n is the unit shading normal.
 * f is the BSDF in 1/sr, without the cosine. Light from the viewer's side of n is reflected, that from the other side
 * transmitted; lobes are 0 where wo is below n's horizon. As in Cycles, radiance isn't scaled by the square of the
 * index where it is refracted. pdf is per solid angle of wi.
 * Everything is a value: any thread may call any of it.
 */
#ifndef EAS_BRDF_H
#define EAS_BRDF_H

#include "eas/vec.h"

enum lobe_type {
    LOBE_PHONG,           /* modified Phong: (n+2)/2pi cos^n alpha, alpha from the mirror direction of wo */
    LOBE_DIELECTRIC,      /* microfacets under Principled's specular Fresnel, f0 to 1 with the true dielectric curve */
    LOBE_METAL,           /* microfacets under the F82-tint Fresnel */
    LOBE_REFRACTION,      /* below n: what a DIELECTRIC lobe's microfacets don't reflect */
    LOBE_BARE_REFRACTION, /* below n: all, but where reflection would be total */
    LOBE_ASHIKHMIN,       /* Ashikhmin and Shirley 2000, without Fresnel */
    LOBE_SHEEN            /* Zeltner et al. 2022 */
};

struct lobe {
    enum lobe_type type;
    rgb weight;             /* factor: ks for Phong; compensation, layering and albedo included for the others */
    float exponent;         /* PHONG: n */
    float alpha_x, alpha_y; /* roughness squared along the tangent and across it, GGX_ALPHA_MIN to 1 */
    float3 tangent;         /* where the two differ: any direction but n's, its part at right angles to n counts */
    float ior;              /* DIELECTRIC, REFRACTION: the index beyond n over that on the viewer's side */
    rgb f0, f82;            /* reflectance at normal incidence; METAL: factor on Schlick's curve at 82 degrees */
    float2 ltc;             /* SHEEN: the linear transformation */
    bool beckmann;          /* microfacets: Beckmann's distribution; else GGX */
};

#define BRDF_LOBES 6

struct brdf {
    rgb kd;      /* diffuse albedo: f = kd/pi (1 + flat + tilt t), t as in brdf_diffuse */
    float flat, tilt; /* 0: Lambert */
    /* Where a texture bends the normal: the mesh's, which shadows diffuse reflection (brdf.c), and the bent one, which
     * diffuse reflection goes by. 0: n is the mesh's. */
    float3 unbent, bent;
    rgb kt;      /* diffuse transmission: f = kt/pi for wi on the other side */
    rgb through; /* share that passes straight on, which no function here samples; 0: opaque */
    int lobe_count;
    struct lobe lobes[BRDF_LOBES];
};

/* GGX: Walter et al. 2007. MULTI_GGX: with what multiple scattering adds (Turquin 2019). */
enum distribution { DISTRIBUTION_GGX, DISTRIBUTION_MULTI_GGX, DISTRIBUTION_BECKMANN, DISTRIBUTION_ASHIKHMIN_SHIRLEY };

/* Principled's parameters at a point, as in import/FORMAT.md. tangent: world, unit, turned by the rotation. */
struct principled {
    rgb base_colour, specular_tint;
    float metallic, roughness, ior, specular_level;
    float anisotropy;
    float3 tangent;
    float transmission;
    float coat_weight, coat_roughness, coat_ior;
    rgb coat_tint;
    float sheen_weight, sheen_roughness;
    rgb sheen_tint;
    enum distribution distribution; /* GGX or MULTI_GGX */
};

/* Anisotropy -1 to 1; tangent as above, where it isn't 0. */
struct glossy {
    rgb colour;
    float roughness, anisotropy;
    float3 tangent;
    enum distribution distribution;
};

/* ior: of the inside, behind the faces' front. */
struct glass {
    rgb colour;
    float roughness, ior;
    enum distribution distribution; /* any but ASHIKHMIN_SHIRLEY; refraction: GGX or BECKMANN */
};

/* The reflectances below are those of Cycles 4.5, for a viewer at cos_o = n.wo (> 0), who stands at the faces' front or
 * back; they depend on the viewer, so a value is good for this wo only. */

/* Modified Phong (Lafortune and Willems 1994): f = kd/pi + ks (n+2)/2pi cos^n alpha. */
struct brdf brdf_phong(rgb kd, rgb ks, float exponent);

/* Diffuse; roughness above 0: Oren-Nayar (Fujii's, with OpenPBR's multiple scattering, here of Lambert's shape), which
 * goes by t = wi.wo - cos_i cos_o, where above 0 over the greater cosine. kd is its albedo for this viewer, all that
 * caches take of it. */
struct brdf brdf_diffuse(rgb colour, float roughness, float cos_o);

/* The Principled BSDF: layers take the directional albedo of those above them, and GGX energy lost to multiple
 * scattering is put back. */
struct brdf brdf_principled(const struct principled *principled, float cos_o, bool front);

struct brdf brdf_glossy(const struct glossy *glossy, float cos_o);

/* Glass: reflection and refraction by Fresnel. An index of 1 bends nothing: `through`. */
struct brdf brdf_glass(const struct glass *glass, float cos_o, bool front);

/* Refraction without Fresnel; black where reflection is total. */
struct brdf brdf_refraction(const struct glass *glass, bool front);

/* Microfibres (Zeltner et al. 2022) by S. Hill's closed form of the paper's tables (eas/sheen.h has the error). */
struct brdf brdf_sheen(rgb colour, float roughness, float cos_o);

/* Black. The lobes are left as they are: there are none. */
static inline void brdf_clear(struct brdf *brdf)
{
    brdf->kd = brdf->kt = brdf->through = (rgb){0};
    brdf->flat = brdf->tilt = 0;
    brdf->unbent = brdf->bent = (float3){0};
    brdf->lobe_count = 0;
}

/* sum += part x weight. Of more than BRDF_LOBES lobes the weakest becomes diffuse, so that no energy is lost. */
void brdf_add(struct brdf *sum, const struct brdf *part, rgb weight);

static inline bool lobe_transmits(const struct lobe *lobe)
{
    return lobe->type == LOBE_REFRACTION || lobe->type == LOBE_BARE_REFRACTION;
}

/* Whether light may come from the other side but straight through. */
static inline bool brdf_transmits(const struct brdf *brdf)
{
    bool any = !is_black(brdf->kt);
    for (int i = 0; i < brdf->lobe_count; i++) any = any || lobe_transmits(&brdf->lobes[i]);
    return any;
}

/* The same, spread so widely that lamps there are worth a shadow ray: what clear glass lets pass is found by following
 * it, and no more than 1e-4 of it otherwise. */
static inline bool brdf_spreads(const struct brdf *brdf)
{
    bool any = !is_black(brdf->kt);
    for (int i = 0; i < brdf->lobe_count; i++)
        any = any || (lobe_transmits(&brdf->lobes[i]) && brdf->lobes[i].alpha_x > 1e-3f);
    return any;
}

/* How often a path should go straight on: the share of `through`, which isn't black, in all that goes on. */
float brdf_pass_chance(const struct brdf *brdf, float cos_o);

rgb brdf_eval(const struct brdf *brdf, float3 n, float3 wo, float3 wi);

/* brdf_eval and, in *pdf, brdf_pdf, at the price of one. */
rgb brdf_eval_pdf(const struct brdf *brdf, float3 n, float3 wo, float3 wi, float *pdf);

/* Samples wi, on either side, by one of the diffuse parts and lobes, chosen by their albedo, so that f cos / pdf is
 * bounded. u: three numbers in [0, 1). Returns f |cos| / pdf (the weight of the path) and the pdf of brdf_pdf; black
 * where no direction came. */
rgb brdf_sample(const struct brdf *brdf, float3 n, float3 wo, const float u[static 3], float3 *wi, float *pdf);
float brdf_pdf(const struct brdf *brdf, float3 n, float3 wo, float3 wi);

/* The same for one lobe alone. lobe_sample returns f |cos| / pdf; black and pdf 0 where wi fell on the other side. */
rgb lobe_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi);
rgb lobe_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2], float3 *wi, float *pdf);
float lobe_pdf(const struct lobe *lobe, float3 n, float3 wo, float3 wi);

/* About the lobe's albedo for a viewer at cos_o: how often it should be sampled. */
rgb lobe_albedo(const struct lobe *lobe, float cos_o);

/* Half-width of the lobe in radians: where Phong has fallen to 1/e; for microfacets that of the Phong lobe alike near
 * its peak (n = 2/alpha^2 - 2 about the half vector, a quarter of it about the mirror direction), of the smaller alpha.
 */
float lobe_width(const struct lobe *lobe);

#endif
