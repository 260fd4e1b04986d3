/* SPDX-License-Identifier: Apache-2.0 */
/* As many samples, and as fine caches, as an error asks for.
 *
 * Noise is measured by a second picture of some of the pixels, the caches' own error by how much overlapping records
 * disagree (cached_error); the two are independent, so their squares add up. The caches may take three quarters of the
 * error: the coarsest are tried first, since the next finer ones cost several times as much; samples take the rest.
 */
#ifndef RENDER_ACCURACY_H
#define RENDER_ACCURACY_H

#include "render/render.h"

/* Settles RENDER_AUTO: eas where there is no error to reach; path where a pilot's noise says that so few samples a
 * pixel suffice that caches would cost more; else it stays, for accuracy_fill. False: no memory. */
bool accuracy_choose(const struct model *model, struct render_options *options, struct progress *progress);

/* The caches for options->error, the coarsest that are good enough. RENDER_AUTO becomes gather where few samples do
 * without records, hybrid where its samples then cost no more rays than its records did, else eas. As fill_build. */
bool accuracy_fill(const struct model *model, struct render_options *options, struct progress *progress,
                   struct fill *fill, char error[static SCENE_ERROR]);

/* Renders until the estimated error is at most options->error, or options->spp samples are there, as few rounds as a
 * pilot's noise allows; `film`: allocated, black. `cached` NULL: by path tracing. *estimate: the error, *spp: the
 * samples a pixel. False: no memory. */
bool accuracy_render(const struct model *model, const struct cached *cached, const struct render_options *options,
                     struct progress *progress, struct film *film, double *estimate, int *spp);

#endif
