/* SPDX-License-Identifier: Apache-2.0 */
/* Lamps at the points that a pixel sees, with as little noise as the shadows allow.
 *
 * The points of a pixel that are alike share one unshadowed integral of their lobes over fixed cells of the lamps; what
 * each point adds is a shadow ray, and the share of the light that came through scales the integral, channel by
 * channel. Highlights in plain light have no noise then, for a lobe is averaged over each cell's solid angle (the mean
 * BRDF, eas/mean_brdf.h). The diffuse part is treated so under an environment alone, whose cells are exact, and sampled
 * under other lamps. Lobes too narrow for the cells are sampled with MIS.
 */
#ifndef RENDER_DIRECT_H
#define RENDER_DIRECT_H

#include "eas/mean_brdf.h"
#include "render/shade.h"

enum { DIRECT_DIFFUSE, DIRECT_LOBES, DIRECT_PARTS };

struct direct {
    const struct model *model;
    const struct mean_brdf *tables;
    int shadow_rays; /* a pixel: what solid angle a sample stands for */
    /* The cells where they are the same for all points: an environment and no other lamp. Else NULL. */
    struct environment_cell *sky;
    int sky_count;
};

/* What a group's shadow rays found: light that the parts of the BRDF were offered and what came through.
 * Zero-initialise. */
struct direct_share {
    rgb asked[DIRECT_PARTS], lit[DIRECT_PARTS];
};

/* Borrows model and tables. False: no memory. */
bool direct_prepare(const struct model *model, const struct mean_brdf *tables, int shadow_rays, struct direct *direct);
void direct_free(struct direct *direct);

/* Whether cells of lamps and gather rays resolve all lobes of a reflectance: none is narrower than that of about n =
 * 300. */
bool direct_resolves(const struct brdf *brdf);

/* Whether direct_light averages the lobes at this point over cells of the lamps: they are wide enough, and no lamp so
 * near that a cell of it is wider. If not, direct_sample and a ray by each lobe share the work by MIS. */
bool direct_averages(const struct direct *direct, const struct point *point);

/* One lamp sample (u: three numbers in [0, 1)) with its shadow ray, noted in `share`; averages: direct_averages at the
 * point. Returns the radiance by the parts
 * that direct_light doesn't average, lobes with the MIS weight against sampling each. */
rgb direct_sample(const struct direct *direct, const struct point *point, const float u[static 3], bool averages,
                  struct direct_share *share);

/* The light of a group at its mean point: all but what direct_sample returned. */
rgb direct_light(const struct direct *direct, const struct point *point, const struct direct_share *share);

#endif
