/* SPDX-License-Identifier: Apache-2.0 */
/* One record under lobes of growing exponent: the paper's 6.3, figures 13 and 14 and table 7.
 *
 * Some 4000 rays, one a stratum, bring the indirect light at one point of a scene. For each exponent the radiance that
 * a modified Phong lobe of albedo 1 reflects of it is drawn over all directions, a pixel each, the hemisphere projected
 * onto its disc: from the samples themselves (eq. 17), from growing numbers of EAS, and from
 * hemispherical harmonics of growing order.
 */
#ifndef SCENES_EXPERIMENTS_ONE_RECORD_H
#define SCENES_EXPERIMENTS_ONE_RECORD_H

#include "render/diffuse_cache.h"

/* The record is where pixel (x, y) of the camera looks. Writes pictures of side x side pixels into the folder `out`:
 * "incident.exr" (what the record sees) and those of the CSV printed to stdout, a row a picture: exponent, method
 * (reference, eas or hsh), count (of samples or EAS; order), bytes (as stored, gradients included), picture. False and
 * a sentence on failure. */
bool one_record(const struct model *model, const struct diffuse_cache *bounced, int x, int y, int side, const char *out,
                char error[static SCENE_ERROR]);

#endif
