/* SPDX-License-Identifier: Apache-2.0 */
/* Well spread points in the unit square: Sobol's (0,2)-sequence, scrambled and padded to more dimensions by shuffling
 * the index (Kollig and Keller, "Efficient Multidimensional Sampling", 2002). Any power of two of points is stratified
 * in every way that cuts the square into as many equal boxes. */
#ifndef RENDER_SEQUENCE_H
#define RENDER_SEQUENCE_H

#include "eas/vec.h"
#include "render/rng.h"

/* One pair of dimensions of a pixel's points: draw one a pair, from the pixel's random numbers. */
struct sequence {
    uint32_t shuffle, scramble_x, scramble_y;
};

/* `count`: how many points will be taken; the shuffle stays inside the power of two that holds them. */
static inline struct sequence sequence_draw(struct rng *rng, int count)
{
    uint32_t block = 1;
    while (block < (uint32_t)count) block *= 2;
    struct sequence sequence;
    sequence.shuffle = rng_uint(rng) & (block - 1);
    sequence.scramble_x = rng_uint(rng);
    sequence.scramble_y = rng_uint(rng);
    return sequence;
}

static inline float2 sequence_point(struct sequence sequence, int i)
{
    uint32_t index = (uint32_t)i ^ sequence.shuffle, x = index, y = sequence.scramble_y;
    x = (x << 16) | (x >> 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    x = ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
    for (uint32_t v = 1u << 31; index; index >>= 1, v ^= v >> 1)
        if (index & 1) y ^= v;
    return (float2){(float)((x ^ sequence.scramble_x) >> 8) * 0x1p-24f, (float)(y >> 8) * 0x1p-24f};
}

#endif
