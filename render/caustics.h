/* SPDX-License-Identifier: Apache-2.0 */
/* Light of lamps that a glossy surface sends straight on to a diffuse one (Heckbert's L S D), as photons.
 *
 * A gather ray rarely meets the mirror image of a lamp, which is much brighter than all else: this light is most of the
 * noise of a record's irradiance where lamps are small (Cornell box: nine tenths of the variance for a quarter of the
 * bounced light). Photons find it from the other side: points on glossy surfaces, chosen by the light that a lamp
 * sample brings them, send it on along a direction drawn by their lobes (Jensen, "Global Illumination using Photon
 * Maps", 1996). Irradiance is a density estimate, which blurs by some pixels. Light that a surface refracts is left to
 * rays. Photons on both sides of a thin wall aren't told apart within the reach of the estimate.
 */
#ifndef RENDER_CAUSTICS_H
#define RENDER_CAUSTICS_H

#include <assert.h>

#include "render/rng.h"
#include "render/shade.h"

struct photon {
    float3 p, n; /* where it came down: m, world; the shading normal on its side */
    rgb flux;    /* W */
};
static_assert(sizeof(struct photon) == 36, "written to files as it stands");

struct caustics {
    struct photon *photons; /* sorted by bucket */
    uint32_t *buckets;      /* hash of cell to its first photon, [bucket_count + 1] */
    uint32_t count;         /* 0: gather rays hold this light */
    uint32_t bucket_count;
    float reach; /* radius of the density estimate, m: it shrinks where photons are many */
};

/* Deterministic for any number of threads. False: no memory; nothing to free then. */
bool caustics_build(const struct model *model, uint64_t seed, struct caustics *caustics);

/* Sorts photons for a reach, both given: those of caustics_build are as they were. False: no memory; the caller frees
 * in any case. */
bool caustics_index(struct caustics *caustics);
void caustics_free(struct caustics *caustics);

/* How much surface was found about some places, for others close to them. */
enum { CAUSTICS_PLACES = 8 };
struct caustics_memory {
    int count;
    struct {
        float3 p, ng;
        float radius, coverage;
    } places[CAUSTICS_PLACES];
};

/* Irradiance at p, on a side of its surface, by this light, W/m2; a few rays find how much surface there is about it,
 * so that edges aren't darker. memory: at first {0}; NULL: none. Any thread may call, with its own. */
rgb caustics_irradiance(const struct model *model, const struct caustics *caustics, float3 p, struct side side,
                        struct caustics_memory *memory, struct rng *rng);

size_t caustics_bytes(const struct caustics *caustics);

#endif
