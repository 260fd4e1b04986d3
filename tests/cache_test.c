/* SPDX-License-Identifier: Apache-2.0 */
/* Zones of influence: who is found where, against a list searched from end to end. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>

#include "eas/cache.h"
#include "render/rng.h"

static const float3 UP = {0, 0, 1};

/* A normal `degrees` off UP. */
static float3 tilted(float degrees) { return vec3(sinf(degrees * PI / 180), 0, cosf(degrees * PI / 180)); }

static void insert(struct cache *cache, float3 p, float3 n, float radius)
{
    assert_true(cache_insert(cache, (struct zone){p, n, radius}, .5f * radius));
}

static bool finds(const struct cache *cache, float3 p, float3 n)
{
    struct cache_match matches[CACHE_MATCHES];
    return cache_find(cache, p, n, matches) > 0;
}

/* Within a radius to be covered, within `stretch` radii to be found; a third of the radius off the plane; 25.8 degrees
 * between normals. */
static void tests_of_a_zone(void **state)
{
    (void)state;
    struct cache cache = cache_empty(1.5f);
    assert_false(cache_covers(&cache, UP, UP));
    assert_false(finds(&cache, UP, UP));
    insert(&cache, vec3(10, -5, 2), UP, .4f);
    for (int i = 0; i < 16; i++) {
        float3 d = {cosf((float)i), sinf((float)i), 0}, p = {10, -5, 2};
        assert_true(cache_covers(&cache, mad(p, d, .399f), UP));
        assert_false(cache_covers(&cache, mad(p, d, .401f), UP));
        assert_true(finds(&cache, mad(p, d, .599f), UP));
        assert_false(finds(&cache, mad(p, d, .601f), UP));
    }
    for (int side = -1; side <= 1; side += 2) {
        assert_true(cache_covers(&cache, vec3(10, -5, 2 + (float)side * .13f), UP));
        assert_false(cache_covers(&cache, vec3(10, -5, 2 + (float)side * .134f), UP));
        assert_true(cache_covers(&cache, vec3(10, -5, 2), tilted((float)side * 25)));
        assert_false(cache_covers(&cache, vec3(10, -5, 2), tilted((float)side * 26.5f)));
    }
    cache_free(&cache);
}

/* A record isn't used on the other side of a thin wall, nor on the wall at a right angle, nor on a step down. */
static void thin_wall(void **state)
{
    (void)state;
    struct cache cache = cache_empty(1.5f);
    insert(&cache, vec3(0, 0, 0), UP, 1);
    assert_true(finds(&cache, vec3(.2f, 0, 0), UP));
    assert_false(finds(&cache, vec3(.2f, 0, -.01f), vec3(0, 0, -1)));
    assert_false(finds(&cache, vec3(.2f, 0, .01f), vec3(1, 0, 0)));
    assert_false(finds(&cache, vec3(.2f, 0, -.4f), UP));
    cache_free(&cache);
}

/* Weights sum to 1 and fall with distance and with the angle between normals; one that leaves at its rim does so
 * smoothly. */
static void weights(void **state)
{
    (void)state;
    struct cache cache = cache_empty(1.5f);
    struct cache_match m[CACHE_MATCHES];
    insert(&cache, vec3(0, 0, 0), UP, 1);
    insert(&cache, vec3(1, 0, 0), UP, 1);
    insert(&cache, vec3(0, .1f, 0), tilted(15), 1);
    float before = 1;
    for (int i = 0; i < 150; i++) {
        float x = .01f * (float)i, sum = 0, first = 0;
        int count = cache_find(&cache, vec3(x, 0, 0), UP, m);
        for (int k = 0; k < count; k++) {
            assert_true(m[k].weight > 0);
            sum += m[k].weight;
            if (m[k].record == 0) first = m[k].weight;
        }
        assert_float_equal(sum, 1, 1e-5f);
        assert_true(first < before && before - first < (i ? .02f : 1));
        before = first;
    }
    assert_true(before < 1e-3f);
    /* At the middle the upright record outweighs its tilted neighbour at the same distance. */
    assert_int_equal(cache_find(&cache, vec3(0, .05f, 0), UP, m), 3);
    for (int k = 0; k < 3; k++)
        for (int l = 0; l < 3; l++)
            if (m[k].record == 0 && m[l].record == 2) assert_true(m[k].weight > 1.2f * m[l].weight);
    cache_free(&cache);
}

