/* SPDX-License-Identifier: Apache-2.0 */
/* Errors between two pictures on linear radiance. */
#ifndef RENDER_COMPARE_H
#define RENDER_COMPARE_H

#include "render/image.h"

/* What is compared: all borrowed. A picture may come as two halves, rendered independently of each other. */
struct compare_input {
    const struct image *image, *image2;         /* image2 may be NULL */
    const struct image *reference, *reference2; /* reference2 may be NULL */
    const char *layer;                          /* "Combined", "Indirect" …; NULL: Combined */
};

/* R, G, B together over a set of pixels. With x the picture, r the reference (each the mean of its halves):
 * RMSE = sqrt(mean (x-r)^2), CV(RMSE) = RMSE / mean r, relMSE = mean (x-r)^2/(r^2 + .01 (mean r)^2),
 * mean_ratio = mean x / mean r.
 * With halves A, B of the reference (x-r)^2 becomes (x-A)(x-B), with halves of both (x1-A)(x2-B): what remains is free
 * of the noise that the halves do not share. A mean of such products may fall below 0: its root is reported as
 * -sqrt|mean|. block_cv: CV(RMSE) of the means over 8x8 pixels, which shows bias under noise. block_sigma: its standard
 * error from the blocks' spread, so scaled that |block_cv| <= 2 block_sigma just where the mean product lies within two
 * standard errors of 0 (the square root has no standard error there); 0 where there are fewer than two blocks. */
struct compare_errors {
    double rmse, cv_rmse, relmse, mean_ratio, block_cv, block_sigma;
    double reference_cv; /* noise of r itself: CV(RMSE) of (A-B)/2; 0 without halves */
    long pixels;
};

struct compare_result {
    struct compare_errors all;    /* every pixel */
    struct compare_errors masked; /* without directly seen emitters and COMPARE_MARGIN pixels around them */
};

#define COMPARE_MARGIN 4
#define COMPARE_BLOCK 8

/* Emitters are where the AOV "Emission" (Cycles: "Emit") of the reference is above 0, or else that of the picture;
 * where neither has one, nothing is masked. False and a sentence where sizes or channels do not fit, a pixel isn't
 * finite, the reference's mean is not above 0 or all is masked. */
bool compare(const struct compare_input *input, struct compare_result *result, char error[static IMAGE_ERROR]);

/* A false-colour picture of |x-r| / mean r, R, G, B averaged, the mean over all pixels, display-ready: 0 black,
 * .02 dark blue, .05 blue, .1 green, .2 yellow, .5 red, 1 and more white, linear between. The caller frees *picture. */
bool compare_picture(const struct compare_input *input, struct image *picture, char error[static IMAGE_ERROR]);

#endif
