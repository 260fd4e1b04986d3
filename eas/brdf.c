/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/brdf.h"

#include "eas/ashikhmin.h"
#include "eas/ggx.h"
#include "eas/sheen.h"

static inline float average(rgb c) { return (c.x + c.y + c.z) / 3; }

static inline float phong_pdf(float exponent, float3 n, float3 wo, float3 wi, float *power)
{
    float c = dot(reflect(wo, n), wi);
    *power = c > 0 ? powf(c, exponent) : 0;
    return (exponent + 1) / (2 * PI) * *power;
}

/* f and pdf of a lobe; 0 where wi or wo is on the wrong side. Phong's pdf goes on below the horizon. */
static inline rgb lobe_both(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf)
{
    *pdf = 0;
    float cos_i = dot(n, wi);
    if (dot(n, wo) <= 0 || (lobe_transmits(lobe) ? cos_i >= 0 : cos_i <= 0)) return (rgb){0};
    switch (lobe->type) {
    case LOBE_PHONG: break;
    case LOBE_DIELECTRIC:
    case LOBE_METAL: return ggx_eval(lobe, n, wo, wi, pdf);
    case LOBE_REFRACTION:
    case LOBE_BARE_REFRACTION: return ggx_eval_refracted(lobe, n, wo, wi, pdf);
    case LOBE_ASHIKHMIN: return ashikhmin_eval(lobe, n, wo, wi, pdf);
    case LOBE_SHEEN: return sheen_eval(lobe, n, wo, wi, pdf);
    }
    float power;
    *pdf = phong_pdf(lobe->exponent, n, wo, wi, &power);
    return scale(lobe->weight, (lobe->exponent + 2) / (2 * PI) * power);
}

/* The share of light that a microfacet at cosine c sends on. */
static inline rgb facet_albedo(const struct lobe *lobe, float c)
{
    return lobe_transmits(lobe) ? ggx_transmittance(lobe, c) : ggx_fresnel(lobe, c);
}

rgb lobe_albedo(const struct lobe *lobe, float cos_o)
{
    bool dielectric = lobe->type == LOBE_DIELECTRIC || lobe_transmits(lobe);
    if (lobe->type == LOBE_METAL || (dielectric && lobe->ior >= 1)) return mul(lobe->weight, facet_albedo(lobe, cos_o));
    if (!dielectric) return lobe->weight;
    /* Inside glass all changes to none within the tilt of the facets: the mean over some tilts. */
    float alpha = lobe->alpha_x, s = sqrtf(1 - minf(sqr(cos_o), 1)), tilted = 1 / sqrtf(1 + sqr(alpha));
    float near = clampf((cos_o + s * alpha) * tilted, 0, 1), far = clampf((cos_o - s * alpha) * tilted, 0, 1);
    rgb sum = mad(add(facet_albedo(lobe, near), facet_albedo(lobe, far)), facet_albedo(lobe, cos_o), 2);
    /* Never so little that nothing would sample the lobe's tail. */
    float least = minf(alpha, .05f);
    return mul(lobe->weight, vec3(maxf(sum.x / 4, least), maxf(sum.y / 4, least), maxf(sum.z / 4, least)));
}

enum { REFLECTED, TRANSMITTED, LOBES, CHOICES = LOBES + BRDF_LOBES };

/* The chances of the diffuse parts and the lobes; all 0 for a black surface. */
static inline int choices(const struct brdf *brdf, float cos_o, float chance[static CHOICES])
{
    chance[REFLECTED] = average(brdf->kd);
    chance[TRANSMITTED] = average(brdf->kt);
    float sum = chance[REFLECTED] + chance[TRANSMITTED];
    int count = LOBES + brdf->lobe_count;
    for (int i = 0; i < brdf->lobe_count; i++)
        sum += chance[LOBES + i] = cos_o > 0 ? average(lobe_albedo(&brdf->lobes[i], cos_o)) : 0;
    if (sum > 0)
        for (int i = 0; i < count; i++) chance[i] /= sum;
    return count;
}

