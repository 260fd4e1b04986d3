/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/cache.h"

#include <stdlib.h>
#include <string.h>

/* Normals may differ by 26 degrees; the offset from the record's plane may be a third of the radius. */
#define NORMAL_COSINE .9f
#define PLANE_OFFSET .33f
/* Neighbour clamping ends where normals differ by more than 120 degrees. */
#define OPPOSITE_COSINE (-.5f)

enum { LEVEL_BIAS = 32 };
#define NO_ENTRY UINT32_MAX

/* One record in one cell; entries of a bucket are chained, the newest first. */
struct cache_entry {
    uint64_t key;
    uint32_t record, next;
};

/* With all that a look-up reads: chains of entries, and zones apart from them, cost a miss of the processor's caches
 * each. */
struct cache_packed {
    uint64_t key;
    struct zone zone;
    uint32_t record;
};

struct cache cache_empty(float stretch) { return (struct cache){.stretch = stretch}; }

static void unpack(struct cache *cache)
{
    free(cache->packed);
    free(cache->starts);
    cache->packed = NULL;
    cache->starts = NULL;
}

void cache_free(struct cache *cache)
{
    unpack(cache);
    free(cache->zones);
    free(cache->buckets);
    free(cache->entries);
    *cache = (struct cache){.stretch = cache->stretch};
}

size_t cache_bytes(const struct cache *cache)
{
    return cache->capacity * sizeof *cache->zones + cache->bucket_count * sizeof *cache->buckets +
           cache->entry_capacity * sizeof *cache->entries +
           (cache->packed ? cache->entry_count * sizeof *cache->packed +
                                ((size_t)cache->bucket_count + 1) * sizeof *cache->starts
                          : 0);
}

/* Level l has cells of 2^l m; a zone lies in the level whose cells are once to twice as wide as it reaches. */
static int level_of(float reach)
{
    int level;
    frexpf(reach, &level);
    return level < -LEVEL_BIAS ? -LEVEL_BIAS : level > LEVEL_BIAS - 1 ? LEVEL_BIAS - 1 : level;
}

static uint64_t cell_key(int level, int x, int y, int z)
{
    return (uint64_t)(uint32_t)(level + LEVEL_BIAS) << 57 ^ ((uint64_t)(uint32_t)x & 0x7ffff) << 38 ^
           ((uint64_t)(uint32_t)y & 0x7ffff) << 19 ^ ((uint64_t)(uint32_t)z & 0x7ffff);
}

static uint32_t bucket_of(const struct cache *cache, uint64_t key)
{
    key = (key ^ (key >> 31)) * 0x9e3779b97f4a7c15u;
    return (uint32_t)(key >> 32) & (cache->bucket_count - 1);
}

