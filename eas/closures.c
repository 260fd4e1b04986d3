/* SPDX-License-Identifier: Apache-2.0 */
/* Cycles' closures taken apart into the lobes of brdf.h. */
#include "eas/brdf.h"
#include "eas/ggx.h"
#include "eas/sheen.h"

static inline float saturate(float x) { return clampf(x, 0, 1); }
static inline rgb saturate3(rgb c) { return vec3(saturate(c.x), saturate(c.y), saturate(c.z)); }
static const rgb white = {1, 1, 1};

/* Nearer to 1 than this an index bends nothing, as in Cycles. */
#define SAME_INDEX 1e-4f

static void add_lobe(struct brdf *brdf, struct lobe lobe)
{
    if (max3(lobe.weight) > 0) brdf->lobes[brdf->lobe_count++] = lobe;
}

struct brdf brdf_phong(rgb kd, rgb ks, float exponent)
{
    struct brdf brdf;
    brdf_clear(&brdf);
    brdf.kd = kd;
    add_lobe(&brdf, (struct lobe){.type = LOBE_PHONG, .weight = ks, .exponent = exponent});
    return brdf;
}

/* Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks", appendix: the cosine-weighted mean of the
 * dielectric Fresnel curve. */
static float fresnel_mean(float eta)
{
    if (eta < 1) return 0.997118f + eta * (0.1014f - eta * (0.965241f + eta * 0.130607f));
    return (eta - 1) / (4.08567f + 1.00071f * eta);
}

/* What multiple scattering adds to a lobe of directional albedo e with F = 1, whose Fresnel factor has the mean
 * `fresnel`, as a factor of single scattering: 1 + Fms (1-E)/E, Fms from Kulla and Conty with one bounce taken out
 * (Turquin 2019). */
static rgb compensation(float e, float mean, rgb fresnel)
{
    rgb bounced = {fresnel.x * mean / (1 - fresnel.x * (1 - mean)), fresnel.y * mean / (1 - fresnel.y * (1 - mean)),
                   fresnel.z * mean / (1 - fresnel.z * (1 - mean))};
    return mad(white, bounced, (1 - e) / e);
}

static struct lobe microfacets(enum lobe_type type, float2 alpha, float3 tangent)
{
    return (struct lobe){.type = type,
                         .weight = white,
                         .alpha_x = alpha.x,
                         .alpha_y = alpha.y,
                         .tangent = tangent,
                         .f0 = white,
                         .f82 = white};
}

/* The roughness by which the tables know a lobe. */
static inline float table_roughness(const struct lobe *lobe) { return sqrtf(ggx_mean_alpha(lobe)); }

static rgb lobe_compensation(const struct lobe *lobe, float mu, rgb fresnel)
{
    float roughness = table_roughness(lobe);
    return compensation(ggx_albedo(roughness, mu), ggx_albedo_mean(roughness), fresnel);
}

/* The reflection of a dielectric and in *albedo its directional albedo, as Cycles' layers take it: without the 1/E that
 * its lobe has. */
static struct lobe dielectric(float2 alpha, float3 tangent, float eta, rgb f0, bool multi, float mu, rgb *albedo)
{
    struct lobe lobe = microfacets(LOBE_DIELECTRIC, alpha, tangent);
    lobe.ior = eta;
    lobe.f0 = saturate3(f0);
    float roughness = table_roughness(&lobe), real = ggx_f0(eta);
    *albedo = lerp3(lobe.f0, white, ggx_fresnel_share(roughness, mu, eta));
    if (multi) {
        float share = saturate((fresnel_mean(eta) - real) / (1 - real));
        lobe.weight = lobe_compensation(&lobe, mu, lerp3(lobe.f0, white, share));
        *albedo = mul(*albedo, scale(lobe.weight, ggx_albedo(roughness, mu)));
    }
    return lobe;
}

static struct lobe metal(const struct principled *p, float2 alpha, float mu)
{
    struct lobe lobe = microfacets(LOBE_METAL, alpha, p->tangent);
    rgb tint = p->specular_tint;
    lobe.f0 = saturate3(p->base_colour);
    lobe.f82 = vec3(minf(tint.x, 1), minf(tint.y, 1), minf(tint.z, 1));
    /* The cosine-weighted mean of the F82-tint curve: Schlick's at 1/21 of the way to 1, less b/126. */
    rgb mean = mad(lerp3(lobe.f0, white, 1.0f / 21), ggx_f82_dip(lobe.f0, lobe.f82), -1.0f / 126);
    if (p->distribution == DISTRIBUTION_MULTI_GGX) lobe.weight = lobe_compensation(&lobe, mu, mean);
    return lobe;
}

