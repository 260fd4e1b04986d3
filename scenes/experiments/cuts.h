/* SPDX-License-Identifier: Apache-2.0 */
/* The paper's tables 1 to 6: cuts through its mean BRDF F~ (eq. 8), exact, as the renderer has it and as the paper fits
 * it, for three exponents, four solid angles and four elevations of the cap. */
#ifndef SCENES_EXPERIMENTS_CUTS_H
#define SCENES_EXPERIMENTS_CUTS_H

#include <stdbool.h>

/* Prints a CSV of F~ in 1/sr by viewers' angles in degrees: in cut V1, the plane of incidence, from the normal, towards
 * the mirror direction; in V2, the plane across it through V1's largest value, from there. The fit is looked up in a
 * table (eas/lobe_fit.h), as the paper does. False: no memory. Takes some 20 s of CPU. */
bool cuts_print(void);

#endif
