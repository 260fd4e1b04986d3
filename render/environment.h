/* SPDX-License-Identifier: Apache-2.0 */
/* Radiance from outside, split in two: strong = max(L - threshold, 0) a channel, which is sampled by importance, and
 * the rest, which is at most the threshold and met by chance.
 *
 * The threshold is 2 x the mean luminance over the sphere: what stands out of that is small and bright (sun, windows,
 * lamps in the picture) and would be noise if met by chance. A constant environment has nothing strong.
 * Read-only once built: any thread may call.
 */
#ifndef RENDER_ENVIRONMENT_H
#define RENDER_ENVIRONMENT_H

#include "render/texture.h"

struct environment {
    rgb radiance;              /* W/m2/sr, or the factor of the picture */
    const struct image *image; /* equirectangular, borrowed; NULL: constant */
    bool closest;              /* no interpolation */
    float3 axes[3];            /* world directions of the picture's x, y, z */
    float threshold;           /* W/m2/sr */
    float *rows, *columns;     /* cumulative chances: of rows [height + 1], within each row [height][width + 1] */
    /* Where a search begins in each of equal parts of [0, 1): [row_guides + 1], [height][column_guides + 1]. */
    uint32_t *row_guide, *column_guide;
    int row_guides, column_guides;
    float *tops;       /* sine of the latitude at the upper border of each row [height + 1] */
    float strong_flux; /* luminance of the strong part summed over the sphere, W/m2; 0: nothing is strong */
};

/* False where memory runs out; nothing is left to free then. */
bool environment_build(const struct scene_world *world, const struct textures *textures,
                       struct environment *environment);
void environment_free(struct environment *environment);

/* The two parts along dir (world, unit). Their sum is all that comes from there. */
rgb environment_strong(const struct environment *environment, float3 dir);
rgb environment_rest(const struct environment *environment, float3 dir);

/* A direction drawn by the strong part, its pdf per solid angle in *pdf, and the strong part along it; needs
 * strong_flux > 0. u: two numbers in [0, 1). */
float3 environment_sample(const struct environment *environment, const float u[static 2], float *pdf, rgb *strong);
float environment_pdf(const struct environment *environment, float3 dir);

/* Part of the strong light: a group of neighbouring directions. */
struct environment_cell {
    rgb flux;     /* radiance x solid angle, W/m2 on a surface that faces it */
    float3 wi;    /* unit, world: its mean direction */
    float spread; /* length of the mean of its unit directions: 1 where it is small */
};

/* Directions in a cell, each for as much of its light (luminance). */
enum { ENVIRONMENT_PLACES = 64 };

/* The strong light in at most `most` compact cells, all of it: the cell that blurs most is halved until there are so
 * many. Cells that follow each other are mostly neighbours. places: ENVIRONMENT_PLACES a cell. Returns how many cells;
 * -1 where memory runs out. */
int environment_cells(const struct environment *environment, int most, struct environment_cell *cells,
                      float3 *places);

#endif
