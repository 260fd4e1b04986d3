/* SPDX-License-Identifier: Apache-2.0 */
/* Samples where the noise is: as many in each pixel as make the error of the picture least, about in proportion to the
 * standard deviation (Neyman 1934, of strata). That is found by a pilot, two pictures at a part of the pixels, which
 * are thrown away: samples that had a say in how many there are would bias the mean.
 */
#ifndef RENDER_ADAPTIVE_H
#define RENDER_ADAPTIVE_H

#include "render/render.h"

/* Fewer samples a pixel aren't worth a pilot. */
enum { ADAPTIVE_LEAST = 8 };

/* weights[height * width]: a pixel's share of the samples, 1 in the mean; the caller frees. *gain: as many samples
 * everywhere alike have so many times the variance. False: no memory. */
bool adaptive_weights(const struct model *model, const struct cached *cached, uint64_t seed, struct progress *progress,
                      float **weights, double *gain);

#endif
