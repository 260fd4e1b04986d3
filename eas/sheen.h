/* SPDX-License-Identifier: Apache-2.0 */
/* The sheen lobe of brdf.h: T. Zeltner, B. Burley, M. J.-Y. Chiang, "Practical Multiple-Scattering Sheen Using Linearly
 * Transformed Cosines", SIGGRAPH 2022 talks: a cosine lobe transformed linearly, with an albedo, both functions of
 * roughness and the viewer's cosine. Their tables by S. Hill's closed form (as MaterialX 1.39 has it): the albedo errs
 * by .003 in the mean over roughness .13 to 1, by .04 at most, near the horizon.
 *
 * wi, wo, n as in brdf.h. Pure functions.
 */
#ifndef EAS_SHEEN_H
#define EAS_SHEEN_H

#include "eas/brdf.h"

/* A white one, its albedo as the weight. */
struct lobe sheen_lobe(float roughness, float cos_o);

/* f, weight included, and in *pdf the density of sheen_sample. n.wi and n.wo must be above 0. */
rgb sheen_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf);
float3 sheen_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2]);

#endif
