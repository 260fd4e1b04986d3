/* SPDX-License-Identifier: Apache-2.0 */
/* Random numbers: a PCG32 stream seeded by what is computed (pixel, sample, record …), never by thread or time, so that
 * the same input gives the same bytes. O'Neill, "PCG", 2014; the seeds are mixed with splitmix64. */
#ifndef RENDER_RNG_H
#define RENDER_RNG_H

#include <stdint.h>

struct rng {
    uint64_t state, increment;
};

static inline uint64_t rng_mix(uint64_t x)
{
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static inline uint32_t rng_uint(struct rng *rng)
{
    uint64_t old = rng->state;
    rng->state = old * 6364136223846793005u + rng->increment;
    uint32_t xorshifted = (uint32_t)(((old >> 18) ^ old) >> 27), rot = (uint32_t)(old >> 59);
    return (xorshifted >> rot) | (xorshifted << ((-rot) & 31));
}

/* A stream of its own for each (seed, a, b): for instance (user's seed, pixel, sample). */
static inline struct rng rng_seed(uint64_t seed, uint64_t a, uint64_t b)
{
    uint64_t key = rng_mix(rng_mix(rng_mix(seed + 0x9e3779b97f4a7c15u) ^ a) + 0x9e3779b97f4a7c15u * (b + 1));
    struct rng rng = {key, rng_mix(key) | 1};
    rng_uint(&rng);
    return rng;
}

/* Uniform in [0, 1). */
static inline float rng_float(struct rng *rng) { return (float)(rng_uint(rng) >> 8) * 0x1p-24f; }

#endif
