/* SPDX-License-Identifier: Apache-2.0 */
/* GGX's part of mean_brdf.h: the integral of f cos over caps in closed form, for two alphas, with no fit and no table.
 *
 * The half vectors of a viewer and a circular cap fill a cone over an ellipse. In the space where microfacets are
 * stretched to a hemisphere, D(h) (h.wo) dh is a cosine (Heitz 2018, "Sampling the GGX distribution of visible
 * normals"), whose integral over such a cone is known: so far nothing is approximated, and the eigenvalue of a 3 x 3
 * matrix is all it takes. What is left of f cos, masking and Fresnel reflectance, varies slowly and is averaged over
 * four points of the ellipse. A cap that the horizon cuts is a sum over 48 points that crowd where the lobe is, all of
 * them above the horizon.
 *
 * Errors in % of the integral's largest value over viewers, rms / largest, for alphas from .03 to 1, an anisotropy of 1
 * included (tests/mean_ggx_bench.c):
 *     cap, degrees                                       5          10          20          30
 *     above the horizon, F = 1                      .03 / .6   .05 / 1.2   .12 / 1.4   .18 / 1.2
 *     above the horizon, F from .04 to 1            .06 / 1.5  .11 / 3.1   .22 / 4.2   .25 / 2.6
 *     across the horizon                            .06 / 1.1  .12 / 2.3   .23 / 4.3   .48 / 10
 * Lobes much longer than wide err by more over wider caps across the horizon, and single precision fails where the cap
 * is a hundred times as wide as the lobe. A cap costs 3 times what a cosf and a powf do, one across the horizon 40
 * times. Any thread may call any of it.
 */
#ifndef EAS_MEAN_GGX_H
#define EAS_MEAN_GGX_H

#include "eas/brdf.h"

/* A lobe seen by one viewer: what stays the same over caps. Directions are in `frame`, the lobe's. */
struct mean_ggx {
    const struct lobe *lobe;
    struct frame frame;
    float3 wo, stretched; /* stretched: wo times the alphas */
    float3 level;         /* unit, at right angles to wo */
    float slant;          /* |stretched| */
};

struct mean_ggx mean_ggx(const struct lobe *lobe, float3 n, float3 wo);

/* The integral of f cos(theta_i) over each cap, above n's horizon; the lobe's weight included. Several at a time: one
 * alone costs what ten do. */
void mean_ggx_caps(const struct mean_ggx *m, const struct cap *caps, int count, rgb *values);

#endif
