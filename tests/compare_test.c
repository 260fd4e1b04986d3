/* SPDX-License-Identifier: Apache-2.0 */
/* Errors between pictures whose errors are known by construction. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "render/compare.h"
#include "render/rng.h"

#define SIZE 64
static char error[IMAGE_ERROR];

/* Combined constant, and where `emission` an AOV Emission of zeros. */
static struct image picture(float value, bool emission)
{
    struct image image;
    assert_true(image_alloc(&image, SIZE, SIZE, emission ? 6 : 3));
    for (int c = 0; c < image.channel_count; ++c)
        snprintf(image.channels[c], IMAGE_CHANNEL, "ViewLayer.%s.%c", c < 3 ? "Combined" : "Emission", "RGB"[c % 3]);
    for (int i = 0; i < SIZE * SIZE; ++i)
        for (int c = 0; c < 3; ++c) image.pixels[i * image.channel_count + c] = value;
    return image;
}

static float *at(struct image *image, int x, int y, int channel)
{
    return image->pixels + (y * image->width + x) * image->channel_count + channel;
}

/* Adds noise of mean 0 and standard deviation `deviation`: uniform, so sqrt 12 wide. */
static void add_noise(struct image *image, float deviation, uint64_t seed)
{
    struct rng rng = rng_seed(seed, 0, 0);
    for (int i = 0; i < SIZE * SIZE; ++i)
        for (int c = 0; c < 3; ++c)
            image->pixels[i * image->channel_count + c] += deviation * 3.4641016f * (rng_float(&rng) - 0.5f);
}

static struct compare_result run(const struct compare_input *input)
{
    struct compare_result result;
    if (!compare(input, &result, error)) fail_msg("%s", error);
    return result;
}

static void an_offset_is_its_own_error(void **state)
{
    (void)state;
    struct image x = picture(2.2f, false), r = picture(2, false);
    struct compare_errors e = run(&(struct compare_input){.image = &x, .reference = &r}).masked;
    assert_float_equal(e.rmse, 0.2, 1e-6);
    assert_float_equal(e.cv_rmse, 0.1, 1e-6);
    assert_float_equal(e.relmse, 0.04 / (4 + 0.01 * 4), 1e-6);
    assert_float_equal(e.mean_ratio, 1.1, 1e-6);
    assert_float_equal(e.block_cv, 0.1, 1e-6);
    assert_float_equal(e.block_sigma, 0, 1e-6);
    assert_float_equal(e.reference_cv, 0, 0);
    assert_int_equal(e.pixels, SIZE * SIZE);
    image_free(&x);
    image_free(&r);
}

static void channels_weigh_the_same(void **state)
{
    (void)state;
    for (int c = 0; c < 3; ++c) {
        struct image x = picture(1, false), r = picture(1, false);
        for (int i = 0; i < SIZE * SIZE; ++i) x.pixels[i * 3 + c] = 1.3f;
        struct compare_errors e = run(&(struct compare_input){.image = &x, .reference = &r}).all;
        assert_float_equal(e.cv_rmse, 0.3 / sqrt(3), 1e-6);
        assert_float_equal(e.mean_ratio, 1.1, 1e-6);
        image_free(&x);
        image_free(&r);
    }
}

/* 12288 values: a mean of squares of size v has a standard error near v sqrt(2 / 12288) = .013 v. */
static void halves_take_the_references_noise_out(void **state)
{
    (void)state;
    struct image x = picture(1.1f, false), a = picture(1, false), b = picture(1, false);
    add_noise(&a, 0.3f, 1);
    add_noise(&b, 0.3f, 2);
    struct compare_errors one = run(&(struct compare_input){.image = &x, .reference = &a}).all;
    struct compare_errors two = run(&(struct compare_input){.image = &x, .reference = &a, .reference2 = &b}).all;
    assert_float_equal(one.rmse, sqrt(0.1 * 0.1 + 0.3 * 0.3), 0.01);
    assert_float_equal(two.rmse, 0.1, 0.01);
    assert_float_equal(two.reference_cv, 0.3 / sqrt(2), 0.005);
    image_free(&x);
    image_free(&a);
    image_free(&b);
}