/* Clamping: a new record and those in whose reach it lies differ in radius by their distance at most; nobody grows; the
 * new one keeps `least`. */
static void clamping(void **state)
{
    (void)state;
    struct cache cache = cache_empty(1.5f);
    struct rng rng = rng_seed(1, 2, 3);
    float before[400];
    int pairs = 0;
    for (int i = 0; i < 400; i++) {
        float3 p = {4 * rng_float(&rng), 4 * rng_float(&rng), 0};
        float radius = .05f + sqr(rng_float(&rng));
        for (int k = 0; k < i; k++) before[k] = cache.zones[k].radius;
        assert_true(cache_insert(&cache, (struct zone){p, UP, radius}, .05f));
        float mine = cache.zones[i].radius;
        assert_true(mine <= radius && mine >= .05f);
        for (int k = 0; k < i; k++) {
            float d = length(sub(p, cache.zones[k].p)), other = cache.zones[k].radius;
            assert_true(other <= before[k]);
            if (d >= 1.5f * before[k]) continue;
            assert_true(mine <= maxf(before[k] + d, .05f) + 1e-6f && other <= mine + d + 1e-6f);
            pairs += mine < radius || other < before[k];
        }
    }
    assert_true(pairs > 100);
    cache_free(&cache);
}

/* The rules of cache.h, written once more. */
static float weight(const struct zone *zone, float3 p, float3 n, float stretch)
{
    float3 d = sub(p, zone->p);
    float cosine = dot(n, zone->n), reach = stretch * zone->radius;
    if (length(d) >= reach || fabsf(dot(d, zone->n)) > .33f * zone->radius || cosine < .9f) return 0;
    return sqr(1 - length(d) / reach) * (cosine - .9f) / .1f;
}

static float3 somewhere(struct rng *rng) /* on the six walls of a room, on which zones crowd in a corner */
{
    float3 p = {4 * sqr(rng_float(rng)) - 2, 4 * sqr(rng_float(rng)) - 2, 4 * sqr(rng_float(rng)) - 2};
    switch (rng_uint(rng) % 6) {
    case 0: p.x = -2; break;
    case 1: p.x = 2; break;
    case 2: p.y = -2; break;
    case 3: p.y = 2; break;
    case 4: p.z = -2; break;
    default: p.z = 2;
    }
    return p;
}

static float3 inward(float3 p, struct rng *rng)
{
    float3 n = {fabsf(p.x) == 2 ? -p.x : 0, fabsf(p.y) == 2 ? -p.y : 0, fabsf(p.z) == 2 ? -p.z : 0};
    float3 bump = {rng_float(rng) - .5f, rng_float(rng) - .5f, rng_float(rng) - .5f};
    return normalize(mad(normalize(n), bump, .3f));
}

static void fill(struct cache *cache, int count, uint64_t seed, float3 shift)
{
    struct rng rng = rng_seed(seed, 0, 0);
    for (int i = 0; i < count; i++) {
        float3 p = somewhere(&rng), n = inward(p, &rng);
        insert(cache, add(p, shift), n, expf(-6 * rng_float(&rng))); /* radii of all sizes: many levels */
    }
}

