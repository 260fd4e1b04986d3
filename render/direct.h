/* SPDX-License-Identifier: Apache-2.0 */
/* Lamps at the points that a pixel sees, with as little noise as the shadows allow.
 *
 * The points of a pixel that are alike share one unshadowed integral of their lobes over fixed cells of the lamps, a
 * lobe averaged over each cell's solid angle (the mean BRDF, eas/mean_brdf.h), so that highlights in plain light have
 * no noise. Shadow rays then go to cells chosen by what they bring to the integral; the share that comes through scales
 * it, channel by channel. The diffuse part is treated so under an environment alone, whose cells are exact, by the
 * shadow rays of lamp samples; under other lamps it is sampled. Lobes too narrow for the cells are sampled with MIS.
 */
#ifndef RENDER_DIRECT_H
#define RENDER_DIRECT_H

#include "eas/mean_brdf.h"
#include "render/rng.h"
#include "render/shade.h"

struct direct {
    const struct model *model;
    const struct mean_brdf *tables;
    /* The cells where they are the same for all points: an environment and no other lamp. Else NULL. */
    struct environment_cell *sky;
    int sky_count;
    bool points_only, idle; /* lamps that rays can hit are in the records; idle: there are no others */
};

/* What the shadow rays of a group's lamp samples found: diffuse light that was offered and what came through.
 * Zero-initialise. */
struct direct_share {
    rgb asked, lit;
};

/* Borrows model and tables. points_only: leaves out all that a ray can hit. False: no memory. */
bool direct_prepare(const struct model *model, const struct mean_brdf *tables, bool points_only, struct direct *direct);
void direct_free(struct direct *direct);

/* Whether cells of lamps and gather rays resolve all lobes of a reflectance: none is narrower than that of about n =
 * 300. */
bool direct_resolves(const struct brdf *brdf);

/* Whether direct_light averages the lobes at this point over cells of the lamps: they are wide enough, and no lamp so
 * near that a cell of it is wider. If not, direct_sample and a ray by each lobe share the work by MIS. */
bool direct_averages(const struct direct *direct, const struct point *point);

/* One lamp sample (u: three numbers in [0, 1)) with its shadow ray, noted in `share`; averages: direct_averages at the
 * point. Returns the radiance by the parts that direct_light doesn't average, lobes with the MIS weight against
 * sampling each. */
rgb direct_sample(const struct direct *direct, const struct point *point, const float u[static 3], bool averages,
                  struct direct_share *share);

/* The light of a group at its mean point: all but what direct_sample returned. `origins`: where its points' rays start,
 * `count` of them; `rays` shadow rays leave them in turn. */
rgb direct_light(const struct direct *direct, const struct point *point, const struct direct_share *share,
                 const float3 *origins, int count, int rays, struct rng *rng);

#endif
