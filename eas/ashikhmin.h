/* SPDX-License-Identifier: Apache-2.0 */
/* The ASHIKHMIN lobe of brdf.h: M. Ashikhmin, P. Shirley, "An Anisotropic Phong BRDF Model", 2000, its specular part
 * without Fresnel, exponents 2/alpha^2 - 2, as Cycles has it.
 *
 * wi, wo, n as in brdf.h. Pure functions.
 */
#ifndef EAS_ASHIKHMIN_H
#define EAS_ASHIKHMIN_H

#include "eas/brdf.h"

/* f, weight included, and in *pdf the density of ashikhmin_sample. n.wi and n.wo must be above 0. */
rgb ashikhmin_eval(const struct lobe *lobe, float3 n, float3 wo, float3 wi, float *pdf);

/* It may lie below the horizon. */
float3 ashikhmin_sample(const struct lobe *lobe, float3 n, float3 wo, const float u[static 2]);

#endif
