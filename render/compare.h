/* SPDX-License-Identifier: Apache-2.0 */
/* Errors between two pictures on linear radiance. */
#ifndef RENDER_COMPARE_H
#define RENDER_COMPARE_H

#include "render/image.h"

/* RGB together over a set of pixels, after: RMSE = sqrt(mean (x-r)^2), CV(RMSE) = RMSE / mean r,
 * relMSE = mean (x-r)^2/(r^2 + .01 mean(r)^2), mean_ratio = mean x / mean r. With two independent halves A, B of the reference,
 * r = (A+B)/2 and (x-r)^2 becomes (x-A)(x-B), which is free of the reference's noise (a mean below 0 is reported as -sqrt|mean|).
 * block_cv: the same over means of 8x8 pixel blocks, block_sigma its standard error from the blocks' spread. */
struct compare_errors {
    double rmse, cv_rmse, relmse, mean_ratio, block_cv, block_sigma;
    double reference_cv; /* noise of r itself: CV(RMSE) of (A-B)/2; 0 without halves */
    long pixels;
};

struct compare_result {
    struct compare_errors all;     /* every pixel */
    struct compare_errors masked;  /* without directly seen emitters and 4 pixels around them */
};

/* Compares the channels "Combined" of `image` with those of `a` (and `b`, or NULL). Emitters are taken from the AOV
 * "Emission" of `a` or else of `image`; without one nothing is masked. False and a sentence where sizes or channels do not fit, or a pixel
 * isn't finite. */
bool compare(const struct image *image, const struct image *a, const struct image *b, const char *layer,
             struct compare_result *result, char error[static IMAGE_ERROR]);

/* A false-colour picture of |x-r| / mean r, RGB averaged, display-ready: black 0 … dark blue, green, yellow, red, white at 1. */
bool compare_picture(const struct image *image, const struct image *a, const struct image *b, const char *layer,
                     struct image *picture, char error[static IMAGE_ERROR]);

#endif
