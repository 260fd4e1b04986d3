/* SPDX-License-Identifier: Apache-2.0 */
/* The paper's mean BRDF (section 5): F~ of eq. 8 for all viewers, fitted by one Lafortune lobe a cell of a table over
 * the cap's elevation and solid angle. The renderer uses mean_brdf.h, which errs far less; this stands beside it for
 * comparison (tests/lobe_fit_test.c states both errors).
 *
 * Directions are local: n is z, unit. Lobes are isotropic, of any type; F~ is in luminance, 1/sr. The fit searches with
 * a fixed seed (it sets NLopt's, of the calling thread): the same input gives the same lobe. Any thread may call.
 *
 * Departures from the paper: NLopt's controlled random search and a local finish stand for its genetic algorithm; the
 * table has cells for the BRDF itself (Omega = 0), since the lobe changes most below the paper's first Omega; none
 * for an axis in the surface, where the paper's caps are empty.
 */
#ifndef EAS_LOBE_FIT_H
#define EAS_LOBE_FIT_H

#include "eas/mean_brdf.h"

/* max(0, Cx wi.x wo.x + Cy wi.y wo.y + Cz wi.z wo.z)^n for the axis wi of the cap, with Cx = Cy: for an axis in the
 * plane y = 0 Cy has no effect, so that a fit can't tell it. */
struct lobe_fit {
    float cx, cz, exponent;
};

float lobe_fit_eval(const struct lobe_fit *fit, float3 wi, float3 wo);

/* F~ itself by quadrature, of `steps` rings and sectors, for a cap above the horizon, whose axis is wi. */
float lobe_fit_exact(const struct lobe *lobe, float3 wi, float omega, float3 wo, int steps);

/* The integral of the cosine over a cap above the horizon: F~'s denominator. */
static inline float lobe_fit_cosine(float3 wi, float omega) { return omega * (1 - omega / (4 * PI)) * wi.z; }

/* The lobe that errs least, in squares over all viewers above the horizon, for a cap whose axis stands theta rad (above
 * 0, below pi/2) from n. False: no memory. Takes some milliseconds. */
bool lobe_fit(const struct lobe *lobe, float theta, float omega, struct lobe_fit *fit);

/* Fits at theta_i = i pi/(2 thetas), 0 < i < thetas, and Omega_j = j 2 pi (1 - sin theta_i)/omegas, 0 <= j <= omegas.
 */
struct lobe_fit_table {
    int thetas, omegas;
    struct lobe_fit *fits; /* a row of omegas + 1 for each theta */
};

/* False: no memory. */
bool lobe_fit_table_build(const struct lobe *lobe, int thetas, int omegas, struct lobe_fit_table *table);

/* Coefficients interpolated linearly, first over each row's Omega, then over theta; from outside the nearest. */
struct lobe_fit lobe_fit_table_at(const struct lobe_fit_table *table, float theta, float omega);

void lobe_fit_table_free(struct lobe_fit_table *table);

#endif
