/* SPDX-License-Identifier: Apache-2.0 */
/* Directions and caps over the plane whose normal is z; angles in rad. */
#ifndef TESTS_CAPS_H
#define TESTS_CAPS_H

#include "eas/vec.h"

static inline float3 direction(float elevation, float azimuth)
{
    return vec3(cosf(elevation) * cosf(azimuth), cosf(elevation) * sinf(azimuth), sinf(elevation));
}

/* At azimuth 0. */
static inline struct cap cap_at(float elevation, float theta)
{
    return (struct cap){direction(elevation, 0), 4 * PI * sqr(sinf(theta / 2))};
}

#endif
