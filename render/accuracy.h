/* SPDX-License-Identifier: Apache-2.0 */
/* As many samples, and as fine caches, as an error asks for.
 *
 * Noise is measured by two independent halves of the picture, the caches' own error by how much overlapping records
 * disagree (cached_error); the two are independent, so their squares add up. The caches may take three quarters of the
 * error: the coarsest are tried first, since the next finer ones cost several times as much; samples take the rest.
 */
#ifndef RENDER_ACCURACY_H
#define RENDER_ACCURACY_H

#include "render/render.h"

/* What RENDER_AUTO stands for: path tracing where the noise of some of its paths says that a few samples a pixel
 * suffice for options->error, as many as caches would cost; else eas. False: no memory. */
bool accuracy_choose(const struct model *model, const struct render_options *options, enum render_method *method);

/* The caches for options->error, the coarsest that are good enough. As fill_build. */
bool accuracy_fill(const struct model *model, const struct render_options *options, struct progress *progress,
                   struct fill *fill, char error[static SCENE_ERROR]);

/* Renders until the estimated error is at most options->error, or options->spp samples are there; `film`: allocated,
 * black. `cached` NULL: by path tracing. *estimate: the error, *spp: the samples a pixel. False: no memory. */
bool accuracy_render(const struct model *model, struct cached *cached, const struct render_options *options,
                     struct progress *progress, struct film *film, double *estimate, int *spp);

#endif
