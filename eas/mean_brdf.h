/* SPDX-License-Identifier: Apache-2.0 */
/* The mean BRDF over a cone (the paper's F~, eq. 8), as the integral that the renderer needs:
 *
 *     reflected radiance of a cap of constant radiance L  =  L * integral over the cap of f cos(theta_i)
 *
 * The paper divides by the cap's own integral of the cosine and multiplies by irradiance E instead of L; that quotient
 * is singular for caps near the horizon, so radiance and solid angle are kept here and the quotient is never formed.
 *
 * Modified Phong is done by tables, mean_phong.h; GGX in closed form, mean_ggx.h. Their errors stand there. The paper's
 * own way is in lobe_fit.h.
 */
#ifndef EAS_MEAN_BRDF_H
#define EAS_MEAN_BRDF_H

#include "eas/brdf.h"
#include "eas/mean_ggx.h"
#include "eas/mean_phong.h"

struct mean_brdf; /* the tables; read-only after building: any thread may use them */

/* NULL where memory runs out. Takes some tens of milliseconds. */
struct mean_brdf *mean_brdf_build(void);
void mean_brdf_free(struct mean_brdf *tables);

/* One lobe seen by one viewer at a point with normal n: what stays the same over the loop over caps. */
struct mean_lobe {
    const struct lobe *lobe;
    float3 n, wo, mirror;
    float n_dot_mirror;
    struct mean_phong_lobe phong; /* PHONG */
    struct mean_ggx ggx;          /* GGX */
};

struct mean_lobe mean_lobe(const struct mean_brdf *tables, const struct lobe *lobe, float3 n, float3 wo);

/* The integral over the cap of f cos(theta_i), above n's horizon; the lobe's weight included. */
rgb mean_lobe_cap(const struct mean_lobe *lobe, struct cap cap);

/* The same for each of many caps, which cost far less together. */
void mean_lobe_caps(const struct mean_lobe *lobe, const struct cap *caps, int count, rgb *values);

/* The same by midpoints of rings x sectors of the cap's part above the horizon: the oracle of the tests and of the
 * paper's tables. */
rgb mean_lobe_quadrature(const struct lobe *lobe, float3 n, float3 wo, struct cap cap, int rings, int sectors);

#endif