static void halves_of_both_sides_take_both_noises_out(void **state)
{
    (void)state;
    struct image x1 = picture(1.1f, false), x2 = picture(1.1f, false), a = picture(1, false), b = picture(1, false);
    struct image *all[] = {&x1, &x2, &a, &b};
    for (uint64_t i = 0; i < 4; ++i) add_noise(all[i], 0.3f, i + 1);
    struct compare_errors e = run(&(struct compare_input){&x1, &x2, &a, &b, NULL}).all;
    assert_float_equal(e.rmse, 0.1, 0.015);
    e = run(&(struct compare_input){&x1, NULL, &a, &b, NULL}).all;
    assert_float_equal(e.rmse, sqrt(0.1 * 0.1 + 0.3 * 0.3), 0.015);
    for (int i = 0; i < 4; ++i) image_free(all[i]);
}

/* x between the halves: (x-A)(x-B) = -.04 everywhere. */
static void a_negative_mean_product_keeps_its_sign(void **state)
{
    (void)state;
    struct image x = picture(1, false), a = picture(0.8f, false), b = picture(1.2f, false);
    struct compare_errors e = run(&(struct compare_input){.image = &x, .reference = &a, .reference2 = &b}).all;
    assert_float_equal(e.rmse, -0.2, 1e-6);
    assert_float_equal(e.cv_rmse, -0.2, 1e-6);
    assert_float_equal(e.block_cv, -0.2, 1e-6);
    image_free(&x);
    image_free(&a);
    image_free(&b);
}

static void blocks_average_what_has_mean_zero(void **state)
{
    (void)state;
    struct image x = picture(1, false), r = picture(1, false);
    for (int y = 0; y < SIZE; ++y)
        for (int i = 0; i < SIZE; ++i)
            for (int c = 0; c < 3; ++c) *at(&x, i, y, c) += (i + y) % 2 ? 0.5f : -0.5f;
    struct compare_errors e = run(&(struct compare_input){.image = &x, .reference = &r}).all;
    assert_float_equal(e.cv_rmse, 0.5, 1e-6);
    assert_float_equal(e.block_cv, 0, 1e-6);
    image_free(&x);
    image_free(&r);
}

/* Of unbiased noisy pairs 95 % should lie within two sigma; 300 of them: 285 expected, standard deviation 4. A bias of
 * a sixth of the noise makes a mean product of .05^2, some ten standard errors (2 .0375^2 / sqrt 192): always found. */
static void block_sigma_covers_noise_and_finds_bias(void **state)
{
    (void)state;
    int inside = 0, inside_biased = 0;
    for (uint64_t trial = 0; trial < 300; ++trial) {
        struct image noisy[6]; /* two halves each of a picture, of a biased one and of the reference */
        for (uint64_t i = 0; i < 6; ++i) {
            noisy[i] = picture(i == 2 || i == 3 ? 1.05f : 1, false);
            add_noise(&noisy[i], 0.3f, 6 * trial + i);
        }
        struct compare_errors e =
            run(&(struct compare_input){&noisy[0], &noisy[1], &noisy[4], &noisy[5], NULL}).all;
        inside += fabs(e.block_cv) <= 2 * e.block_sigma;
        e = run(&(struct compare_input){&noisy[2], &noisy[3], &noisy[4], &noisy[5], NULL}).all;
        inside_biased += fabs(e.block_cv) <= 2 * e.block_sigma;
        for (int i = 0; i < 6; ++i) image_free(&noisy[i]);
    }
    assert_in_range(inside, 270, 297);
    assert_int_equal(inside_biased, 0);
}

static void emitters_and_four_pixels_around_are_left_out(void **state)
{
    (void)state;
    for (int mask_from_picture = 0; mask_from_picture < 2; ++mask_from_picture) {
        struct image x = picture(1, mask_from_picture), r = picture(1, !mask_from_picture);
        *at(mask_from_picture ? &x : &r, 20, 30, 4) = 0.001f;
        for (int y = 26; y <= 34; ++y)
            for (int i = 16; i <= 24; ++i) *at(&x, i, y, 0) = 9;
        struct compare_result result = run(&(struct compare_input){.image = &x, .reference = &r});
        assert_float_equal(result.masked.rmse, 0, 0);
        assert_int_equal(result.masked.pixels, SIZE * SIZE - 81);
        assert_float_equal(result.all.rmse, sqrt(81 * 64 / (3.0 * SIZE * SIZE)), 1e-6);
        *at(&x, 25, 30, 0) = 9;
        result = run(&(struct compare_input){.image = &x, .reference = &r});
        assert_float_equal(result.masked.rmse, sqrt(64 / (3.0 * (SIZE * SIZE - 81))), 1e-6);
        image_free(&x);
        image_free(&r);
    }
}

