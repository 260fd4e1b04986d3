/* SPDX-License-Identifier: Apache-2.0 */
/* The shift experiment: the light of one record on the back wall of scenes/cornell_glossy, seen from 24 points .1 m
 * (5 % of the room) about it, against fresh gathers of 16000 rays there; 128 viewers each. What translation must beat
 * is the record's light left where it is.
 */
#ifndef SCENES_EXPERIMENTS_SHIFT_H
#define SCENES_EXPERIMENTS_SHIFT_H

#include "render/diffuse_cache.h"

/* The ways to see a record from elsewhere. */
enum shift_way {
    SHIFT_STAY,       /* EAS in the directions in which the record sees them */
    SHIFT_PINNED,     /* EAS on the surface that was hit, whatever it mirrors: the paper */
    SHIFT_IMAGES,     /* what is mirrored at its virtual image */
    SHIFT_TRANSLATED, /* the same, with the visibility gradient: what the renderer does */
    SHIFT_HSH,        /* harmonics with gradients */
    SHIFT_FRESH,      /* no record: as many rays as it has, at the point itself: their noise */
    SHIFT_WAYS
};
extern const char *const SHIFT_NAMES[SHIFT_WAYS];

enum { SHIFT_EXPONENTS = 2 };
extern const float SHIFT_EXPONENT[SHIFT_EXPONENTS]; /* of the record's lobe */

struct shift_result {
    double cv[SHIFT_WAYS];      /* of reflected luminance over points and viewers, against the fresh gathers */
    uint32_t bytes[SHIFT_WAYS]; /* of the record's EAS or harmonics */
};

/* False: no memory. */
bool shift_measure(const struct model *model, const struct diffuse_cache *bounced,
                   struct shift_result results[static SHIFT_EXPONENTS]);

#endif
