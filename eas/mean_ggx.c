/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/mean_ggx.h"

#include "eas/ggx.h"

/* With half vectors h instead of wi (dwi = 4 h.wo dh) and G2 = 1/(1 + Lambda_i + Lambda_o):
 *     f cos(theta_i) dwi  =  F G2/cos_o  D(h) h.wo dh.
 * Let A = diag(1/alpha_x, 1/alpha_y, 1) and p = A h, of any length, a stretched half vector. Then
 *     D(h) h.wo dh  =  p.A^-1 wo dp / pi,  p unit. */

struct mean_ggx mean_ggx(const struct lobe *lobe, float3 n, float3 wo)
{
    struct mean_ggx m = {.lobe = lobe, .frame = ggx_frame(lobe, n)};
    m.wo = to_local(m.frame, wo);
    m.stretched = vec3(lobe->alpha_x * m.wo.x, lobe->alpha_y * m.wo.y, m.wo.z);
    m.level = frame_about(m.wo).t;
    m.slant = length(m.stretched);
    return m;
}

/* Integrals of G2/cos_o D(h) h.wo dh, as they are and times the parts of F. */
struct sums {
    float all;
    struct ggx_terms fresnel;
};

/* Adds a stretched half vector that stands for `share` of D(h) h.wo dh. No branches: it has to run in SIMD lanes. */
static inline struct sums add_half(struct sums sums, const struct mean_ggx *m, float3 p, float share)
{
    float ax = m->lobe->alpha_x, ay = m->lobe->alpha_y;
    float3 h = {ax * p.x, ay * p.y, p.z};
    float per_length = 1 / sqrtf(dot(h, h)), cos_h = dot(h, m->wo) * per_length, twice = 2 * cos_h * per_length;
    float3 wi = sub(scale(h, twice), m->wo);
    wi.z = maxf(wi.z, 0);
    float stretched = sqrtf(sqr(ax * wi.x) + sqr(ay * wi.y) + sqr(wi.z));
    struct ggx_terms fresnel = ggx_fresnel_terms(m->lobe, cos_h);
    float one = share * 2 * wi.z / (wi.z * m->slant + m->wo.z * stretched);
    return (struct sums){sums.all + one,
                         {sums.fresnel.dielectric + one * fresnel.dielectric,
                          sums.fresnel.schlick + one * fresnel.schlick, sums.fresnel.dip + one * fresnel.dip}};
}

/* A step of Laguerre's method towards the largest root of r^3 - trace r^2 + minors r - det, whose roots are real, from
 * above it. */
static inline float laguerre(float r, float trace, float minors, float det)
{
    float f = ((r - trace) * r + minors) * r - det, f1 = (3 * r - 2 * trace) * r + minors, f2 = 6 * r - 2 * trace;
    return r - 3 * f / (f1 + sqrtf(maxf(4 * f1 * f1 - 6 * f * f2, 0)));
}

/* A cap above the horizon; height: 1 - cos(theta). Its rim's half vectors are b + sqrt(td) cos(t) d + sqrt(tx) sin(t)
 * x, with tangents tan(theta/2) along d and sqrt((1 - cos(theta))/(cos(theta) + wo.axis)) along x. Stretched, it is a
 * cone again, about the eigenvector v of P = b b' - td d d' - tx x x' with the positive eigenvalue r; -P/r at right
 * angles to v is the cone's section there, and a1 a2 pi the area of the ellipse that it cuts out of the unit sphere,
 * seen along v. The integral of p dp over the cone is pi a1 a2 v. */