static void an_emitter_at_the_corner_masks_what_is_there(void **state)
{
    (void)state;
    struct image x = picture(1, false), r = picture(1, true);
    *at(&r, 0, 0, 3) = 1;
    *at(&r, SIZE - 1, SIZE - 1, 3) = 1;
    assert_int_equal(run(&(struct compare_input){.image = &x, .reference = &r}).masked.pixels, SIZE * SIZE - 50);
    image_free(&x);
    image_free(&r);
}

static void expect_refusal(const struct compare_input *input, const char *word)
{
    struct compare_result result;
    error[0] = '\0';
    assert_false(compare(input, &result, error));
    if (!strstr(error, word)) fail_msg("'%s' does not say '%s'", error, word);
}

static void what_cannot_be_compared_is_refused(void **state)
{
    (void)state;
    struct image x = picture(1, false), r = picture(1, true), small;
    assert_true(image_alloc(&small, 8, 8, 3));
    for (int c = 0; c < 3; ++c) snprintf(small.channels[c], IMAGE_CHANNEL, "%c", "RGB"[c]);
    expect_refusal(&(struct compare_input){.image = &x, .reference = &small}, "8 x 8");
    expect_refusal(&(struct compare_input){.image = &small, .reference = &small}, "mean");
    expect_refusal(&(struct compare_input){.image = &x, .reference = &r, .layer = "Indirect"}, "Indirect");
    *at(&x, 3, 5, 1) = NAN;
    expect_refusal(&(struct compare_input){.image = &x, .reference = &r}, "(3, 5)");
    *at(&x, 3, 5, 1) = INFINITY;
    expect_refusal(&(struct compare_input){.image = &x, .reference = &r}, "(3, 5)");
    *at(&x, 3, 5, 1) = 1;
    for (int i = 0; i < SIZE * SIZE; ++i) r.pixels[i * 6 + 3] = 1;
    expect_refusal(&(struct compare_input){.image = &x, .reference = &r}, "nothing is left");
    image_free(&x);
    image_free(&r);
    image_free(&small);
}

static void false_colours_follow_the_scale(void **state)
{
    (void)state;
    struct image x = picture(1, false), r = picture(1, false), out;
    for (int c = 0; c < 3; ++c) {
        *at(&x, 1, 0, c) = 1.2f;
        *at(&x, 2, 0, c) = 0.8f;
        *at(&x, 3, 0, c) = 9;
    }
    *at(&x, 4, 0, 0) = 1.6f;
    assert_true(compare_picture(&(struct compare_input){.image = &x, .reference = &r}, &out, error));
    static const float expected[5][3] = {{0, 0, 0}, {1, 1, 0}, {1, 1, 0}, {1, 1, 1}, {1, 1, 0}};
    for (int i = 0; i < 5; ++i)
        for (int c = 0; c < 3; ++c) assert_float_equal(*at(&out, i, 0, c), expected[i][c], 1e-4);
    image_free(&x);
    image_free(&r);
    image_free(&out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(an_offset_is_its_own_error),
                                       cmocka_unit_test(channels_weigh_the_same),
                                       cmocka_unit_test(halves_take_the_references_noise_out),
                                       cmocka_unit_test(halves_of_both_sides_take_both_noises_out),
                                       cmocka_unit_test(a_negative_mean_product_keeps_its_sign),
                                       cmocka_unit_test(blocks_average_what_has_mean_zero),
                                       cmocka_unit_test(block_sigma_covers_noise_and_finds_bias),
                                       cmocka_unit_test(emitters_and_four_pixels_around_are_left_out),
                                       cmocka_unit_test(an_emitter_at_the_corner_masks_what_is_there),
                                       cmocka_unit_test(what_cannot_be_compared_is_refused),
                                       cmocka_unit_test(false_colours_follow_the_scale)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
