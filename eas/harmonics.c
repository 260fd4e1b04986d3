/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/harmonics.h"

#include <stdlib.h>
#include <string.h>

/* Bands of the spherical harmonics that an order is tilted by: wide enough for the narrower functions of HSH. */
#define BANDS(order) ((3 * (order) + 1) / 2)
#define PAIRS(order) ((order) * ((order) + 1) / 2)

enum { MOST_BANDS = BANDS(HARMONICS_ORDER), HEIGHTS = 160 };

/* The Legendre functions P_lm, normalised so that Y = P_lm(cos theta) {1; sqrt(2) cos(m phi); sqrt(2) sin(m phi)}, by
 * P_lm = up x P_(l-1)m - down P_(l-2)m; no sign alternates with m. Arrays over pairs: (l, m) at l(l+1)/2 + m. */
struct harmonics {
    float up[PAIRS(MOST_BANDS)], down[PAIRS(MOST_BANDS)], diagonal[MOST_BANDS];
    float step[PAIRS(MOST_BANDS)]; /* of a rotation about y, from m - 1 to m */
    /* The integral of H_lm Y_km over the hemisphere, [m][l][k], each from m on. */
    float *to_bands[HARMONICS_ORDER];
};

/* P_lm of `bands` bands at x, s = sqrt(1 - x^2). */
static void legendre(const struct harmonics *tables, int bands, float x, float s, float *restrict p)
{
    p[0] = .28209479f; /* sqrt(1/4pi) */
    for (int l = 1; l < bands; l++) {
        const float *up = tables->up + PAIRS(l), *down = tables->down + PAIRS(l);
        const float *one = p + PAIRS(l - 1), *two = p + PAIRS(l - 2); /* one, two bands below */
        float *here = p + PAIRS(l);
        for (int m = 0; m <= l - 2; m++) here[m] = up[m] * x * one[m] - down[m] * two[m];
        here[l - 1] = up[l - 1] * x * one[l - 1];
        here[l] = tables->diagonal[l] * s * one[l - 1];
    }
}

/* Those of 2z - 1; level = sqrt(1 - z^2), which near the normal says more than z. */
static void hemispherical(const struct harmonics *tables, int order, float z, float level, float *p)
{
    z = maxf(z, 0);
    legendre(tables, order, 2 * z - 1, 2 * level * sqrtf(z / (1 + z)), p);
}

float harmonics_height(int i, int count, float *z, float *level)
{
    double angle = (double)PI * (i + .5) / count, sum = 1;
    for (int j = 1; j <= count / 2; j++) sum -= (2 * j == count ? 1 : 2) * cos(2 * j * angle) / (4.0 * j * j - 1);
    *z = (float)(.5 + .5 * cos(angle));
    *level = (float)(sin(.5 * angle) * sqrt(1.5 + .5 * cos(angle)));
    return (float)(sum / count);
}

static bool fill_conversion(struct harmonics *tables)
{
    float h[PAIRS(HARMONICS_ORDER)], y[PAIRS(MOST_BANDS)];
    for (int m = 0; m < HARMONICS_ORDER; m++) {
        size_t size = (size_t)((HARMONICS_ORDER - m) * (MOST_BANDS - m));
        if (!(tables->to_bands[m] = calloc(size, sizeof(float)))) return false;
    }
    for (int i = 0; i < HEIGHTS; i++) {
        float z, level, weight = harmonics_height(i, HEIGHTS, &z, &level) * 2 * PI * sqrtf(2);
        hemispherical(tables, HARMONICS_ORDER, z, level, h);
        legendre(tables, MOST_BANDS, z, level, y);
        for (int m = 0; m < HARMONICS_ORDER; m++) {
            float *to = tables->to_bands[m];
            for (int l = m; l < HARMONICS_ORDER; l++)
                for (int k = m; k < MOST_BANDS; k++) *to++ += weight * h[PAIRS(l) + m] * y[PAIRS(k) + m];
        }
    }
    return true;
}

struct harmonics *harmonics_build(void)
{
    struct harmonics *tables = calloc(1, sizeof *tables);
    if (!tables) return NULL;
    for (int l = 1; l < MOST_BANDS; l++) {
        for (int m = 0; m <= l; m++) {
            double ll = (double)l * l, mm = (double)m * m, below = (double)(l - 1) * (l - 1);
            int i = PAIRS(l) + m;
            if (m < l) tables->up[i] = (float)sqrt((4 * ll - 1) / (ll - mm));
            if (m < l - 1) tables->down[i] = (float)sqrt((4 * ll - 1) / (ll - mm) * (below - mm) / (4 * below - 1));
            tables->step[i] = (float)(.5 * sqrt((double)(l + m) * (l - m + 1)));
        }
        tables->diagonal[l] = (float)sqrt((2.0 * l + 1) / (2.0 * l));
    }
    if (fill_conversion(tables)) return tables;
    harmonics_free(tables);
    return NULL;
}

void harmonics_free(struct harmonics *tables)
{
    if (!tables) return;
    for (int m = 0; m < HARMONICS_ORDER; m++) free(tables->to_bands[m]);
    free(tables);
}

void harmonics_profile(const struct harmonics *tables, int order, float z, float level, float *values)
{
    hemispherical(tables, order, z, level, values);
    for (int l = 0; l < order; l++)
        for (int m = 0; m <= l; m++) values[PAIRS(l) + m] *= m ? 2 : sqrtf(2);
}