static inline struct sums whole(const struct mean_ggx *m, float3 axis, float height)
{
    float cosine = dot(m->wo, axis);
    float3 b = add(m->wo, axis), x = cross(m->wo, axis);
    float x2 = dot(x, x);
    bool retro = x2 < 1e-10f; /* wo and the axis are one: any direction will do */
    x = vec3(retro ? m->level.x : x.x, retro ? m->level.y : x.y, retro ? m->level.z : x.z);
    x2 = retro ? 1 : x2;
    float3 d = cross(x, b);
    float td = height / ((2 - height) * x2), tx = height * (2 + 2 * cosine) / (maxf(cosine + 1 - height, 1e-6f) * x2);
    /* A times alpha_x, so that numbers are near 1. */
    const float sy = m->lobe->alpha_x / m->lobe->alpha_y, sz = m->lobe->alpha_x;
    b = vec3(b.x, sy * b.y, sz * b.z), d = vec3(d.x, sy * d.y, sz * d.z), x = vec3(x.x, sy * x.y, sz * x.z);

    /* Invariants of P from products that don't cancel; b.b is not below r. */
    float3 dx = cross(d, x), bd = cross(b, d), bx = cross(b, x);
    float volume = dot(b, dx), tt = td * tx, det = tt * volume * volume, bb = dot(b, b);
    float trace = bb - td * dot(d, d) - tx * dot(x, x);
    float minors = tt * dot(dx, dx) - td * dot(bd, bd) - tx * dot(bx, bx);
    float r = laguerre(laguerre(bb, trace, minors, det), trace, minors, det);
    r = laguerre(laguerre(laguerre(r, trace, minors, det), trace, minors, det), trace, minors, det);
    float area = sqrtf(det / (r * ((3 * r - 2 * trace) * r + minors))); /* a1 a2 */
    /* v v' is the adjugate of P - r, normalized; here times b. */
    float3 v = mad(scale(dx, tt * volume), b, r * (r - trace + bb));
    v = mad(mad(v, d, -r * td * dot(d, b)), x, -r * tx * dot(x, b));
    struct frame f = frame_about(scale(v, 1 / sqrtf(dot(v, v))));

    /* The ellipse in f's plane, {L (cos, sin)} with L lower triangular: L L' = S/(1 + S), S = -P/r. */
    float3 bf = to_local(f, b), df = to_local(f, d), xf = to_local(f, x), seen = to_local(f, m->stretched);
    float s11 = td * df.x * df.x + tx * xf.x * xf.x - bf.x * bf.x,
          s12 = td * df.x * df.y + tx * xf.x * xf.y - bf.x * bf.y;
    float s22 = td * df.y * df.y + tx * xf.y * xf.y - bf.y * bf.y, s = maxf(s11 * s22 - s12 * s12, 0);
    float per = 1 / (r * (r + s11 + s22) + s), l11 = sqrtf(maxf((r * s11 + s) * per, 1e-20f));
    float l21 = r * s12 * per / l11, l22 = area / l11;

    /* Points 1/sqrt(2) of the way to the rim along two conjugate radii have an ellipse's second moments. Each stands
     * for a quarter of the area; dp is dA/p.v. */
    const float inner = .70710678f;
    l11 *= inner, l21 *= inner, l22 *= inner;
    float h1 = sqrtf(maxf(1 - l11 * l11 - l21 * l21, .1f)), h2 = sqrtf(maxf(1 - l22 * l22, .1f));
    float tilt1 = (seen.x * l11 + seen.y * l21) / h1, tilt2 = seen.y * l22 / h2, quarter = .25f * area;
    struct sums sums = {0};
    sums = add_half(sums, m, to_world(f, vec3(l11, l21, h1)), quarter * (seen.z + tilt1));
    sums = add_half(sums, m, to_world(f, vec3(-l11, -l21, h1)), quarter * (seen.z - tilt1));
    sums = add_half(sums, m, to_world(f, vec3(0, l22, h2)), quarter * (seen.z + tilt2));
    return add_half(sums, m, to_world(f, vec3(0, -l22, h2)), quarter * (seen.z - tilt2));
}

/* Angles in a clipped cap are tangents of their halves: this one is of a sum. */
static inline float tan_sum(float a, float b) { return (a + b) / (1 - a * b); }