/* Adds both sides of a dielectric whose tables are those of glass: reflection and refraction, each with its tint. */
static void add_glass(struct brdf *brdf, float roughness, float eta, rgb f0, rgb reflected, rgb refracted,
                      enum distribution distribution, float mu)
{
    if (fabsf(eta - 1) < SAME_INDEX) {
        brdf->through = add(brdf->through, refracted);
        return;
    }
    struct lobe lobe = microfacets(LOBE_DIELECTRIC, ggx_alphas(roughness, 0), vec3(0, 0, 0));
    lobe.beckmann = distribution == DISTRIBUTION_BECKMANN;
    lobe.ior = eta;
    lobe.f0 = saturate3(f0);
    rgb gain = white;
    if (distribution == DISTRIBUTION_MULTI_GGX && roughness > 0) {
        float mean, e = ggx_glass_albedo(roughness, mu, eta, &mean);
        gain = compensation(e, mean, refracted);
    }
    lobe.weight = mul(gain, reflected);
    add_lobe(brdf, lobe);
    lobe.type = LOBE_REFRACTION;
    lobe.weight = mul(gain, refracted);
    add_lobe(brdf, lobe);
}

static inline float relative_index(float ior, bool front)
{
    ior = maxf(ior, 1e-5f);
    return front ? ior : 1 / ior;
}

/* Takes from `base` what the layer above it sends back. */
static inline rgb under(rgb base, rgb albedo) { return scale(base, saturate(1 - max3(albedo))); }

/* Absorbed by the coat, tint at right angles, along the viewer's refracted direction (Beer's law). */
static rgb coat_tint(const struct principled *p, float mu)
{
    float depth = 1 / sqrtf(1 - (1 - mu * mu) / sqr(maxf(p->coat_ior, 1)));
    rgb tint = {powf(p->coat_tint.x, depth), powf(p->coat_tint.y, depth), powf(p->coat_tint.z, depth)};
    return lerp3(white, tint, p->coat_weight);
}

struct brdf brdf_principled(const struct principled *p, float cos_o, bool front)
{
    struct brdf brdf;
    struct lobe lobe;
    brdf_clear(&brdf);
    float metallic = saturate(p->metallic), transmission = saturate(p->transmission), mu = saturate(cos_o);
    float roughness = saturate(p->roughness);
    bool multi = p->distribution == DISTRIBUTION_MULTI_GGX;
    float2 alpha = ggx_alphas(roughness, p->anisotropy);
    rgb base = white, albedo, colour = p->base_colour;
    if (p->sheen_weight > 0) {
        lobe = sheen_lobe(p->sheen_roughness, mu);
        lobe.weight = scale(mul(lobe.weight, p->sheen_tint), p->sheen_weight);
        add_lobe(&brdf, lobe);
        base = under(base, lobe.weight);
    }
    if (p->coat_weight > 0) {
        float ior = maxf(p->coat_ior, 1), f0 = ggx_f0(ior);
        if (ior > 1) {
            lobe = dielectric(ggx_alphas(saturate(p->coat_roughness), 0), vec3(0, 0, 0), ior, vec3(f0, f0, f0), true,
                              mu, &albedo);
            lobe.weight = scale(mul(lobe.weight, base), p->coat_weight);
            add_lobe(&brdf, lobe);
            base = under(base, scale(albedo, p->coat_weight));
        }
        base = mul(base, coat_tint(p, mu));
    }
    if (metallic > 0) {
        lobe = metal(p, alpha, mu);
        lobe.weight = mul(lobe.weight, scale(base, metallic));
        add_lobe(&brdf, lobe);
        base = scale(base, 1 - metallic);
    }
    if (transmission > 0) {
        float f0 = ggx_f0(maxf(p->ior, 1e-5f));
        rgb tint = saturate3(colour), share = scale(base, transmission);
        struct brdf glass = {0};
        add_glass(&glass, roughness, relative_index(p->ior, front), scale(p->specular_tint, f0), white,
                  vec3(sqrtf(tint.x), sqrtf(tint.y), sqrtf(tint.z)), p->distribution, mu);
        brdf_add(&brdf, &glass, share);
        base = scale(base, 1 - transmission);
    }
    float eta = maxf(p->ior, 1e-5f), f0 = ggx_f0(eta);
    if (p->specular_level != 0.5f) { /* f0 scaled, and the index that has it */
        f0 *= 2 * maxf(p->specular_level, 0);
        float root = sqrtf(clampf(f0, 0, 0.99f));
        eta = p->ior < 1 ? (1 - root) / (1 + root) : (1 + root) / (1 - root);
    }
    if (max3(base) > 0 && eta != 1) {
        lobe = dielectric(alpha, p->tangent, eta, scale(p->specular_tint, f0), multi, mu, &albedo);
        lobe.weight = mul(lobe.weight, base);
        add_lobe(&brdf, lobe);
        base = under(base, albedo);
    }
    brdf.kd = mul(colour, base);
    return brdf;
}

