/* SPDX-License-Identifier: Apache-2.0 */
/* Irradiance at records all over the scene, in world space and by normal, on any mesh: where gather rays end.
 *
 * It holds the light of everything but lamps directly. Records are placed where paths from the camera go, sized by the
 * nearest surface; each then gathers once, noting how much it takes of which other record; the linear system is solved
 * by iteration, so that every bounce is in it without another ray (the radiosity equation on scattered records).
 */
#ifndef RENDER_DIFFUSE_CACHE_H
#define RENDER_DIFFUSE_CACHE_H

#include "eas/cache.h"
#include "render/caustics.h"
#include "render/progress.h"

struct diffuse_cache {
    struct cache zones;
    rgb *e; /* W/m2, one a record; NULL while the cache is being made */
    struct caustics caustics; /* is in e, too */
};

/* While the cache is made its values are unknown: light that comes from a record is noted as a term of a linear system,
 * coefficient x e[record]. */
struct gather_term {
    uint32_t record;
    rgb coefficient;
};
struct gather_terms {
    struct gather_term *terms;
    uint32_t count, capacity;
    bool failed;
};

/* coarseness: 0, or for a fourth of the records and rays more. Deterministic for any number of threads. False and a
 * sentence where memory runs out; *cache is then empty. */
bool diffuse_cache_build(const struct model *model, int coarseness, uint64_t seed, struct progress *progress,
                         struct diffuse_cache *cache, char error[static SCENE_ERROR]);
void diffuse_cache_free(struct diffuse_cache *cache);

/* The mean of the matched records' irradiance. */
rgb diffuse_cache_mean(const struct diffuse_cache *cache, const struct cache_match *matches, int count);

/* CV(RMSE) of the cache against path tracing at 512 points where it is used, the path tracer's noise taken out by two
 * halves. */
double diffuse_cache_error(const struct model *model, const struct diffuse_cache *cache, uint64_t seed);

size_t diffuse_cache_bytes(const struct diffuse_cache *cache);

#endif
