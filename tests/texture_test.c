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
    return texture_image(&image, (float2){u, v}, interpolation, extension, false).y;
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

static void mirrored(void **state)
{
    (void)state;
    /* Left of the picture it goes on as from its left edge inwards, and so on. */
    assert_float_equal(at(-.25f, .75f, TEXTURE_CLOSEST, TEXTURE_MIRROR), 1, 0);
    assert_float_equal(at(-.75f, .75f, TEXTURE_CLOSEST, TEXTURE_MIRROR), 2, 0);
    assert_float_equal(at(1.25f, .75f, TEXTURE_CLOSEST, TEXTURE_MIRROR), 2, 0);
    assert_float_equal(at(2.25f, 1.25f, TEXTURE_CLOSEST, TEXTURE_MIRROR), 1, 0);
    assert_float_equal(at(2.75f, -.25f, TEXTURE_CLOSEST, TEXTURE_MIRROR), 4, 0);
    assert_float_equal(at(0, .75f, TEXTURE_LINEAR, TEXTURE_MIRROR), 1, 1e-6f);
}

static void alpha(void **state)
{
    (void)state;
    float grey[4] = {1, .2f, 3, .4f}, colour[4] = {1, 2, 3, .25f};
    struct image two = {.width = 2, .height = 1, .channel_count = 2, .pixels = grey};
    struct image four = {.width = 1, .height = 1, .channel_count = 4, .pixels = colour};
    assert_float_equal(texture_image(&two, (float2){.5f, .5f}, TEXTURE_LINEAR, TEXTURE_EXTEND, true).y, .3f, 1e-6f);
    assert_float_equal(texture_image(&two, (float2){.5f, .5f}, TEXTURE_LINEAR, TEXTURE_EXTEND, false).y, 2, 1e-6f);
    assert_float_equal(texture_image(&four, (float2){.5f, .5f}, TEXTURE_LINEAR, TEXTURE_CLIP, true).x, .25f, 1e-6f);
    assert_float_equal(texture_image(&four, (float2){1.5f, .5f}, TEXTURE_LINEAR, TEXTURE_CLIP, true).x, 0, 0);
    assert_float_equal(texture_image(&image, (float2){.5f, .5f}, TEXTURE_LINEAR, TEXTURE_EXTEND, true).x, 1, 0);
}

static float look_up(const struct textures *textures, int index, float u, float v)
{
    return texture_lookup(textures, index, &(struct texture_place){.uv = {u, v}, .front = true}).x;
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
    bool encoded = false;
    struct textures textures = {&scene, &image, &encoded};
    assert_float_equal(look_up(&textures, 0, 0.75f, 0), 1, 0);     /* looked up at (.25, .75) */
    assert_float_equal(look_up(&textures, 0, 0.25f, 0.25f), 4, 0); /* at (.75, .25) */
    assert_float_equal(look_up(&textures, 1, 0.1f, 0.1f), 1, 0);
    assert_float_equal(look_up(&textures, 1, 0.3f, 0.1f), 2, 0);
    assert_float_equal(look_up(&textures, 1, 0.3f, 0.3f), 1, 0);
    assert_float_equal(look_up(&textures, 1, -0.1f, 0.1f), 2, 0);
    assert_float_equal(look_up(&textures, 1, -0.1f, -0.1f), 1, 0);
    assert_float_equal(look_up(&textures, 1, 0, 0), 1, 0); /* borders: the cell above */
}

/* Half way between two texels of an 8-bit picture is the decoded mean of its numbers, not the mean of what they say. */
static void bytes_are_decoded_last(void **state)
{
    (void)state;
    float numbers[2] = {.2f, .8f};
    struct image bytes = {.width = 2, .height = 1, .channel_count = 1, .pixels = numbers};
    struct scene_texture list[2] = {{.type = TEXTURE_IMAGE, .uv_transform = {1, 0, 0, 0, 1, 0}},
                                    {.type = TEXTURE_IMAGE, .uv_transform = {1, 0, 0, 0, 1, 0}, .alpha = true}};
    struct scene scene = {.textures = list, .texture_count = 2, .image_count = 1};
    bool encoded = true;
    struct textures textures = {&scene, &bytes, &encoded};
    assert_float_equal(look_up(&textures, 0, .5f, .5f), .21404114f, 1e-5f);
    numbers[0] = numbers[1] = .5f;
    bytes.width = 1;
    bytes.channel_count = 2;
    assert_float_equal(look_up(&textures, 1, .5f, .5f), .5f, 0); /* alpha is no colour */
}

static void by_angle(void **state)
{
    (void)state;
    const float front[9] = {1, 1, 1, .5f, .5f, .5f, .2f, .2f, .2f}, back[9] = {0, 0, 0, 2, 2, 2, 4, 4, 4};
    struct scene_texture texture = {.type = TEXTURE_ANGLE, .sample_count = 3, .front = front, .back = back};
    struct scene scene = {.textures = &texture, .texture_count = 1};
    struct textures textures = {&scene, NULL, NULL};
    const float cosines[] = {0, .25f, .5f, .75f, 1}, expected[] = {1, .75f, .5f, .35f, .2f};
    for (int i = 0; i < 5; i++) {
        struct texture_place place = {.cosine = cosines[i], .front = true};
        assert_float_equal(texture_lookup(&textures, 0, &place).z, expected[i], 1e-6f);
        place.front = false;
        assert_float_equal(texture_lookup(&textures, 0, &place).y, 4 * cosines[i], 1e-6f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interpolation),         cmocka_unit_test(borders),
        cmocka_unit_test(mirrored),              cmocka_unit_test(alpha),
        cmocka_unit_test(placement_and_checker), cmocka_unit_test(bytes_are_decoded_last),
        cmocka_unit_test(by_angle)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
