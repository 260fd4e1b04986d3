/* SPDX-License-Identifier: Apache-2.0 */
/* Beckmann's distribution of microfacets (Walter et al. 2007), sampled by visible normals (Heitz and d'Eon 2014). Pure
 * functions of what ggx.h stretches by its alphas. */
#ifndef EAS_BECKMANN_H
#define EAS_BECKMANN_H

#include "eas/vec.h"

/* Density of normals times the product of the alphas, from the squared tangent of the stretched normal and the normal's
 * own squared cosine. */
static inline float beckmann_d(float tan2, float cos2) { return expf(-tan2) / (PI * sqr(cos2)); }

/* Smith's Lambda from the squared tangent of a stretched direction: Walter's rational fit, as Cycles has it. */
static inline float beckmann_lambda(float tan2)
{
    if (tan2 < .39f) return 0;
    float a = 1 / sqrtf(tan2);
    return ((.396f * a - 1.259f) * a + 1) / ((2.181f * a + 3.535f) * a);
}

/* A visible normal seen from w, both in the frame where n is z. */
float3 beckmann_visible_normal(float alpha_x, float alpha_y, float3 w, const float u[static 2]);

#endif
