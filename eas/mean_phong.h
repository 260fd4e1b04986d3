/* SPDX-License-Identifier: Apache-2.0 */
/* Modified Phong's part of mean_brdf.h: the integral of f cos over caps, many at a time, from tables.
 *
 * The integral as a vector has two coefficients, tabulated over exponent, cap and distance from the mirror direction in
 * the lobe's sigmas, in which they hardly depend on the exponent; a cap across the horizon is a sum over rows. Errors,
 * relative to the integral's largest value over viewers, for exponents of 5 to 1000 and caps up to 20 degrees: 2.5e-3,
 * across the horizon 2e-2. Any thread may call any of it.
 */
#ifndef EAS_MEAN_PHONG_H
#define EAS_MEAN_PHONG_H

#include "eas/vec.h"

enum { MEAN_PHONG_SPANS = 8, MEAN_PHONG_CAPS = 56, MEAN_PHONG_OFFSETS = 48 };

/* The tables, 340 KB; what they hold stands in mean_phong.c. */
struct mean_phong {
    float table[MEAN_PHONG_SPANS][MEAN_PHONG_CAPS][MEAN_PHONG_OFFSETS][4];
};

/* Takes some tens of milliseconds. */
void mean_phong_fill(struct mean_phong *tables);

/* A lobe of one exponent. */
struct mean_phong_lobe {
    const float (*texels)[4]; /* the span of the tables that holds the exponent, */
    float blend;              /* and how far on in it */
    float exponent, width;    /* width: the lobe's sigma, rad */
};

struct mean_phong_lobe mean_phong_lobe(const struct mean_phong *tables, float exponent);

/* Caps and the viewers that see them, an array a component. */
enum { MEAN_PHONG_BLOCK = 128 };
struct mean_phong_caps {
    float omega[MEAN_PHONG_BLOCK];      /* solid angle, sr: 0 … 2 pi */
    float cos_mirror[MEAN_PHONG_BLOCK]; /* axis . mirror direction */
    float up[MEAN_PHONG_BLOCK];         /* axis . n */
    float mirror_up[MEAN_PHONG_BLOCK];  /* mirror direction . n */
    /* The result: the integral of f cos over each, weight 1, and the indices of those that it is for; the rest send
     * nothing into the lobe. */
    float value[MEAN_PHONG_BLOCK];
    int hit[MEAN_PHONG_BLOCK];
};

/* For the first `count` caps; returns how many are hit. A cap that isn't cut by the horizon costs less than a cosf and
 * a powf, one that is some eight times that (tests/mean_brdf_bench.c). */
int mean_phong_caps(const struct mean_phong_lobe *lobe, struct mean_phong_caps *caps, int count);

#endif
