/* SPDX-License-Identifier: Apache-2.0 */
/* GGX's part of mean_brdf.h: the integral of f cos over caps in closed form, for two alphas, with no fit and no table.
 *
 * The half vectors of a viewer and a circular cap fill a cone over an ellipse. In the space where microfacets are
 * stretched to a hemisphere, D(h) (h.wo) dh is a cosine (Heitz 2018, "Sampling the GGX distribution of visible
 * normals"), and the integral of a cosine over an elliptic cone is known: so far nothing is approximated, and the
 * eigenvalue of a 3 x 3 matrix is all it takes. What is left of f cos, masking and Fresnel reflectance, varies slowly
 * and is averaged over four points of the ellipse. A cap that the horizon cuts is a sum over 48 points that crowd where
 * the lobe is, all above the horizon. Any thread may call any of it.
 *
 * Errors, rms / largest, relative to the integral's largest value over viewers (tests/mean_ggx_bench.c), for alphas of
 * .03 to 1: ERRORS
 */
#ifndef EAS_MEAN_GGX_H
#define EAS_MEAN_GGX_H

#include "eas/brdf.h"

/* A lobe seen by one viewer: what stays the same over caps. Vectors but n are in the lobe's frame. */
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
