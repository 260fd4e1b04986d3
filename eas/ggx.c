/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/ggx.h"

#include <threads.h>

static inline float saturate(float x) { return clampf(x, 0, 1); }

/* Smith's Lambda (Heitz 2014, eq. 72) from the squared tangent of a direction stretched by the alphas. */
static inline float lambda(float stretched) { return 0.5f * (sqrtf(1 + stretched) - 1); }
/* That tangent: isotropic, at cosine c; and of any direction in the lobe's frame. */
static inline float tan2(float alpha2, float c) { return alpha2 * maxf(1 / (c * c) - 1, 0); }
static inline float stretched_tan2(const struct lobe *lobe, float3 w)
{
    return (sqr(lobe->alpha_x * w.x) + sqr(lobe->alpha_y * w.y)) / sqr(w.z);
}

/* How far a dielectric's reflectance has gone from that at normal incidence, 0, to that at grazing, 1. */
static inline float fresnel_share(float reflectance, float eta)
{
    float f0 = ggx_f0(eta);
    return saturate((reflectance - f0) / (1 - f0));
}

rgb ggx_fresnel_from(const struct lobe *lobe, struct ggx_terms terms)
{
    const rgb white = {1, 1, 1};
    if (lobe->type == LOBE_DIELECTRIC) return lerp3(lobe->f0, white, fresnel_share(terms.dielectric, lobe->ior));
    /* Kutz et al. 2021, "Novel aspects of the Adobe Standard Material": Schlick less b cos (1-cos)^6, with b such that
     * the factor at cos = 1/7 is f82. */
    const float edge = 6.0f / 7, edge5 = edge * edge * edge * edge * edge;
    rgb b = scale(mul(lerp3(lobe->f0, white, edge5), sub(white, lobe->f82)), 7 / (edge5 * edge));
    rgb f = mad(lerp3(lobe->f0, white, terms.schlick), b, -terms.dip);
    return vec3(saturate(f.x), saturate(f.y), saturate(f.z));
}

rgb ggx_fresnel(const struct lobe *lobe, float c) { return ggx_fresnel_from(lobe, ggx_fresnel_terms(lobe, c)); }

struct frame ggx_frame(const struct lobe *lobe, float3 n)
{
    if (lobe->alpha_x == lobe->alpha_y) return frame_about(n);
    float3 b = normalize(cross(n, lobe->tangent));
    return (struct frame){cross(b, n), b, n};
}

rgb ggx_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf)
{
    float cos_i = dot(n, wi), cos_o = dot(n, wo), d, lambda_i, lambda_o;
    float3 h = add(wi, wo);
    float h2 = dot(h, h);
    if (lobe->alpha_x == lobe->alpha_y) {
        float alpha2 = sqr(lobe->alpha_x);
        /* The sine from the cross product: 1 - cos^2 would lose a narrow lobe's width in rounding. */
        float3 perpendicular = cross(n, h);
        float sin2 = dot(perpendicular, perpendicular) / h2, cos2 = sqr(dot(n, h)) / h2;
        d = alpha2 / (PI * sqr(sin2 + alpha2 * cos2));
        lambda_i = lambda(tan2(alpha2, cos_i));
        lambda_o = lambda(tan2(alpha2, cos_o));
    } else { /* Heitz 2014: the isotropic lobe, stretched */
        struct frame frame = ggx_frame(lobe, n);
        float3 slope = to_local(frame, h);
        slope.x /= lobe->alpha_x, slope.y /= lobe->alpha_y;
        d = sqr(h2 / dot(slope, slope)) / (PI * lobe->alpha_x * lobe->alpha_y);
        lambda_i = lambda(stretched_tan2(lobe, to_local(frame, wi)));
        lambda_o = lambda(stretched_tan2(lobe, to_local(frame, wo)));
    }
    *pdf = d / (4 * cos_o * (1 + lambda_o));
    rgb fresnel = ggx_fresnel(lobe, dot(h, wo) / sqrtf(h2));
    return mul(lobe->weight, scale(fresnel, d / (4 * cos_i * cos_o * (1 + lambda_i + lambda_o))));
}

/* A visible normal seen from w, both in the frame where n is z: uniform in the cap that the stretched w sees. */
static inline float3 visible_normal(float alpha_x, float alpha_y, float3 w, const float u[static 2])
{
    float3 s = normalize(vec3(alpha_x * w.x, alpha_y * w.y, w.z));
    float phi = 2 * PI * u[0], z = (1 - u[1]) * (1 + s.z) - s.z, r = sqrtf(saturate(1 - z * z));
    float3 h = add(vec3(r * cosf(phi), r * sinf(phi), z), s);
    return normalize(vec3(alpha_x * h.x, alpha_y * h.y, maxf(h.z, 0)));
}

float3 ggx_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2])
{
    struct frame frame = ggx_frame(lobe, n);
    return reflect(wo, to_world(frame, visible_normal(lobe->alpha_x, lobe->alpha_y, to_local(frame, wo), u)));
}

/* Cycles' grids: roughness along x, mu along y, and along z the index as sqrt((eta-1)/(eta+1)); each from 0 to 1. */
enum { ALBEDO_SIZE = 32, SHARE_SIZE = 16 };
/* Two Fibonacci numbers, and midpoints for the mean over mu. */
enum { POINTS = 610, POINTS_BEFORE = 377, MEAN_STEPS = 16 };