/* Angles run over u, -1 to 1 for a turn, as tan(angle/2) = width u/(1-u^2). Near 0 that is angle = width tan(s) with
 * u = tan(s/2): what falls off as (1 + (angle/width)^2)^-2 has cos^2(s) left to integrate. */
static inline float crowd(float tangent, float width)
{
    float x = clampf(2 * tangent / width, -1e6f, 1e6f);
    return x / (1 + sqrtf(1 + x * x));
}
static inline float uncrowd(float u, float width, float *slope)
{
    float v = maxf(1 - u * u, 1e-6f), t = width * u;
    *slope = 2 * width * (1 + u * u) / (v * v + t * t);
    return t / v;
}

enum { ROWS = 8, COLUMNS = 6 };

/* What the horizon leaves of a cap: rows of equal elevation, by Gauss and Legendre's points both ways. */
static struct sums clipped(const struct mean_ggx *m, float3 axis, float height)
{
    static const float row_nodes[ROWS][2] = {{-.9602899f, .1012285f}, {-.7966665f, .2223810f}, {-.5255324f, .3137066f},
                                             {-.1834346f, .3626838f}, {.1834346f, .3626838f},  {.5255324f, .3137066f},
                                             {.7966665f, .2223810f},  {.9602899f, .1012285f}};
    static const float column_nodes[COLUMNS][2] = {{-.9324695f, .1713245f}, {-.6612094f, .3607616f},
                                                   {-.2386192f, .4679139f}, {.2386192f, .4679139f},
                                                   {.6612094f, .3607616f},  {.9324695f, .1713245f}};
    const float3 wo = m->wo;
    if (axis.z < 0 && axis.z * axis.z >= height * (2 - height)) return (struct sums){0};
    float level_a = sqrtf(maxf(sqr(axis.x) + sqr(axis.y), 1e-8f)), level_o = sqrtf(sqr(wo.x) + sqr(wo.y));
    /* Elevations are from the mirror direction's, azimuths from its, which is (ux, uy). */
    float ux = level_o > 0 ? -wo.x / level_o : 1, uy = level_o > 0 ? -wo.y / level_o : 0;
    float cosine = (axis.x * ux + axis.y * uy) / level_a, sine = (axis.y * ux - axis.x * uy) / level_a;
    float azimuth =
        cosine > 0 ? sine / (1 + cosine) : (1 - cosine) / (sine < 0 ? minf(sine, -1e-6f) : maxf(sine, 1e-6f));
    float elevation = wo.z / (1 + level_o), middle_up = axis.z / (1 + level_a);
    float top = minf(tan_sum(middle_up, sqrtf(height / (2 - height))), 1);
    /* p.p = z^2 + across (y + mixed x)^2 + along x^2, for h with x along (ux, uy). */
    float per_x = 1 / m->lobe->alpha_x, per_y = 1 / m->lobe->alpha_y, xx = per_x * per_x, yy = per_y * per_y;
    float across = xx * uy * uy + yy * ux * ux, mixed = (yy - xx) * ux * uy / across, along = xx * yy / across;
    float tall = 2 / sqrtf(along), low = crowd(-elevation, tall);
    float high = crowd(tan_sum(top, -elevation), tall);

