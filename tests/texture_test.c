/* SPDX-License-Identifier: Apache-2.0 */
/* Texture look-up: interpolation, borders, placement and the checker. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "render/texture.h"

/* Two texels by two: 1 2 in the upper row, 3 4 in the lower. */
static float pixels[4] = {1, 2, 3, 4};
static struct image image = {.width = 2, .height = 2, .channel_count = 1, .pixels = pixels};

static float at(float u, float v, enum texture_interpolation interpolation, enum texture_extension extension)
{
    return texture_image(&image, (float2){u, v}, interpolation, extension).y;
}

static void interpolation(void **state)
{
    (void)state;
    assert_float_equal(at(0.25f, 0.75f, TEXTURE_LINEAR, TEXTURE_EXTEND), 1, 1e-6f);
    assert_float_equal(at(0.75f, 0.25f, TEXTURE_LINEAR, TEXTURE_EXTEND), 4, 1e-6f);
    assert_float_equal(at(0.5f, 0.5f, TEXTURE_LINEAR, TEXTURE_EXTEND), 2.5f, 1e-6f);
    assert_float_equal(at(0.375f, 0.75f, TEXTURE_LINEAR, TEXTURE_EXTEND), 1.25f, 1e-6f);
    assert_float_equal(at(0.49f, 0.51f, TEXTURE_CLOSEST, TEXTURE_EXTEND), 1, 0);
    assert_float_equal(at(0.51f, 0.49f, TEXTURE_CLOSEST, TEXTURE_EXTEND), 4, 0);
}

static void borders(void **state)
{
    (void)state;
    assert_float_equal(at(0, 0.75f, TEXTURE_LINEAR, TEXTURE_EXTEND), 1, 1e-6f);
    assert_float_equal(at(0, 0.75f, TEXTURE_LINEAR, TEXTURE_REPEAT), 1.5f, 1e-6f);
    assert_float_equal(at(0, 0.75f, TEXTURE_LINEAR, TEXTURE_CLIP), 0.5f, 1e-6f);
    assert_float_equal(at(-3.75f, 2.75f, TEXTURE_LINEAR, TEXTURE_REPEAT), 1, 1e-5f);
    assert_float_equal(at(5, -5, TEXTURE_LINEAR, TEXTURE_EXTEND), 4, 1e-6f);
    assert_float_equal(at(1.3f, 0.5f, TEXTURE_LINEAR, TEXTURE_CLIP), 0, 0);
    assert_float_equal(at(-0.1f, 0.9f, TEXTURE_CLOSEST, TEXTURE_REPEAT), 2, 0);
    assert_float_equal(at(1e30f, 0.9f, TEXTURE_LINEAR, TEXTURE_EXTEND), 2, 1e-6f); /* far away, no overflow */
}

static void placement_and_checker(void **state)
{
    (void)state;
    struct scene_texture list[2] = {
        {.type = TEXTURE_IMAGE, .interpolation = TEXTURE_CLOSEST, .uv_transform = {0, 2, 0.25f, 1, 0, 0}},
        {.type = TEXTURE_CHECKER,
         .colour1 = {1, 1, 1},
         .colour2 = {2, 2, 2},
         .scale = 4,
         .uv_transform = {1, 0, 0, 0, 1, 0}}};
    struct scene scene = {.textures = list, .texture_count = 2, .image_count = 1};
    struct textures textures = {&scene, &image};
    assert_float_equal(texture_lookup(&textures, 0, (float2){0.75f, 0}).x, 1, 0);     /* looked up at (.25, .75) */
    assert_float_equal(texture_lookup(&textures, 0, (float2){0.25f, 0.25f}).x, 4, 0); /* at (.75, .25) */
    assert_float_equal(texture_lookup(&textures, 1, (float2){0.1f, 0.1f}).x, 1, 0);
    assert_float_equal(texture_lookup(&textures, 1, (float2){0.3f, 0.1f}).x, 2, 0);
    assert_float_equal(texture_lookup(&textures, 1, (float2){0.3f, 0.3f}).x, 1, 0);
    assert_float_equal(texture_lookup(&textures, 1, (float2){-0.1f, 0.1f}).x, 2, 0);
    assert_float_equal(texture_lookup(&textures, 1, (float2){-0.1f, -0.1f}).x, 1, 0);
    assert_float_equal(texture_lookup(&textures, 1, (float2){0, 0}).x, 1, 0); /* borders: the cell above */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(interpolation), cmocka_unit_test(borders),
                                       cmocka_unit_test(placement_and_checker)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