/* Look-ups bring the records of the largest weight, and no others. */
static void agrees_with_brute_force(const struct cache *cache, uint64_t seed)
{
    float *all = malloc(cache->count * sizeof *all);
    assert_non_null(all);
    struct rng rng = rng_seed(seed, 0, 0);
    int full = 0, partly = 0;
    for (int i = 0; i < 2000; i++) {
        float3 p = somewhere(&rng), n = inward(p, &rng);
        struct cache_match m[CACHE_MATCHES];
        bool covered = false;
        int found = cache_find(cache, p, n, m), usable = 0;
        float sum = 0, least = INFINITY;
        for (uint32_t k = 0; k < cache->count; k++) {
            all[k] = weight(&cache->zones[k], p, n, 1.5f);
            usable += all[k] > 1e-6f;
            covered |= weight(&cache->zones[k], p, n, 1) > 1e-6f;
        }
        for (int k = 0; k < found; k++) {
            sum += all[m[k].record];
            least = minf(least, all[m[k].record]);
        }
        int better = 0;
        for (uint32_t k = 0; k < cache->count; k++) better += all[k] > 1e-6f && all[k] >= least;
        assert_true(better <= found); /* nothing that was left out weighs more */
        assert_true(found >= (usable < CACHE_MATCHES ? usable : CACHE_MATCHES));
        for (int k = 0; k < found; k++) assert_float_equal(m[k].weight, all[m[k].record] / sum, 1e-4f);
        if (covered) assert_true(cache_covers(cache, p, n));
        full += found == CACHE_MATCHES;
        partly += found > 0 && found < CACHE_MATCHES;
    }
    assert_in_range(full, 100, 1900);
    assert_in_range(partly, 100, 1900);
    free(all);
}

/* Thousands of records: while they come, once they are indexed anew, and when more come after that. */
static void against_brute_force(void **state)
{
    (void)state;
    struct cache cache = cache_empty(1.5f);
    fill(&cache, 4000, 5, vec3(0, 0, 0));
    agrees_with_brute_force(&cache, 6);
    assert_true(cache_reindex(&cache));
    agrees_with_brute_force(&cache, 7);
    fill(&cache, 1000, 8, vec3(0, 0, 0));
    agrees_with_brute_force(&cache, 9);
    assert_true(cache_reindex(&cache));
    agrees_with_brute_force(&cache, 10);
    cache_free(&cache);
}

/* Records elsewhere don't matter: the same look-ups whether they came before, after or never; numbers are shifted. */
static void unrelated_records(void **state)
{
    (void)state;
    enum { COUNT = 500 };
    struct cache alone = cache_empty(1.5f), before = cache_empty(1.5f), after = cache_empty(1.5f);
    fill(&alone, COUNT, 9, vec3(0, 0, 0));
    fill(&before, COUNT, 10, vec3(50, 0, 0));
    fill(&before, COUNT, 9, vec3(0, 0, 0));
    fill(&after, COUNT, 9, vec3(0, 0, 0));
    fill(&after, COUNT, 10, vec3(50, 0, 0));
    struct rng rng = rng_seed(11, 0, 0);
    for (int i = 0; i < 500; i++) {
        float3 p = somewhere(&rng), n = inward(p, &rng);
        struct cache_match a[CACHE_MATCHES], b[CACHE_MATCHES], c[CACHE_MATCHES];
        int count = cache_find(&alone, p, n, a);
        assert_int_equal(cache_find(&before, p, n, b), count);
        assert_int_equal(cache_find(&after, p, n, c), count);
        for (int k = 0; k < count; k++) {
            assert_true(b[k].record == a[k].record + COUNT && b[k].weight == a[k].weight);
            assert_true(c[k].record == a[k].record && c[k].weight == a[k].weight);
        }
    }
    cache_free(&alone);
    cache_free(&before);
    cache_free(&after);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tests_of_a_zone), cmocka_unit_test(thin_wall),           cmocka_unit_test(weights),
        cmocka_unit_test(clamping),        cmocka_unit_test(against_brute_force), cmocka_unit_test(unrelated_records)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
