/* SPDX-License-Identifier: Apache-2.0 */
/* Fills the radiance cache for a picture (paper, Algorithm 1): records where camera rays find none.
 *
 * Departures: rounds over the pixels from coarse to fine in a fixed order, those of one round gathered in parallel and
 * inserted in order, so that the bytes don't depend on threads; gather rays end at the diffuse cache; lamps are left
 * out of the records unless asked for (cached.c adds them at the pixel); a zone is a share of the distance to the
 * nearest surface, not of the mean one.
 */
#ifndef RENDER_FILL_H
#define RENDER_FILL_H

#include <assert.h>

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
static_assert(sizeof(struct record) == 100, "written to files as it stands");

struct record_cache {
    struct cache zones;
    struct record *records;
    uint32_t record_capacity;
    struct eas *eas;
    uint32_t eas_count, eas_capacity;
    float *hsh;
    uint32_t hsh_count, hsh_capacity;
};

/* What the caches depend on besides the scene. */
struct fill_options {
    /* What glossy records hold besides irradiance: nothing; EAS; HSH. FILL_NONE: the diffuse cache is all there is. */
    enum fill_kind { FILL_DIFFUSE, FILL_EAS, FILL_HSH, FILL_NONE } kind;
    bool lamps;    /* records hold direct light, too (the paper's mode) */
    bool surfaces; /* records all over the scene, for any camera; if not, where the camera sees */
    uint64_t seed;
    int coarseness; /* 0: the finest; each step up to FILL_COARSEST has about a fourth of the rays */
};
enum { FILL_COARSEST = 2 };

/* The caches of a picture. Glossy surfaces use `glossy` where the method keeps EAS, else everything uses `diffuse`. */
struct fill {
    struct fill_options options; /* they were made under */
    struct diffuse_cache bounced;
    struct record_cache diffuse, glossy;
    struct mean_brdf *tables;
    struct hsh *hsh; /* FILL_HSH; else NULL */
};

/* Whether glossy surfaces have records of their own. */
static inline bool fill_has_glossy(const struct fill *fill)
{
    return fill->options.kind == FILL_EAS || fill->options.kind == FILL_HSH;
}

/* Makes the caches; those of FILL_NONE may be filled by fill_extend once their options say how. Deterministic for any
 * number of threads. False and a sentence where memory runs out; nothing to free then. */
bool fill_build(const struct model *model, const struct fill_options *options, struct progress *progress,
                struct fill *fill, char error[static SCENE_ERROR]);

/* Goes on where the model's camera sees what no record covers: the caches were made for another camera or other
 * materials, and not over all surfaces. The same promises; where memory runs out, the caller frees. */
bool fill_extend(const struct model *model, struct progress *progress, struct fill *fill,
                 char error[static SCENE_ERROR]);
void fill_free(struct fill *fill);

/* Fills in the tables that look-ups need, for caches that were read. False: no memory. */
bool fill_tables(const struct scene *scene, struct fill *fill);

/* Records of both kinds. */
uint64_t fill_records(const struct fill *fill);

/* Bytes of all caches. */
size_t fill_bytes(const struct fill *fill);

/* Mean bytes of a glossy record: place, irradiance and its EAS or HSH, without the index. 0: there is none. */
double fill_bytes_per_record(const struct fill *fill);

#endif
