/* SPDX-License-Identifier: Apache-2.0 */
/* Sobol's points are what its matrices say, and a picture's points are stratified in each pixel and each square of
 * pixels. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/sequence.h"

/* The second dimension by its direction numbers, v_0 = 1/2, v_{k+1} = v_k ^ v_k / 2. */
static void test_the_second_dimension_is_sobols(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1u << 20; i += 37) {
        uint32_t sum = 0;
        for (uint32_t index = i, v = 1u << 31; index; index >>= 1, v ^= v >> 1)
            if (index & 1) sum ^= v;
        assert_int_equal(sequence_second(i), sum);
    }
}

/* How often a cell of the unit square, 2^k across and 64 cells in all, has one of 64 points; they are the samples of a
 * square of `side` pixels, in the pair of dimensions `pair`. */
static int cells_with_one(int side, int pair, int k)
{
    int counts[64] = {0}, ones = 0, spp = 64 / (side * side);
    for (int y = 2 * side; y < 3 * side; y++)
        for (int x = 5 * side; x < 6 * side; x++)
            for (int i = 0; i < spp; i++) {
                struct picture_sequence s = sequence_picture(7, x, y, i, spp);
                float2 p = {0, 0};
                for (int d = 0; d <= pair; d++) p = sequence_next(&s);
                counts[(int)(p.x * (float)(1 << k)) + ((int)(p.y * (float)(64 >> k)) << k)]++;
            }
    for (int i = 0; i < 64; i++) ones += counts[i] == 1;
    return ones;
}

static void test_squares_of_pixels_are_stratified_in_all_ways(void **state)
{
    (void)state;
    for (int side = 1; side <= 8; side *= 2)
        for (int pair = 0; pair < 3; pair++)
            for (int k = 0; k <= 6; k++) assert_int_equal(cells_with_one(side, pair, k), 64);
}

/* Pairs are padded: points that share a coordinate of one pair have all of the other's. */
static void test_pairs_are_independent_of_each_other(void **state)
{
    (void)state;
    enum { POINTS = 4096 };
    double product = 0;
    for (int i = 0; i < POINTS; i++) {
        struct picture_sequence s = sequence_picture(3, i % 64, i / 64, 0, 1);
        float a = sequence_next(&s).x, b = sequence_next(&s).x;
        product += (a - .5) * (b - .5) / POINTS;
    }
    assert_true(product < 3 / (12 * 64.0) && product > -3 / (12 * 64.0)); /* three sigmas of independent numbers */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_second_dimension_is_sobols),
        cmocka_unit_test(test_squares_of_pixels_are_stratified_in_all_ways),
        cmocka_unit_test(test_pairs_are_independent_of_each_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
