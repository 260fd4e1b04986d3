/* SPDX-License-Identifier: Apache-2.0 */
/* Lamps at the points that a pixel sees, with as little noise as the shadows allow.
 *
 * The points of a pixel that are alike share one unshadowed integral over fixed cells of the lamps, a lobe averaged
 * over each cell's solid angle (the mean BRDF, eas/mean_brdf.h), so that plain light has no noise. Shadow rays then go
 * to cells by what they bring to the integral, fewer to those that the pixel's neighbours have found all lit or all
 * dark; the share that comes through scales it, channel by channel. Under an environment alone, whose cells are exact,
 * the diffuse part is treated so, too; under other lamps it is sampled. Lobes too narrow for the cells are sampled with
 * MIS.
 */
#ifndef RENDER_DIRECT_H
#define RENDER_DIRECT_H

#include "eas/mean_brdf.h"
#include "render/rng.h"
#include "render/shade.h"

/* Cells that the integral is made of, at most; those about each that share its doubts. */
enum { DIRECT_CELLS = 512, DIRECT_NEIGHBOURS = 6 };

struct direct {
    const struct model *model;
    const struct mean_brdf *tables;
    /* Where an environment is the only lamp, its cells, the same for all points, and ENVIRONMENT_PLACES directions in
     * each. Else NULL. */
    struct cells *sky;
    float3 *places;
    float sky_flux;                            /* luminance, W/m2 on a surface that faces all of it */
    uint16_t (*neighbours)[DIRECT_NEIGHBOURS]; /* of each cell */
    bool points_only, idle;                    /* lamps that rays can hit are in the records; there are no others */
};

/* What shadow rays to each cell have found from points near by: they go where that is in doubt. It changes the noise of
 * the light, never its mean. */
struct shadow_memory {
    uint8_t doubt[DIRECT_CELLS]; /* how many more have to find the same */
    bool lit[DIRECT_CELLS];      /* what the last one found */
};

void direct_forget(struct shadow_memory *memory);

/* Borrows model and tables. points_only: leaves out all that a ray can hit. False: no memory. */
bool direct_prepare(const struct model *model, const struct mean_brdf *tables, bool points_only, struct direct *direct);
void direct_free(struct direct *direct);

/* Whether cells of lamps and gather rays resolve a lobe: it reflects by Phong's or GGX's distribution, whose means over
 * cones are known, and isn't narrower than about n = 300. */
bool direct_resolves(const struct lobe *lobe);

/* Moves the lobes that are resolved to the front. Returns how many they are. */
int direct_sort(struct brdf *brdf);

/* Whether a lamp is so near that samples of it by area leave the diffuse part noisy and its rare large ones decide: it
 * fills 1 sr or more. Then direct_met shares the work by MIS. */
bool direct_near(const struct model *model, const struct point *point);

/* The diffuse part's weight of a lamp sample, against direct_met where the lamp is near: 1 elsewhere. */
static inline float direct_weight(bool near, const struct light_sample *light, float cosine)
{
    return near && light->pdf > 0 ? mis_weight(light->pdf, cosine / PI) : 1;
}

/* What the diffuse part reflects of lamps that a ray by the cosine meets (u: two numbers in [0, 1)), with its MIS
 * weight against lights_sample. */
rgb direct_met(const struct model *model, const struct point *point, const float u[static 2]);

/* Whether direct_light averages the resolved lobes at this point over cells of the lamps: no lamp is so near that its
 * cells are too wide for them. If not, direct_sample and a ray by each lobe share the work by MIS, as for all other
 * lobes. */
bool direct_averages(const struct direct *direct, const struct point *point);

/* The light of one lamp sample with its shadow ray, and of one beyond the surface where it transmits, by the parts that
 * direct_light leaves out: `averaged` of the point's lobes, sorted, are its. Lobes have the MIS weight against sampling
 * each. weights: the lights', at the point; u: three numbers in [0, 1); near: direct_near. */
rgb direct_sample(const struct direct *direct, const struct point *point, const struct light_weights *weights,
                  const float u[static 3], int averaged, bool near);

/* The light of alike points at their mean, whose lobes are all resolved: under an environment alone the diffuse part,
 * and the lobes where `averages`. `origins`: where the points' rays start, `count` of them; shadow rays leave them in
 * turn, about `rays` where nothing is remembered, more where a sky's light is bright. */
rgb direct_light(const struct direct *direct, const struct point *point, bool averages, const float3 *origins,
                 int count, int rays, struct shadow_memory *memory, struct rng *rng);

#endif
