/* SPDX-License-Identifier: Apache-2.0 */
/* Well spread points in the unit square: Sobol's (0,2)-sequence, any power of two of which is stratified in every way
 * that cuts the square into as many equal boxes. More dimensions are padded by shuffling the index. */
#ifndef RENDER_SEQUENCE_H
#define RENDER_SEQUENCE_H

#include "eas/vec.h"
#include "render/rng.h"

static inline uint32_t sequence_reverse(uint32_t x)
{
    x = (x << 16) | (x >> 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

/* The second coordinate of point `index`, the first being sequence_reverse: Pascal's triangle modulo 2 times the index,
 * which factors into five steps. */
static inline uint32_t sequence_second(uint32_t index)
{
    uint32_t x = index;
    for (int k = 0; k < 5; k++) {
        static const uint32_t upper[5] = {0xaaaaaaaau, 0xccccccccu, 0xf0f0f0f0u, 0xff00ff00u, 0xffff0000u};
        x ^= (x & upper[k]) >> (1 << k);
    }
    return sequence_reverse(x);
}

/* One pair of dimensions of a pixel's points: draw one a pair, from the pixel's random numbers (Kollig and Keller,
 * "Efficient Multidimensional Sampling", 2002). */
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
    uint32_t index = (uint32_t)i ^ sequence.shuffle;
    uint32_t x = sequence_reverse(index) ^ sequence.scramble_x, y = sequence_second(index) ^ sequence.scramble_y;
    return (float2){(float)(x >> 8) * 0x1p-24f, (float)(y >> 8) * 0x1p-24f};
}

/* Points of a whole picture: one sequence along a Z-order curve over the pixels, so that not only those of a pixel but
 * also those of any aligned square of them are well spread, and errors even out between neighbours, where a denoiser or
 * an eye averages (Ahmed and Wonka, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error", 2020). */
struct picture_sequence {
    uint32_t index; /* of the point; of each pixel's power of two */
    uint32_t key;   /* chooses the picture's sequence */
    uint32_t drawn; /* dimensions so far */
};

static inline uint32_t sequence_spread_bits(uint32_t x)
{
    x = (x | (x << 8)) & 0x00ff00ffu;
    x = (x | (x << 4)) & 0x0f0f0f0fu;
    x = (x | (x << 2)) & 0x33333333u;
    return (x | (x << 1)) & 0x55555555u;
}

/* Sample i of `count` at pixel (x, y), each below 65536. */
static inline struct picture_sequence sequence_picture(uint64_t seed, int x, int y, int i, int count)
{
    uint32_t block = 1;
    while (block < (uint32_t)count) block *= 2;
    uint32_t pixel = sequence_spread_bits((uint32_t)x) | sequence_spread_bits((uint32_t)y) << 1;
    return (struct picture_sequence){pixel * block + (uint32_t)i, (uint32_t)rng_mix(seed + 1), 0};
}

/* Owen's scrambling of a number whose bits are reversed: each bit is flipped or not by those below it (Laine and Karras
 * 2011, with the constants of Vegdahl; Burley, "Practical Hash-based Owen Scrambling", 2020). */
static inline uint32_t sequence_scramble(uint32_t x, uint32_t key)
{
    x ^= x * 0x3d20adeau;
    x += key;
    x *= (key >> 16) | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* The next two dimensions. */
static inline float2 sequence_next(struct picture_sequence *s)
{
    uint64_t keys = rng_mix((uint64_t)s->key << 32 | ++s->drawn), more = rng_mix(keys);
    uint32_t index = sequence_reverse(sequence_scramble(sequence_reverse(s->index), (uint32_t)keys));
    uint32_t x = sequence_reverse(sequence_scramble(index, (uint32_t)more));
    uint32_t y = sequence_reverse(sequence_scramble(sequence_reverse(sequence_second(index)), (uint32_t)(more >> 32)));
    return (float2){(float)(x >> 8) * 0x1p-24f, (float)(y >> 8) * 0x1p-24f};
}

#endif