    float z[ROWS], level[ROWS], peak[ROWS], width[ROWS], middle[ROWS], half[ROWS], share[ROWS];
#pragma omp simd
    for (int i = 0; i < ROWS; i++) {
        float slope, span = .5f * (high - low), u = .5f * (high + low) + span * row_nodes[i][0];
        float t = tan_sum(uncrowd(u, tall, &slope), elevation), per = 1 / (1 + t * t);
        z[i] = 2 * t * per;
        level[i] = (1 - t * t) * per;
        float per_level = 1 / level[i], less = level_o - level[i];
        /* Where the row comes nearest to the lobe's middle, and how wide the lobe is there. */
        peak[i] = .5f * less * mixed * per_level;
        width[i] = sqrtf((sqr(z[i] + wo.z) + less * less * along) / across) * per_level;
        /* Half of the row: 1 - cos of it, which is never a difference of numbers near 1. */
        float above = tan_sum(t, -middle_up), versine = height - 2 * above * above / (1 + above * above);
        versine = clampf(versine * per_level / level_a, 0, 2 - 1e-6f);
        float tan_half = sqrtf(versine / (2 - versine)), centre = tan_sum(azimuth, -peak[i]);
        float from = crowd(tan_sum(centre, -tan_half), width[i]), to = crowd(tan_sum(centre, tan_half), width[i]);
        to += to < from - (tan_half < 1 ? 1e-4f : 0) ? 2 : 0; /* past the turn, and no rounding of nothing */
        middle[i] = .5f * (from + to);
        half[i] = .5f * (to - from);
        share[i] = half[i] * span * row_nodes[i][1] * slope * level[i] * (.25f / PI * per_x * per_y);
    }
    struct sums sums[ROWS] = {0}, sum = {0};
    for (int j = 0; j < COLUMNS; j++) {
#pragma omp simd
        for (int i = 0; i < ROWS; i++) {
            float slope, u = middle[i] + half[i] * column_nodes[j][0];
            u -= u > 1 ? 2 : 0;
            float t = tan_sum(uncrowd(u, width[i], &slope), peak[i]), per = level[i] / (1 + t * t);
            float x = (1 - t * t) * per, y = 2 * t * per;
            float3 h = {x * ux - y * uy + wo.x, x * uy + y * ux + wo.y, z[i] + wo.z},
                   p = {h.x * per_x, h.y * per_y, h.z};
            /* D(h) h.wo dh = D(h)/4 dwi, and D(h) is 1/(pi alpha_x alpha_y |A h|^4) of the unit h. */
            float d = sqr(dot(h, h) / dot(p, p));
            sums[i] = add_half(sums[i], m, p, d * share[i] * slope * column_nodes[j][1]);
        }
    }
    for (int i = 0; i < ROWS; i++) {
        sum.all += sums[i].all;
        sum.fresnel.dielectric += sums[i].fresnel.dielectric;
        sum.fresnel.schlick += sums[i].fresnel.schlick;
        sum.fresnel.dip += sums[i].fresnel.dip;
    }
    return sum;
}

static inline rgb colour(const struct lobe *lobe, struct sums sums)
{
    if (!(sums.all > 0)) return vec3(0, 0, 0);
    float per = 1 / sums.all;
    struct ggx_terms mean = {sums.fresnel.dielectric * per, sums.fresnel.schlick * per, sums.fresnel.dip * per};
    return scale(mul(ggx_fresnel_from(lobe, mean), lobe->weight), sums.all);
}

void mean_ggx_caps(const struct mean_ggx *m, const struct cap *caps, int count, rgb *values)
{
    enum { BLOCK = 16 };
    const struct mean_ggx lobe = *m; /* what no store can change: else no SIMD */
    float x[BLOCK], y[BLOCK], z[BLOCK], height[BLOCK];
    struct sums sums[BLOCK];
    for (int first = 0; first < count; first += BLOCK) {
        int block = count - first < BLOCK ? count - first : BLOCK;
        for (int i = 0; i < block; i++) {
            float3 axis = to_local(m->frame, caps[first + i].axis);
            x[i] = axis.x, y[i] = axis.y, z[i] = axis.z;
            height[i] = caps[first + i].omega * (1 / (2 * PI));
        }
#pragma omp simd
        for (int i = 0; i < block; i++) sums[i] = whole(&lobe, vec3(x[i], y[i], z[i]), height[i]);
        for (int i = 0; i < block; i++) {
            if (z[i] * fabsf(z[i]) < height[i] * (2 - height[i])) /* against sin^2(theta) */
                sums[i] = clipped(m, vec3(x[i], y[i], z[i]), height[i]);
            values[first + i] = m->wo.z > 0 ? colour(m->lobe, sums[i]) : vec3(0, 0, 0);
        }
    }
}
