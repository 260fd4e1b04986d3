/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/mean_phong.h"

typedef float float4 __attribute__((vector_size(16), may_alias));
typedef float float8 __attribute__((vector_size(32), aligned(16), may_alias));

enum { SPANS = MEAN_PHONG_SPANS, CAPS = MEAN_PHONG_CAPS, OFFSETS = MEAN_PHONG_OFFSETS, BLOCK = MEAN_PHONG_BLOCK };
enum { RINGS = 24, ROWS = 8, KNEE_ROW = 38 };

/* A lobe reaches this many sigmas: exp(-4^2/2) = 3e-4 of its peak. */
#define REACH 4.0f
/* A cap holds all of it (1 - 6e-4) where its edge is this many sigmas beyond. */
#define HOLD 3.25f
/* Cap radii u are tabulated over u/(CAP_KNEE + u). Row KNEE_ROW is u = HOLD, where first_offset has its bend. */
#define CAP_KNEE (HOLD * (CAPS - 1 - KNEE_ROW) / KNEE_ROW)
/* Below the horizon the cosine of f cos is negative. The part of a cap there is let be where it counts for little:
 * where the sine of the axis' elevation is over sqrt(CLEAR) of the radius' sine; sqrt(CLEAR_HIGH) of it where R is HIGH
 * sigmas up; 0 where the sine of R's elevation is over TOP or the lobe doesn't reach down. */
#define CLEAR .7f
#define CLEAR_HIGH .04f
#define HIGH 2.5f
#define TOP .87f

/* Modified Phong over a cap, mirror direction R, normal N:
 *     integral of f cos = (n+2)/2pi N . integral of cos^n(alpha) w dw = y^2 (P y N.R + Q N.axis), y = u/(CAP_KNEE + u).
 * P and Q, of order 1, depend on three numbers. Lengths are chords (no arc functions), in sigmas; sigma^2 = 1/(n+1).
 *     sigma^2: linear between the ends of SPANS spans; both ends of a span are in one texel, as P Q P Q;
 *     u: the cap's radius;
 *     v: the axis from R, from where the cap holds all of the lobe to where it holds none. */

static inline float variance(float exponent) { return 1 / (exponent + 1); }
static inline float span_end(int i) { return sqr((float)i / SPANS); }

/* max(x, 0) without the branch that compilers make of it: it would be mispredicted. */
static inline float positive(float x) { return .5f * (x + fabsf(x)); }
/* Where the offsets of a cap begin; they end at u + REACH. */
static inline float first_offset(float u) { return positive(u - HOLD); }

/* The integral of cos^n(alpha) w over a cap of half-angle theta at delta from R, as p R + q axis: from rings alpha
 * about R, of which the cap holds the azimuths |phi| < phi(alpha). Midpoints in a variable that flattens the ends,
 * where phi(alpha) may rise as a square root. */
static void integrate_cap(double exponent, double theta, double delta, double *p, double *q)
{
    double first = fabs(delta - theta), last = fmin(fmin(delta + theta, PI / 2), first + 4.8 / sqrt(exponent + 1));
    double along = 0, across = 0; /* along R; at right angles to it, to the axis */
    if (delta < theta)            /* the whole rings: 1 - cos^(n+2) */
        along = -2 * PI / (exponent + 2) * expm1(.5 * (exponent + 2) * log1p(-pow(sin(fmin(first, PI / 2)), 2)));
    for (int i = 0; i < RINGS && first < last; i++) {
        double s = (i + .5) / RINGS, alpha = first + (last - first) * (s - sin(2 * M_PI * s) / (2 * M_PI));
        double c = fmax(cos(alpha), 0), sine = sin(alpha);
        double sin2_half = sin(.5 * (theta + alpha - delta)) * sin(.5 * (theta - alpha + delta)) / (sine * sin(delta));
        double weight = (last - first) / RINGS * (1 - cos(2 * M_PI * s)) * pow(c, exponent) * sine;
        sin2_half = fmax(0, fmin(1, sin2_half));
        along += 4 * asin(sqrt(sin2_half)) * c * weight;
        across += 4 * sqrt(sin2_half * (1 - sin2_half)) * sine * weight;
    }
    *q = across / sin(delta);
    *p = fmax(along - cos(delta) * *q, 0);
}

