/* SPDX-License-Identifier: Apache-2.0 */
/* Fills the radiance cache for a picture (paper, Algorithm 1): records where camera rays find none.
 *
 * Departures: rounds over the pixels from coarse to fine in a fixed order, those of one round gathered in parallel and
 * inserted in order, so that the bytes don't depend on threads; gather rays end at the diffuse cache; lamps are left
 * out of the records (render.c adds them at the pixel); a zone is a share of the distance to the nearest surface, not
 * of the mean one.
 */
#ifndef RENDER_FILL_H
#define RENDER_FILL_H

#include "eas/hsh.h"
#include "eas/irradiance.h"
#include "eas/select.h"
#include "render/diffuse_cache.h"

/* Incident light at zones.zones[i]: irradiance and, in a glossy cache, eas[first_eas .. + eas_count) or
 * HSH at hsh[first_hsh]. */
struct record {
    struct irradiance irradiance;
    uint32_t first_eas, eas_count;
    uint32_t first_hsh;
    int hsh_order;
};

struct record_cache {
    struct cache zones;
    struct record *records;
    uint32_t record_capacity;
    struct eas *eas;
    uint32_t eas_count, eas_capacity;
    float *hsh;
    uint32_t hsh_count, hsh_capacity;
};

/* The caches of a picture. Glossy surfaces use `glossy` where the method keeps EAS, else everything uses `diffuse`. */
struct fill {
    enum fill_kind { FILL_DIFFUSE, FILL_EAS, FILL_HSH } kind; /* what glossy records hold */
    struct diffuse_cache bounced;
    struct record_cache diffuse, glossy;
    struct mean_brdf *tables;
    struct hsh *hsh; /* FILL_HSH; else NULL */
};

/* Deterministic for any number of threads. False and a sentence where memory runs out; nothing to free then. */
bool fill_build(const struct model *model, enum fill_kind kind, uint64_t seed, struct progress *progress,
                struct fill *fill, char error[static SCENE_ERROR]);
void fill_free(struct fill *fill);

/* Bytes of all caches. */
size_t fill_bytes(const struct fill *fill);

/* Mean bytes of a glossy record: place, irradiance and its EAS or HSH, without the index. 0: there is none. */
double fill_bytes_per_record(const struct fill *fill);

#endif
