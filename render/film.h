/* SPDX-License-Identifier: Apache-2.0 */
/* The picture while it is rendered: the AOVs of a pixel, summed over samples. */
#ifndef RENDER_FILM_H
#define RENDER_FILM_H

#include "eas/vec.h"
#include "render/image.h"

/* Sums over the samples of a pixel; film_image divides by `samples`. */
struct pixel {
    rgb emission, direct, indirect, albedo;
    float3 normal; /* world */
    float depth;   /* m, to the nearest hit: the mean over samples that hit */
    float samples, hits;
    rgb records;     /* zones drawn over the image; only written where a cache was used */
    float eas_count; /* EAS evaluated, a sample */
};

struct film {
    int width, height;
    bool cache;           /* Records and EASCount are written */
    struct pixel *pixels; /* height * width, row 0 at the top */
};

bool film_alloc(struct film *film, int width, int height, bool cache);
void film_free(struct film *film);

/* *square: how much the mean radiance of two pixels differs, squared, the mean over the channels. False where either
 * has no samples or sees emitters or the background: such pixels don't count in errors. */
bool film_differ(const struct pixel *p, const struct pixel *q, double *square);

/* The noise of film a by its difference from b, an independent one: CV(RMSE) of the pixels that count. */
double film_noise(const struct film *a, const struct film *b);

/* The AOVs as channels "ViewLayer.Combined.R" … : Combined, Direct, Indirect, Emission, Albedo, Normal, Depth (1e10
 * where nothing is hit), and with a cache Records and EASCount. False where memory runs out. */
bool film_image(const struct film *film, struct image *image);

#endif