static void fill_span_end(struct mean_phong *tables, int i)
{
    double width = sqrt(fmax(span_end(i), 1e-8)), exponent = 1 / (width * width) - 1;
    for (int j = 0; j < CAPS; j++) {
        double y = fmax(1e-3, fmin((double)j / (CAPS - 1), .99)), u = fmin(CAP_KNEE * y / (1 - y), sqrt(2) / width);
        double peak = (exponent + 2) / (2 * PI * y * y);
        for (int k = 0; k < OFFSETS; k++) {
            double first = first_offset((float)u), v = first + (REACH + u - first) * k / (OFFSETS - 1), p, q;
            integrate_cap(exponent, 2 * asin(u * width / 2), 2 * asin(fmin(fmax(v, 1e-3) * width / 2, 1)), &p, &q);
            for (int end = 0; end < 2; end++)
                if (i - end >= 0 && i - end < SPANS) {
                    tables->table[i - end][j][k][2 * end] = (float)(p * peak / y);
                    tables->table[i - end][j][k][2 * end + 1] = (float)(q * peak);
                }
        }
    }
}

void mean_phong_fill(struct mean_phong *tables)
{
    for (int i = 0; i <= SPANS; i++) fill_span_end(tables, i);
}

struct mean_phong_lobe mean_phong_lobe(const struct mean_phong *tables, float exponent)
{
    float sigma2 = clampf(variance(exponent), 1e-8f, .999f); /* as narrow as keeps y below 1 */
    int i = (int)(sqrtf(sigma2) * SPANS);
    float blend = (sigma2 - span_end(i)) / (span_end(i + 1) - span_end(i));
    return (struct mean_phong_lobe){tables->table[i][0], blend, exponent, sqrtf(sigma2)};
}

/* The angle of a versine (1 - cos) on 0 … 2: Abramowitz and Stegun 4.4.46, to 1e-7 of it below a right angle. */
static inline float fast_angle(float versine)
{
    float y = minf(versine, 2 - versine), x = 1 - y;
    float p = .0308918810f + x * (-.0170881256f + x * (.0066700901f - x * .0012624911f));
    p = 1.5707963050f + x * (-.2145988016f + x * (.0889789874f + x * (-.0501743046f + x * p)));
    float angle = sqrtf(y) * p;
    return versine < 1 ? angle : PI - angle;
}

/* The error function: Abramowitz and Stegun 7.1.28, absolute error below 3e-7. */
static inline float fast_erf(float x)
{
    float a = fabsf(x), p = .0001520143f + a * (.0002765672f + a * .0000430638f);
    p = 1 + a * (.0705230784f + a * (.0422820123f + a * (.0092705272f + a * p)));
    return copysignf(1 - 1 / sqr(sqr(sqr(sqr(p)))), x);
}

/* x^n on 0 … 1, to 1e-4 of 1: log x by the series of 2 atanh((x-1)/(x+1)), exp by (exp(x/64))^64. */
static inline float fast_power(float x, float n)
{
    float s = (x - 1) / (x + 1), s2 = s * s;
    float log_x = 2 * s * (1 + s2 * (1 / 3.0f + s2 * (1 / 5.0f + s2 * (1 / 7.0f + s2 * (1 / 9.0f)))));
    float t = maxf(n * log_x, -32) * (1 / 64.0f), e = 1 + t * (1 + t * (1 / 2.0f + t * (1 / 6.0f + t * (1 / 24.0f))));
    return sqr(sqr(sqr(sqr(sqr(sqr(e))))));
}

/* The part of a cap above the horizon, by Gauss and Legendre's points over rows of equal elevation, in its sine z.
 * Along a row cos^n(alpha) is nearly a Gaussian of azimuth, whose integral is an error function. Differences of
 * directions are squared chords, which keep their digits where little of the cap is left. */
