/* SPDX-License-Identifier: Apache-2.0 */
/* What a camera ray sees, noted in the AOVs of its pixel. */
#ifndef RENDER_PRIMARY_H
#define RENDER_PRIMARY_H

#include "render/film.h"
#include "render/rng.h"
#include "render/shade.h"

/* The ray through (x, y), in pixels from the picture's top left corner, and the place of the lens that `lens` chooses;
 * panes are passed by chance, and what they let through is in the point's reflectance. Adds a sample with its emission,
 * albedo, normal and depth. False where it sees the background, whose light is then emission, as is that of lamps. */
bool primary(const struct model *model, float x, float y, float2 lens, struct rng *rng, struct pixel *pixel,
             struct point *point);

#endif