/* What bumps around leave of the light from wi at a place of normal n on a surface of normal unbent: the shadowing of
 * microfacets of a roughness that goes with the bend (Estevez, Lecocq and Stein 2019), as in Cycles. */
static inline float bump_light(float3 unbent, float3 n, float3 wi)
{
    float level = dot(unbent, wi), bend = dot(unbent, n);
    if (level <= 0 || bend <= 0) return 0;
    float alpha2 = 0.125f * maxf(1 / sqr(bend) - 1, 0), tan2 = maxf(1 / sqr(level) - 1, 0);
    return 2 / (1 + sqrtf(1 + alpha2 * tan2));
}

static inline bool is_bent(const struct brdf *brdf) { return dot(brdf->unbent, brdf->unbent) > 0; }

/* The normal of diffuse reflection: n may have been pulled for the lobes' mirror directions. */
static inline float3 diffuse_normal(const struct brdf *brdf, float3 n) { return is_bent(brdf) ? brdf->bent : n; }

/* f of the diffuse parts. */
static inline rgb diffuse(const struct brdf *brdf, float3 n, float3 wo, float3 wi)
{
    if (dot(n, wi) <= 0) return scale(brdf->kt, 1 / PI);
    float3 own = diffuse_normal(brdf, n);
    float cos_i = maxf(dot(own, wi), 0), cos_o = dot(own, wo), factor = 1 / PI;
    if (is_bent(brdf)) factor *= bump_light(brdf->unbent, own, wi) * cos_i / dot(n, wi);
    if (brdf->tilt == 0 || cos_i == 0) return scale(brdf->kd, factor);
    float t = dot(wi, wo) - cos_i * cos_o;
    if (t > 0) t /= maxf(cos_i, cos_o);
    return scale(brdf->kd, maxf(1 + brdf->flat + brdf->tilt * t, 0) * factor);
}

/* f and pdf, the chances being known. */
static inline rgb both(const struct brdf *brdf, const float chance[static CHOICES], float3 n, float3 wo, float3 wi,
                       float *pdf)
{
    float cos_i = dot(n, wi), one;
    rgb f = diffuse(brdf, n, wo, wi);
    *pdf = cos_i > 0 ? chance[REFLECTED] * maxf(dot(diffuse_normal(brdf, n), wi), 0) / PI
                     : chance[TRANSMITTED] * -cos_i / PI;
    for (int i = 0; i < brdf->lobe_count; i++) {
        f = add(f, lobe_both(&brdf->lobes[i], n, wo, wi, &one));
        *pdf += chance[LOBES + i] * one;
    }
    return f;
}

rgb brdf_eval_pdf(const struct brdf *brdf, float3 n, float3 wo, float3 wi, float *pdf)
{
    float chance[CHOICES];
    choices(brdf, dot(n, wo), chance);
    return both(brdf, chance, n, wo, wi, pdf);
}

rgb brdf_eval(const struct brdf *brdf, float3 n, float3 wo, float3 wi)
{
    float pdf;
    rgb f = diffuse(brdf, n, wo, wi);
    for (int i = 0; i < brdf->lobe_count; i++) f = add(f, lobe_both(&brdf->lobes[i], n, wo, wi, &pdf));
    return f;
}

float brdf_pdf(const struct brdf *brdf, float3 n, float3 wo, float3 wi)
{
    float pdf;
    brdf_eval_pdf(brdf, n, wo, wi, &pdf);
    return pdf;
}

float brdf_pass_chance(const struct brdf *brdf, float cos_o)
{
    float through = average(brdf->through), rest = average(add(brdf->kd, brdf->kt));
    for (int i = 0; i < brdf->lobe_count; i++) rest += average(lobe_albedo(&brdf->lobes[i], maxf(cos_o, 0)));
    return through / (through + rest);
}