/* ldexpf(1, exponent), which is a call. */
static inline float power_of_two(int exponent)
{
    uint32_t bits = (uint32_t)(exponent + 127) << 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

static inline void cell_of(float3 p, int level, int cell[3])
{
    float s = power_of_two(-level);
    cell[0] = (int)floorf(p.x * s);
    cell[1] = (int)floorf(p.y * s);
    cell[2] = (int)floorf(p.z * s);
}

static bool grow(void *array, uint32_t *capacity, uint32_t count, size_t bytes)
{
    if (count < *capacity) return true;
    uint32_t larger = count < 512 ? 1024 : 2 * count;
    void *grown = realloc(*(void **)array, larger * bytes);
    if (!grown) return false;
    *(void **)array = grown;
    *capacity = larger;
    return true;
}

static bool rehash(struct cache *cache)
{
    if (4 * cache->entry_count < cache->bucket_count) return true;
    uint32_t count = cache->bucket_count ? cache->bucket_count * 4 : 4096;
    uint32_t *buckets = malloc(count * sizeof *buckets);
    if (!buckets) return false;
    free(cache->buckets);
    cache->buckets = buckets;
    cache->bucket_count = count;
    memset(buckets, 0xff, count * sizeof *buckets);
    for (uint32_t i = 0; i < cache->entry_count; i++) {
        uint32_t bucket = bucket_of(cache, cache->entries[i].key);
        cache->entries[i].next = buckets[bucket];
        buckets[bucket] = i;
    }
    return true;
}

/* Whether a zone can be used somewhere in a cell: the cell's ball meets the ball of the zone's reach and its plane. */
static bool meets_cell(struct zone zone, float reach, float width, int x, int y, int z)
{
    float3 middle = scale(vec3((float)x + .5f, (float)y + .5f, (float)z + .5f), width), d = sub(middle, zone.p);
    float ball = .8661f * width;
    return dot(d, d) < sqr(reach + ball) && fabsf(dot(d, zone.n)) < PLANE_OFFSET * zone.radius + ball;
}

static bool index_record(struct cache *cache, uint32_t record, struct zone zone)
{
    float reach = zone.radius * cache->stretch;
    int level = level_of(reach), low[3], high[3];
    cell_of(sub(zone.p, vec3(reach, reach, reach)), level, low);
    cell_of(add(zone.p, vec3(reach, reach, reach)), level, high);
    cache->levels |= 1ull << (level + LEVEL_BIAS);
    for (int x = low[0]; x <= high[0]; x++)
        for (int y = low[1]; y <= high[1]; y++)
            for (int z = low[2]; z <= high[2]; z++) {
                if (!meets_cell(zone, reach, power_of_two(level), x, y, z)) continue;
                if (!rehash(cache) ||
                    !grow(&cache->entries, &cache->entry_capacity, cache->entry_count, sizeof *cache->entries))
                    return false;
                uint64_t key = cell_key(level, x, y, z);
                uint32_t bucket = bucket_of(cache, key);
                cache->entries[cache->entry_count] = (struct cache_entry){key, record, cache->buckets[bucket]};
                cache->buckets[bucket] = cache->entry_count++;
            }
    return true;
}

/* Walks over the records whose cells hold a point: one bucket for each level in use, chained or packed. */
struct probe {
    uint64_t levels, key;
    uint32_t entry, end; /* the next one; where the packed ones end */
};

static struct probe probe_begin(const struct cache *cache)
{
    return (struct probe){cache->levels, 0, cache->packed ? 0 : NO_ENTRY, 0};
}

/* The next record's zone, or NULL. */
static inline const struct zone *probe_next(const struct cache *cache, float3 p, struct probe *probe, uint32_t *record)
{
    for (;;) {
        while (cache->packed && probe->entry < probe->end) {
            const struct cache_packed *entry = &cache->packed[probe->entry++];
            *record = entry->record;
            if (entry->key == probe->key) return &entry->zone;
        }
        while (!cache->packed && probe->entry != NO_ENTRY) {
            const struct cache_entry *entry = &cache->entries[probe->entry];
            probe->entry = entry->next;
            *record = entry->record;
            if (entry->key == probe->key) return &cache->zones[entry->record];
        }
        if (!probe->levels) return NULL;
        int level = __builtin_ctzll(probe->levels) - LEVEL_BIAS, cell[3];
        probe->levels &= probe->levels - 1;
        cell_of(p, level, cell);
        probe->key = cell_key(level, cell[0], cell[1], cell[2]);
        uint32_t bucket = bucket_of(cache, probe->key);
        probe->entry = cache->packed ? cache->starts[bucket] : cache->buckets[bucket];
        probe->end = cache->packed ? cache->starts[bucket + 1] : 0;
    }
}

/* Bucket by bucket in the order of the chains. False: no memory. */
static bool pack(struct cache *cache)
{
    uint32_t count = 0;
    if (!cache->entry_count) return true;
    cache->packed = malloc(cache->entry_count * sizeof *cache->packed);
    cache->starts = malloc(((size_t)cache->bucket_count + 1) * sizeof *cache->starts);
    if (!cache->packed || !cache->starts) {
        unpack(cache);
        return false;
    }
    for (uint32_t bucket = 0; bucket < cache->bucket_count; bucket++) {
        cache->starts[bucket] = count;
        for (uint32_t i = cache->buckets[bucket]; i != NO_ENTRY; i = cache->entries[i].next) {
            uint32_t record = cache->entries[i].record;
            cache->packed[count++] = (struct cache_packed){cache->entries[i].key, cache->zones[record], record};
        }
    }
    cache->starts[cache->bucket_count] = count;
    return true;
}

/* 0 where the record isn't usable at (p, n) within `stretch` radii; else its weight. */
static float weight_of(const struct zone *zone, float3 p, float3 n, float stretch)
{
    float3 d = sub(p, zone->p);
    float reach = zone->radius * stretch, d2 = dot(d, d);
    if (d2 >= reach * reach) return 0;
    if (fabsf(dot(d, zone->n)) > PLANE_OFFSET * zone->radius) return 0;
    float cosine = dot(n, zone->n);
    if (cosine < NORMAL_COSINE) return 0;
    float near = 1 - sqrtf(d2) / reach, alike = (cosine - NORMAL_COSINE) / (1 - NORMAL_COSINE);
    return near * near * alike + 1e-12f;
}

/* Whether two zones may bear on each other: not on the two sides of a wall. */
static bool are_neighbours(const struct zone *a, const struct zone *b) { return dot(a->n, b->n) > OPPOSITE_COSINE; }

bool cache_insert(struct cache *cache, struct zone zone, float least)
{
    uint32_t other, record = cache->count;
    unpack(cache);
    if (!grow(&cache->zones, &cache->capacity, cache->count, sizeof *cache->zones)) return false;
    for (struct probe probe = probe_begin(cache); probe_next(cache, zone.p, &probe, &other);) {
        if (!are_neighbours(&zone, &cache->zones[other])) continue;
        float distance = length(sub(cache->zones[other].p, zone.p));
        zone.radius = maxf(minf(zone.radius, cache->zones[other].radius + distance), least);
    }
    for (struct probe probe = probe_begin(cache); probe_next(cache, zone.p, &probe, &other);) {
        if (!are_neighbours(&zone, &cache->zones[other])) continue;
        float distance = length(sub(cache->zones[other].p, zone.p));
        /* Its place in the index stays: the index may only be too wide. */
        cache->zones[other].radius = minf(cache->zones[other].radius, zone.radius + distance);
    }
    cache->zones[record] = zone;
    cache->count++;
    return index_record(cache, record, zone);
}

bool cache_reindex(struct cache *cache)
{
    unpack(cache);
    free(cache->buckets);
    cache->buckets = NULL;
    cache->bucket_count = cache->entry_count = 0;
    cache->levels = 0;
    for (uint32_t i = 0; i < cache->count; i++)
        if (!index_record(cache, i, cache->zones[i])) return false;
    return pack(cache);
}

int cache_find(const struct cache *cache, float3 p, float3 n, struct cache_match matches[static CACHE_MATCHES])
{
    int count = 0;
    uint32_t record;
    struct probe probe = probe_begin(cache);
    for (const struct zone *zone; (zone = probe_next(cache, p, &probe, &record));) {
        float weight = weight_of(zone, p, n, cache->stretch);
        if (weight <= 0) continue;
        int at = count;
        if (count < CACHE_MATCHES) count++;
        else { /* the least of those held makes room; a tie keeps the older */ at = 0;
            for (int i = 1; i < CACHE_MATCHES; i++)
                if (matches[i].weight < matches[at].weight) at = i;
            if (matches[at].weight >= weight) continue;
        }
        matches[at] = (struct cache_match){record, weight};
    }
    float sum = 0;
    for (int i = 0; i < count; i++) sum += matches[i].weight;
    for (int i = 0; i < count; i++) matches[i].weight /= sum;
    return count;
}

bool cache_covers(const struct cache *cache, float3 p, float3 n)
{
    uint32_t record;
    struct probe probe = probe_begin(cache);
    for (const struct zone *zone; (zone = probe_next(cache, p, &probe, &record));)
        if (weight_of(zone, p, n, 1) > 0) return true;
    return false;
}
