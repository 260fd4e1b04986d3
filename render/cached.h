/* SPDX-License-Identifier: Apache-2.0 */
/* A pixel by the caches (the second pass of the paper's Algorithm 1): methods eas, hsh and hybrid.
 *
 * Camera rays that find alike points share one look-up and one integral over the lamps; each has a shadow ray of its
 * own. Bounced light comes from the records: the diffuse part from irradiance, the lobes from EAS (eas), from HSH (hsh)
 * or from traced rays (hybrid, and lobes too narrow for records in all).
 */
#ifndef RENDER_CACHED_H
#define RENDER_CACHED_H

#include "render/direct.h"
#include "render/fill.h"
#include "render/film.h"

struct cached {
    const struct model *model; /* borrowed */
    const struct fill *fill;   /* borrowed */
    struct direct direct;
};

/* False: no memory. */
bool cached_prepare(const struct model *model, const struct fill *fill, struct cached *cached);
void cached_free(struct cached *cached);

/* Adds spp samples to pixel (x, y). `memory`: direct_forget's, or what pixels beside it left. Any thread may call; the
 * result depends on the arguments alone. */
void cached_pixel(const struct cached *cached, int x, int y, int spp, uint64_t seed, struct shadow_memory *memory,
                  struct pixel *pixel);

/* The caches' own error in the picture, noise apart: CV(RMSE) at 2048 of its points, by how much the records disagree
 * that overlap there. What they have in common isn't seen. The same for any number of threads. False: no memory. */
bool cached_error(const struct cached *cached, uint64_t seed, double *error);

#endif
