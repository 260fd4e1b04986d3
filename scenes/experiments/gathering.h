/* SPDX-License-Identifier: Apache-2.0 */
/* The indirect light at a point, by one ray a stratum of the hemisphere: what the experiments with one record start
 * from. */
#ifndef SCENES_EXPERIMENTS_GATHERING_H
#define SCENES_EXPERIMENTS_GATHERING_H

#include "eas/irradiance.h"
#include "render/gather.h"

/* One sample a ray of each kind: light of the surface that was hit (or of the environment), and light that this surface
 * mirrors, often black. */
struct gathering {
    float3 p;
    struct frame frame; /* about the normal */
    struct gather_grid grid;
    uint32_t count;
    struct gather_sample *surface, *mirrored;
};

/* `rays` at least, uniform in solid angle; `seed` chooses the random numbers. The caller frees. False: no memory. */
bool gathering_make(const struct model *model, const struct diffuse_cache *bounced, float3 p, float3 n, int rays,
                    uint64_t seed, struct gathering *gathering);
void gathering_free(struct gathering *gathering);

/* Radiance that a lobe reflects of all samples (paper, eq. 17). */
rgb gathering_reflect(const struct gathering *gathering, const struct lobe *lobe, float3 wo);

#endif