void brdf_add(struct brdf *sum, const struct brdf *part, rgb weight)
{
    rgb kd = mul(part->kd, weight);
    if (sum->tilt != 0 || part->tilt != 0) { /* the mean by albedo */
        float before = average(sum->kd), added = average(kd), share = added > 0 ? added / (before + added) : 0;
        sum->flat += (part->flat - sum->flat) * share;
        sum->tilt += (part->tilt - sum->tilt) * share;
    }
    sum->kd = add(sum->kd, kd);
    sum->kt = add(sum->kt, mul(part->kt, weight));
    sum->through = add(sum->through, mul(part->through, weight));
    for (int i = 0; i < part->lobe_count; i++) {
        struct lobe lobe = part->lobes[i];
        lobe.weight = mul(lobe.weight, weight);
        if (max3(lobe.weight) <= 0) continue;
        if (sum->lobe_count < BRDF_LOBES) {
            sum->lobes[sum->lobe_count++] = lobe;
            continue;
        }
        int weakest = 0;
        for (int k = 1; k < BRDF_LOBES; k++)
            if (average(lobe_albedo(&sum->lobes[k], 1)) < average(lobe_albedo(&sum->lobes[weakest], 1))) weakest = k;
        if (average(lobe_albedo(&lobe, 1)) > average(lobe_albedo(&sum->lobes[weakest], 1))) {
            struct lobe kept = lobe;
            lobe = sum->lobes[weakest];
            sum->lobes[weakest] = kept;
        }
        rgb *diffuse = lobe_transmits(&lobe) ? &sum->kt : &sum->kd;
        *diffuse = add(*diffuse, lobe_albedo(&lobe, 1));
    }
}

static inline float3 lobe_direction(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2])
{
    if (lobe->type == LOBE_ASHIKHMIN) return ashikhmin_sample(lobe, n, wo, u);
    if (lobe->type == LOBE_SHEEN) return sheen_sample(lobe, n, wo, u);
    if (lobe->type != LOBE_PHONG) return ggx_sample(lobe, n, wo, u);
    float c = powf(1 - u[0], 1 / (lobe->exponent + 1)), s = sqrtf(maxf(1 - c * c, 0)), phi = 2 * PI * u[1];
    return to_world(frame_about(reflect(wo, n)), vec3(s * cosf(phi), s * sinf(phi), c));
}

rgb brdf_sample(const struct brdf *brdf, float3 n, float3 wo, const float u[static 3], float3 *wi, float *pdf)
{
    float chance[CHOICES], x = u[0];
    int count = choices(brdf, dot(n, wo), chance), i = 0;
    while (i < count - 1 && x >= chance[i]) x -= chance[i++];
    *pdf = 0;
    if (chance[i] <= 0) return (rgb){0};
    if (i < LOBES) *wi = cosine_direction(i == REFLECTED ? diffuse_normal(brdf, n) : scale(n, -1), u + 1);
    else *wi = lobe_direction(&brdf->lobes[i - LOBES], n, wo, u + 1);
    if (i == REFLECTED && dot(n, *wi) <= 0) return (rgb){0};
    if (i >= LOBES && lobe_transmits(&brdf->lobes[i - LOBES]) != (dot(n, *wi) < 0)) return (rgb){0};
    rgb f = both(brdf, chance, n, wo, *wi, pdf);
    return *pdf > 0 ? scale(f, fabsf(dot(n, *wi)) / *pdf) : (rgb){0};
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
    return *pdf > 0 ? scale(f, fabsf(dot(n, *wi)) / *pdf) : (rgb){0};
}

float lobe_pdf(const struct lobe *lobe, float3 n, float3 wo, float3 wi)
{
    float pdf;
    lobe_both(lobe, n, wo, wi, &pdf);
    return pdf;
}

float lobe_width(const struct lobe *lobe)
{
    if (lobe->type == LOBE_SHEEN) return PI / 2;
    float n = lobe->type == LOBE_PHONG ? lobe->exponent : (2 / sqr(minf(lobe->alpha_x, lobe->alpha_y)) - 2) / 4;
    return acosf(n > 0 ? expf(-1 / n) : 0);
}
