/* SPDX-License-Identifier: Apache-2.0 */
/* Hemispherical harmonics (HSH): Gautron, Křivánek, Pattanaik, Bouatouch 2004, "A novel hemispherical basis for
 * accurate and efficient rendering". Real spherical harmonics Y with cos(theta) replaced by 2 cos(theta) - 1, times
 * sqrt(2): orthonormal over the hemisphere.
 *
 * Order N has bands l = 0 ... N-1 and N^2 coefficients; those of a band begin at l^2, m = 0 ... l with cos(m phi),
 * then m = 1 ... l with sin(m phi), so that a lower order's are the first of a higher one's. Directions are unit, in a
 * frame where the normal is z.
 */
#ifndef EAS_HARMONICS_H
#define EAS_HARMONICS_H

#include "eas/vec.h"

enum { HARMONICS_ORDER = 48 }; /* the most */

struct harmonics; /* tables; read-only after building: any thread may use them */

/* NULL where memory runs out. Takes some tens of milliseconds. */
struct harmonics *harmonics_build(void);
void harmonics_free(struct harmonics *tables);

/* Height i of `count` between the horizon and the normal, z, and in *level sqrt(1 - z^2), by Fejér's first rule:
 * returns its weight in an integral over z, exact for products of harmonics whose bands sum to less than `count`. */
float harmonics_height(int i, int count, float *z, float *level);

/* All order^2 functions at a direction. */
void harmonics_at(const struct harmonics *tables, int order, float3 dir, float *values);

/* Those of m >= 0 alone, at (level, 0, z): (l, m) at l(l+1)/2 + m. */
void harmonics_profile(const struct harmonics *tables, int order, float z, float level, float *values);

/* Turns a function about the normal by the angle whose cosine and sine are given; out may be in. Exact. */
void harmonics_turn(int order, float cosine, float sine, const float *in, float *out);

/* Tilts a function by beta (0 ... pi/2), the normal toward x. What goes below the horizon is lost, and what comes up
 * from it is black. As published, by way of spherical harmonics (Gautron et al. 2004): of half as many bands more,
 * which hold a function that falls to 0 at the horizon to about 1 %. They are rotated by the series of which Křivánek
 * et al. 2006, "Fast approximation to spherical harmonic rotation", keep the first terms. */
void harmonics_tilt(const struct harmonics *tables, int order, float beta, const float *in, float *out);

#endif
