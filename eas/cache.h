/* SPDX-License-Identifier: Apache-2.0 */
/* Where records may be used: zones of influence in space, whatever the records hold.
 *
 * Grow it from one thread; any number may look up meanwhile nothing is inserted. Records are numbered in the order of
 * insertion, and a look-up lists them in an order that depends on that alone.
 */
#ifndef EAS_CACHE_H
#define EAS_CACHE_H

#include <stddef.h>
#include <stdint.h>

#include "eas/vec.h"

/* A record's place: position (m, world), unit normal, radius of its zone (m). */
struct zone {
    float3 p, n;
    float radius;
};

/* A record that a look-up found, and its weight: positive, falling to 0 at the zone's rim. Weights of one look-up sum
 * to 1. */
struct cache_match {
    uint32_t record;
    float weight;
};

enum { CACHE_MATCHES = 8 };

struct cache {
    struct zone *zones;
    uint32_t count, capacity;
    float stretch;                   /* look-ups reach this many radii: zones overlap */
    uint32_t *buckets, bucket_count; /* hash of (level, cell) to its first entry */
    struct cache_entry *entries;
    uint32_t entry_count, entry_capacity;
    /* The same, side by side for look-ups, from cache_reindex to the next insertion: those of bucket b begin at
     * starts[b] [bucket_count + 1]. NULL at other times. */
    struct cache_packed *packed;
    uint32_t *starts;
    uint64_t levels; /* bit set of the levels in use */
};

/* An empty cache whose look-ups stretch zones by `stretch` (>= 1). */
struct cache cache_empty(float stretch);
void cache_free(struct cache *cache);

/* Adds a record; its number is cache->count before the call. Neighbour clamping (Křivánek 2008): its radius and those
 * of the records in whose reach it lies, but on the other side of a wall, are reduced so that r_i <= r_j + |p_i - p_j|;
 * its own never below `least`.
 * False: no memory. */
bool cache_insert(struct cache *cache, struct zone zone, float least);

/* Indexes all records anew by their zones as they are, which clamping has made smaller since: look-ups get faster, and
 * their order depends on the zones alone, so that a cache made of stored zones gives the same bytes as the one that was
 * stored. False: no memory. */
bool cache_reindex(struct cache *cache);

/* The records usable at p with unit normal n, at most CACHE_MATCHES: those of largest weight. Tests, in the order of
 * cost: within `stretch` radii; within the plane of the record or nearly so; normals alike. Returns how many. */
int cache_find(const struct cache *cache, float3 p, float3 n, struct cache_match matches[static CACHE_MATCHES]);

/* Whether a record's own zone (not stretched) covers p: then no new one is needed. */
bool cache_covers(const struct cache *cache, float3 p, float3 n);

/* Bytes held. */
size_t cache_bytes(const struct cache *cache);

#endif