struct brdf brdf_glossy(const struct glossy *g, float cos_o)
{
    struct brdf brdf = {0};
    float alpha = sqr(saturate(g->roughness)), stretch = clampf(g->anisotropy, -0.99f, 0.99f);
    /* Longer across the tangent where anisotropy is positive, the other way round than Principled's. */
    float across = stretch < 0 ? 1 + stretch : 1 / (1 - stretch);
    float2 alphas = {clampf(alpha / across, GGX_ALPHA_MIN, 1), clampf(alpha * across, GGX_ALPHA_MIN, 1)};
    bool ashikhmin = g->distribution == DISTRIBUTION_ASHIKHMIN_SHIRLEY;
    struct lobe lobe = microfacets(ashikhmin ? LOBE_ASHIKHMIN : LOBE_METAL, alphas, g->tangent);
    lobe.beckmann = g->distribution == DISTRIBUTION_BECKMANN;
    lobe.weight = g->colour;
    if (g->distribution == DISTRIBUTION_MULTI_GGX)
        lobe.weight = mul(lobe.weight, lobe_compensation(&lobe, saturate(cos_o), g->colour));
    add_lobe(&brdf, lobe);
    return brdf;
}

struct brdf brdf_glass(const struct glass *g, float cos_o, bool front)
{
    struct brdf brdf = {0};
    float f0 = ggx_f0(maxf(g->ior, 1e-5f));
    add_glass(&brdf, saturate(g->roughness), relative_index(g->ior, front), vec3(f0, f0, f0), g->colour, g->colour,
              g->distribution, saturate(cos_o));
    return brdf;
}

struct brdf brdf_refraction(const struct glass *g, bool front)
{
    float eta = relative_index(g->ior, front);
    if (fabsf(eta - 1) < SAME_INDEX) return (struct brdf){.through = g->colour};
    struct brdf brdf = {0};
    struct lobe lobe = microfacets(LOBE_BARE_REFRACTION, ggx_alphas(saturate(g->roughness), 0), vec3(0, 0, 0));
    lobe.beckmann = g->distribution == DISTRIBUTION_BECKMANN;
    lobe.ior = eta;
    lobe.weight = g->colour;
    add_lobe(&brdf, lobe);
    return brdf;
}

struct brdf brdf_sheen(rgb colour, float roughness, float cos_o)
{
    struct brdf brdf = {0};
    struct lobe lobe = sheen_lobe(roughness, saturate(cos_o));
    lobe.weight = mul(lobe.weight, colour);
    add_lobe(&brdf, lobe);
    return brdf;
}

/* Fujii's directional albedo of rough facets at cosine c, less that of flat ones. */
static float fujii(float c)
{
    if (c < 1e-6f) return PI / 2 - 2.0f / 3 - c;
    float s = sqrtf(1 - c * c);
    return s * (acosf(c) - 2.0f / 3 - s * c) + 2.0f / 3 * (s / c) * (1 - s * s * s);
}

struct brdf brdf_diffuse(rgb colour, float roughness, float cos_o)
{
    struct brdf brdf;
    brdf_clear(&brdf);
    brdf.kd = colour;
    if (roughness <= 0) return brdf;
    float sigma = saturate(roughness), a = 1 / (PI + sigma * (PI / 2 - 2.0f / 3)), b = sigma * a;
    float seen = a * PI + b * fujii(saturate(cos_o)), mean = a * PI + (2 * PI - 5.6f) / 3 * b;
    rgb c = saturate3(colour), more;
    more.x = sqr(c.x) / (1 - c.x * (1 - mean));
    more.y = sqr(c.y) / (1 - c.y * (1 - mean));
    more.z = sqr(c.z) / (1 - c.z * (1 - mean));
    more = scale(more, mean * (1 - seen));
    brdf.kd = mul(colour, add(scale(white, seen), more));
    float again = (more.x + more.y + more.z) / 3;
    brdf.flat = (a * PI + again) / (seen + again) - 1;
    brdf.tilt = b * PI / (seen + again);
    return brdf;
}