/* cos(m phi) and sin(m phi) for m < count. */
static void multiples(int count, float cosine, float sine, float *cosines, float *sines)
{
    cosines[0] = 1;
    sines[0] = 0;
    for (int m = 1; m < count; m++) {
        cosines[m] = cosines[m - 1] * cosine - sines[m - 1] * sine;
        sines[m] = sines[m - 1] * cosine + cosines[m - 1] * sine;
    }
}

void harmonics_at(const struct harmonics *tables, int order, float3 dir, float *restrict values)
{
    float p[PAIRS(HARMONICS_ORDER)], cosines[HARMONICS_ORDER], sines[HARMONICS_ORDER];
    float level = sqrtf(dir.x * dir.x + dir.y * dir.y);
    hemispherical(tables, order, dir.z, level, p);
    if (level > 0) multiples(order, dir.x / level, dir.y / level, cosines, sines);
    else multiples(order, 1, 0, cosines, sines);
    for (int l = 0; l < order; l++) {
        float *c = values + l * l, *s = c + l;
        for (int m = 0; m <= l; m++) c[m] = 2 * p[PAIRS(l) + m] * cosines[m];
        for (int m = 1; m <= l; m++) s[m] = 2 * p[PAIRS(l) + m] * sines[m];
        c[0] *= sqrtf(.5f);
    }
}

void harmonics_turn(int order, float cosine, float sine, const float *in, float *out)
{
    float cosines[HARMONICS_ORDER], sines[HARMONICS_ORDER];
    multiples(order, cosine, sine, cosines, sines);
    for (int l = 0; l < order; l++) {
        int first = l * l;
        out[first] = in[first];
        for (int m = 1; m <= l; m++) {
            float c = in[first + m], s = in[first + l + m];
            out[first + m] = c * cosines[m] - s * sines[m];
            out[first + l + m] = s * cosines[m] + c * sines[m];
        }
    }
}

/* Spherical harmonics while they are rotated: the coefficients with cos(m phi) and those with sin(m phi) apart, over
 * pairs, for a rotation about y doesn't mix them. */
struct bands {
    float cosines[PAIRS(MOST_BANDS)], sines[PAIRS(MOST_BANDS)];
};

/* out = out + 2/bands A in, A the derivative of a rotation about y: (l, m) takes from (l, m - 1), gives to it. */
static void add_derivative(const struct harmonics *tables, int bands, const float *in, bool sines, float *out)
{
    float share = 2 / (float)bands;
    for (int l = 1; l < bands; l++) {
        const float *from = in + PAIRS(l), *step = tables->step + PAIRS(l);
        float *to = out + PAIRS(l),
              first = sines ? 0 : share * sqrtf(2) * step[1]; /* m = 0 has no sine, nor its root */
        to[0] -= first * from[1];
        to[1] += first * from[0];
        for (int m = 2; m <= l; m++) to[m] += share * step[m] * from[m - 1];
        for (int m = 1; m < l; m++) to[m] -= share * step[m + 1] * from[m + 1];
    }
}

/* exp(beta A) = J_0(z) + 2 sum_k J_k(z) T_k, z = beta bands, T_(k+1) = 2 (A/bands) T_k + T_(k-1), T_1 = A/bands: the
 * series of Jacobi and Anger, which ends soon after k = z. */
static void rotate(const struct harmonics *tables, int bands, float beta, bool sines, float *v)
{
    float turns[2][PAIRS(MOST_BANDS)], *now = turns[0], *next = turns[1]; /* T_k v and T_(k+1) v */
    double z = beta * bands;
    int count = PAIRS(bands), terms = (int)(z + 6 + 3 * cbrt(z));
    memcpy(now, v, (size_t)count * sizeof *v);
    memset(next, 0, (size_t)count * sizeof *v);
    add_derivative(tables, bands, now, sines, next);
    for (int i = 0; i < count; i++) {
        next[i] *= .5f;
        v[i] *= (float)j0(z);
    }
    for (int k = 1; k <= terms; k++) {
        float weight = 2 * (float)jn(k, z);
        for (int i = 0; i < count; i++) v[i] += weight * next[i];
        add_derivative(tables, bands, next, sines, now); /* T_(k-1) becomes T_(k+1) */
        float *swap = now;
        now = next;
        next = swap;
    }
}

void harmonics_tilt(const struct harmonics *tables, int order, float beta, const float *in, float *out)
{
    int bands = BANDS(order);
    struct bands y;
    memset(y.cosines, 0, (size_t)PAIRS(bands) * sizeof(float));
    memset(y.sines, 0, (size_t)PAIRS(bands) * sizeof(float));
    for (int m = 0; m < order; m++)
        for (int l = m; l < order; l++) {
            const float *to = tables->to_bands[m] + (l - m) * (MOST_BANDS - m) - m;
            float c = in[l * l + m], s = m ? in[l * l + l + m] : 0;
            for (int k = m; k < bands; k++) {
                y.cosines[PAIRS(k) + m] += to[k] * c;
                y.sines[PAIRS(k) + m] += to[k] * s;
            }
        }
    rotate(tables, bands, beta, false, y.cosines);
    rotate(tables, bands, beta, true, y.sines);
    for (int m = 0; m < order; m++)
        for (int l = m; l < order; l++) {
            const float *to = tables->to_bands[m] + (l - m) * (MOST_BANDS - m) - m;
            float c = 0, s = 0;
            for (int k = m; k < bands; k++) {
                c += to[k] * y.cosines[PAIRS(k) + m];
                s += to[k] * y.sines[PAIRS(k) + m];
            }
            out[l * l + m] = c;
            if (m) out[l * l + l + m] = s;
        }
}
