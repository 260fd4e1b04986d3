/* SPDX-License-Identifier: Apache-2.0 */
#include <threads.h>

#include "eas/ggx.h"

static inline float saturate(float x) { return clampf(x, 0, 1); }

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
    float3 h; /* n is z, the viewer's azimuth x */
    float cos_i, cos_h, weight;
};

static void visible_directions(float alpha, float mu, struct visible out[static POINTS])
{
    float3 w = {sqrtf(1 - mu * mu), 0, mu};
    for (int i = 0; i < POINTS; i++) {
        float v = ((float)i + 0.5f) / POINTS, u[2] = {(float)(i * POINTS_BEFORE % POINTS) / POINTS, 1 - v * v * v};
        float3 h = ggx_visible_normal(alpha, alpha, w, u);
        out[i] = (struct visible){h, reflect(w, h).z, dot(w, h), 3 * v * v / POINTS};
    }
}

static float grid(int i, int size) { return clampf((float)i / (float)(size - 1), 1e-4f, 1); }

/* G2/G1: the share of light at cosine c that no facet is in the way of. */
static inline float unmasked(float alpha2, float lambda_o, float c)
{
    return (1 + lambda_o) / (1 + lambda_o + ggx_lambda(ggx_tan2(alpha2, c)));
}

/* The index at a place on its grid. */
static float grid_index(int z)
{
    float q = minf(grid(z, SHARE_SIZE), 0.99f); /* 1 would be an infinite index */
    return (1 + q * q) / (1 - q * q);
}

/* Directional albedo: the mean of G2/G1 over the visible normals. */
static float integrate_albedo(float alpha, float mu)
{
    struct visible v[POINTS];
    float alpha2 = alpha * alpha, lambda_o = ggx_lambda(ggx_tan2(alpha2, mu)), sum = 0;
    visible_directions(alpha, mu, v);
    for (int i = 0; i < POINTS; i++)
        if (v[i].cos_i > 0) sum += v[i].weight * unmasked(alpha2, lambda_o, v[i].cos_i);
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
            float eta = grid_index(z), sum = 0;
            for (int i = 0; i < POINTS; i++)
                if (v[i].cos_i > 0) sum += v[i].weight * ggx_share(ggx_fresnel_dielectric(v[i].cos_h, eta), eta);
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

/* A place in a table over roughness, mu and index. */
static float at(const float table[SHARE_SIZE][SHARE_SIZE][SHARE_SIZE], float roughness, float mu, float index)
{
    float s, t, r, slice[2];
    int x = cell(roughness, SHARE_SIZE, &s), y = cell(mu, SHARE_SIZE, &t), z = cell(index, SHARE_SIZE, &r);
    for (int k = 0; k < 2; k++) {
        const float *a = table[z + k][y] + x, *b = table[z + k][y + 1] + x;
        slice[k] = mix(mix(a[0], a[1], s), mix(b[0], b[1], s), t);
    }
    return mix(slice[0], slice[1], r);
}

static inline float index_place(float eta) { return sqrtf(fabsf((eta - 1) / (eta + 1))); }

float ggx_fresnel_share(float roughness, float mu, float eta)
{
    need_tables();
    return at(tables.share, roughness, mu, index_place(eta));
}

/* Glass, seen from outside, [0], and from inside. */
static struct {
    float albedo[2][SHARE_SIZE][SHARE_SIZE][SHARE_SIZE], mean[2][SHARE_SIZE][SHARE_SIZE];
} glass; /* constant once filled */

/* What the facets seen at mu reflect and refract, and no other is in the way of. From inside some refract upward again:
 * that light is lost in the lobe, but Cycles' tables count it, and so do these. */
static void integrate_glass(float alpha, float mu, float albedo[2][SHARE_SIZE])
{
    struct visible v[POINTS];
    float3 w = {sqrtf(1 - mu * mu), 0, mu};
    float alpha2 = alpha * alpha, lambda_o = ggx_lambda(ggx_tan2(alpha2, mu));
    visible_directions(alpha, mu, v);
    for (int side = 0; side < 2; side++)
        for (int z = 0; z < SHARE_SIZE; z++) {
            float eta = side ? 1 / grid_index(z) : grid_index(z), sum = 0;
            for (int i = 0; i < POINTS; i++) {
                float f = ggx_fresnel_dielectric(v[i].cos_h, eta), c = ggx_refract(w, v[i].h, eta).z;
                if (v[i].cos_i > 0) sum += v[i].weight * f * unmasked(alpha2, lambda_o, v[i].cos_i);
                if (f < 1) sum += v[i].weight * (1 - f) * unmasked(alpha2, lambda_o, c);
            }
            albedo[side][z] = saturate(sum);
        }
}

static void fill_glass(void)
{
    for (int x = 0; x < SHARE_SIZE; x++) {
        float alpha = sqr(grid(x, SHARE_SIZE)), albedo[2][SHARE_SIZE];
        for (int y = 0; y < SHARE_SIZE; y++) {
            integrate_glass(alpha, grid(y, SHARE_SIZE), albedo);
            for (int k = 0; k < 2 * SHARE_SIZE; k++)
                glass.albedo[k / SHARE_SIZE][k % SHARE_SIZE][y][x] = albedo[k / SHARE_SIZE][k % SHARE_SIZE];
        }
        for (int i = 0; i < MEAN_STEPS; i++) {
            float mu = ((float)i + 0.5f) / MEAN_STEPS;
            integrate_glass(alpha, mu, albedo);
            for (int k = 0; k < 2 * SHARE_SIZE; k++)
                glass.mean[k / SHARE_SIZE][k % SHARE_SIZE][x] +=
                    2 * mu * albedo[k / SHARE_SIZE][k % SHARE_SIZE] / MEAN_STEPS;
        }
    }
}

float ggx_glass_albedo(float roughness, float mu, float eta, float *mean)
{
    static once_flag once = ONCE_FLAG_INIT;
    call_once(&once, fill_glass);
    int side = eta < 1;
    float s, t, index = index_place(eta);
    int x = cell(roughness, SHARE_SIZE, &s), z = cell(index, SHARE_SIZE, &t);
    const float *a = glass.mean[side][z] + x, *b = glass.mean[side][z + 1] + x;
    *mean = mix(mix(a[0], a[1], s), mix(b[0], b[1], s), t);
    return at(glass.albedo[side], roughness, mu, index);
}