static struct {
    float albedo[ALBEDO_SIZE][ALBEDO_SIZE], albedo_mean[ALBEDO_SIZE];
    float share[SHARE_SIZE][SHARE_SIZE][SHARE_SIZE];
} tables; /* constant once filled */

/* What the visible normals of w reflect: the light's and the half vector's cosines, with weights that sum to 1. The
 * points are a Fibonacci lattice over azimuth and height; heights crowd, by a cube, where the distribution's tail sends
 * light to the horizon. */
struct visible {
    float cos_i, cos_h, weight;
};

static void visible_directions(float alpha, float mu, struct visible out[static POINTS])
{
    float3 w = {sqrtf(1 - mu * mu), 0, mu};
    for (int i = 0; i < POINTS; i++) {
        float v = ((float)i + 0.5f) / POINTS, u[2] = {(float)(i * POINTS_BEFORE % POINTS) / POINTS, 1 - v * v * v};
        float3 h = visible_normal(alpha, alpha, w, u);
        out[i] = (struct visible){reflect(w, h).z, dot(w, h), 3 * v * v / POINTS};
    }
}

static float grid(int i, int size) { return clampf((float)i / (float)(size - 1), 1e-4f, 1); }

/* Directional albedo: the mean of G2/G1 over the visible normals. */
static float integrate_albedo(float alpha, float mu)
{
    struct visible v[POINTS];
    float alpha2 = alpha * alpha, lambda_o = lambda(tan2(alpha2, mu)), sum = 0;
    visible_directions(alpha, mu, v);
    for (int i = 0; i < POINTS; i++)
        if (v[i].cos_i > 0) sum += v[i].weight * (1 + lambda_o) / (1 + lambda_o + lambda(tan2(alpha2, v[i].cos_i)));
    return saturate(sum);
}

static void fill_albedo(int x)
{
    float alpha = sqr(grid(x, ALBEDO_SIZE)), mean = 0;
    for (int y = 0; y < ALBEDO_SIZE; y++)
        tables.albedo[y][x] = x == 0 ? 1 : integrate_albedo(alpha, grid(y, ALBEDO_SIZE)); /* column 0 is a mirror */
    /* The mean by midpoints of its own: the grid is too coarse near mu = 0. */
    for (int k = 0; k < MEAN_STEPS; k++) {
        float mu = ((float)k + 0.5f) / MEAN_STEPS;
        mean += 2 * mu * integrate_albedo(alpha, mu) / MEAN_STEPS;
    }
    tables.albedo_mean[x] = x == 0 ? 1 : saturate(mean);
}

static void fill_share(int x)
{
    struct visible v[POINTS];
    float alpha = sqr(grid(x, SHARE_SIZE));
    for (int y = 0; y < SHARE_SIZE; y++) {
        visible_directions(alpha, grid(y, SHARE_SIZE), v);
        for (int z = 0; z < SHARE_SIZE; z++) {
            float q = minf(grid(z, SHARE_SIZE), 0.99f); /* 1 would be an infinite index */
            float eta = (1 + q * q) / (1 - q * q), sum = 0;
            for (int i = 0; i < POINTS; i++)
                if (v[i].cos_i > 0) sum += v[i].weight * fresnel_share(ggx_fresnel_dielectric(v[i].cos_h, eta), eta);
            tables.share[z][y][x] = saturate(sum);
        }
    }
}

static void fill_tables(void)
{
    for (int x = 0; x < ALBEDO_SIZE; x++) fill_albedo(x);
    for (int x = 0; x < SHARE_SIZE; x++) fill_share(x);
}

static void need_tables(void)
{
    static once_flag once = ONCE_FLAG_INIT;
    call_once(&once, fill_tables);
}

/* Cell and fraction of x in [0, 1] on a grid. */
static inline int cell(float x, int size, float *fraction)
{
    x = saturate(x) * (float)(size - 1);
    int i = (int)x < size - 2 ? (int)x : size - 2;
    *fraction = x - (float)i;
    return i;
}

static inline float mix(float a, float b, float t) { return (1 - t) * a + t * b; }

float ggx_albedo(float roughness, float mu)
{
    need_tables();
    float s, t;
    int x = cell(roughness, ALBEDO_SIZE, &s), y = cell(mu, ALBEDO_SIZE, &t);
    const float *a = tables.albedo[y] + x, *b = tables.albedo[y + 1] + x;
    return mix(mix(a[0], a[1], s), mix(b[0], b[1], s), t);
}

float ggx_albedo_mean(float roughness)
{
    need_tables();
    float s;
    int x = cell(roughness, ALBEDO_SIZE, &s);
    return mix(tables.albedo_mean[x], tables.albedo_mean[x + 1], s);
}

float ggx_fresnel_share(float roughness, float mu, float eta)
{
    need_tables();
    float s, t, r, slice[2];
    int x = cell(roughness, SHARE_SIZE, &s), y = cell(mu, SHARE_SIZE, &t);
    int z = cell(sqrtf(fabsf((eta - 1) / (eta + 1))), SHARE_SIZE, &r);
    for (int k = 0; k < 2; k++) {
        const float *a = tables.share[z + k][y] + x, *b = tables.share[z + k][y + 1] + x;
        slice[k] = mix(mix(a[0], a[1], s), mix(b[0], b[1], s), t);
    }
    return mix(slice[0], slice[1], r);
}