static float clipped_cap(const struct mean_phong_lobe *lobe, float omega, float cos_mirror, float up, float mirror_up)
{
    static const float nodes[ROWS] = {-.9602899f, -.7966665f, -.5255324f, -.1834346f,
                                      .1834346f,  .5255324f,  .7966665f,  .9602899f};
    static const float weights[ROWS] = {.1012285f, .2223810f, .3137066f, .3626838f,
                                        .3626838f, .3137066f, .2223810f, .1012285f};
    /* Sines and cosines of elevations, of the cap's radius, and of how far the lobe is followed, some 3.3 sigmas. */
    float level = sqrtf(maxf(1 - up * up, 1e-6f)), mirror_level = sqrtf(maxf(1 - mirror_up * mirror_up, 1e-6f));
    float versine = omega * (1 / (2 * PI)), cos_cap = 1 - versine, sin_cap = sqrtf(versine * (2 - versine));
    float cos_lobe = maxf(1 - 5.4f * sqr(lobe->width), 0), sin_lobe = sqrtf(1 - cos_lobe * cos_lobe);
    float low = maxf(up * cos_cap - level * sin_cap, mirror_up * cos_lobe - mirror_level * sin_lobe);
    float top = up < cos_cap ? up * cos_cap + level * sin_cap : 1;
    float lobe_top = mirror_up < cos_lobe ? mirror_up * cos_lobe + mirror_level * sin_lobe : 1;
    float half_span = .5f * (minf(top, lobe_top) - maxf(low, 0)), middle = maxf(low, 0) + half_span, sum = 0;
    if (!(half_span > 0)) return 0;
    float chord2 = 2 - 2 * cos_mirror - sqr(up - mirror_up) - sqr(level - mirror_level), n = lobe->exponent;
    float azimuth = fast_angle(clampf(chord2 / (2 * level * mirror_level), 0, 2));
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < ROWS; i++) {
        float z = middle + half_span * nodes[i], row_level = sqrtf(maxf(1 - z * z, 1e-6f));
        float nearest = maxf(z * mirror_up + row_level * mirror_level, 1e-4f); /* cosine of the angle from R */
        float across2 = 2 * versine - sqr(z - up) - sqr(row_level - level);
        float half = fast_angle(clampf(across2 / (2 * row_level * level), 0, 2)); /* of the row, in the cap */
        /* The half of n + 1/2 instead of n makes up for the Gaussian's tails, best at small n. */
        float k = sqrtf(.5f * (n + .5f) * row_level * mirror_level / nearest);
        /* Azimuths from that of R: what reaches beyond pi comes in again from -pi. */
        float from = azimuth - half, to = azimuth + half, end = fast_erf(k * minf(to, 2 * PI - to));
        end = to <= PI ? end : 2 * fast_erf(k * PI) - end;
        sum += weights[i] * z * fast_power(nearest, n) * (end - fast_erf(k * from)) / k;
    }
    /* (n+2)/2pi, half the interval, and sqrt(pi)/2 of the error function */
    return (n + 2) / (2 * PI) * half_span * .8862269f * sum;
}

int mean_phong_caps(const struct mean_phong_lobe *lobe, struct mean_phong_caps *caps, int count)
{
    enum { MISSED, WHOLE, CLIPPED };
    int cell[BLOCK], kind[BLOCK], hits = 0;
    float size[BLOCK], between[BLOCK], along[BLOCK]; /* y; how far on from the cell's row, from its column */
    const float width = lobe->width, per_width = 1 / width, blend = lobe->blend;
#pragma omp simd
    for (int i = 0; i < count; i++) {
        float up = caps->up[i], mirror_up = caps->mirror_up[i], disc = caps->omega[i] * (1 / PI); /* squared chord */
        float u = sqrtf(disc) * per_width, v = sqrtf(fabsf(2 - 2 * caps->cos_mirror[i])) * per_width;
        float clear = mirror_up > HIGH * width ? CLEAR_HIGH : CLEAR;
        clear = mirror_up > minf(REACH * width, TOP) ? 0 : clear;
        int clipped = up * fabsf(up) < clear * disc * (1 - .25f * disc); /* against sin^2(theta) */
        kind[i] = (v < u + REACH) & (disc > 0) & (mirror_up > 0) ? WHOLE + clipped : MISSED;
        float first = first_offset(u), past = CAP_KNEE + u, span = u + REACH - first, per_both = 1 / (past * span);
        float y = u * span * per_both, row = y * (CAPS - 1);
        float column = positive(v - first) * past * per_both * (OFFSETS - 1.001f);
        int j = (int)row, k = (int)column;
        cell[i] = j * OFFSETS + k;
        size[i] = y;
        between[i] = row - (float)j;
        along[i] = column - (float)k;
    }
    for (int i = 0; i < count; i++) {
        caps->hit[hits] = i;
        hits += kind[i] != MISSED;
    }
    float4 texels[BLOCK];
    for (int h = 0; h < hits; h++) { /* two texels a load: less than gathers cost */
        int i = caps->hit[h];
        const float(*t)[4] = lobe->texels + cell[i];
        float8 above = *(const float8 *)t, below = *(const float8 *)(t + OFFSETS),
               m = above + between[i] * (below - above);
        float4 left = {m[0], m[1], m[2], m[3]}, right = {m[4], m[5], m[6], m[7]};
        texels[i] = left + along[i] * (right - left);
    }
#pragma omp simd
    for (int i = 0; i < count; i++) { /* of no meaning where missed */
        float p = texels[i][0] + blend * (texels[i][2] - texels[i][0]);
        float q = texels[i][1] + blend * (texels[i][3] - texels[i][1]);
        caps->value[i] = size[i] * size[i] * (p * size[i] * caps->mirror_up[i] + q * caps->up[i]);
    }
    for (int h = 0; h < hits; h++) {
        int i = caps->hit[h];
        if (kind[i] == CLIPPED)
            caps->value[i] = clipped_cap(lobe, caps->omega[i], caps->cos_mirror[i], caps->up[i], caps->mirror_up[i]);
    }
    return hits;
}
