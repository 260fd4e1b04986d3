/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures in and out: what is written is what is read, the same bytes every time, nothing left after a failure. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "render/image.h"

static char folder[128];
static char error[IMAGE_ERROR];

static int set_up(void **state)
{
    (void)state;
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%.80s/burnish-image-XXXXXX", parent ? parent : P_tmpdir);
    return mkdtemp(folder) ? 0 : -1;
}

static const char *in_folder(const char *name)
{
    static char path[2][192];
    static int turn;
    turn = !turn;
    snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
    return path[turn];
}

/* Values that neither half nor 8 bits hold exactly, with a sign and a large one. */
static void make(struct image *image, const char *const *names, int count)
{
    assert_true(image_alloc(image, 5, 3, count));
    for (int i = 0; i < count; ++i) strcpy(image->channels[i], names[i]);
    for (int i = 0; i < 15 * count; ++i) image->pixels[i] = (float)(i - 4) * 0.123456789f + (i == 7 ? 5e4f : 0);
}

static const char *const layered[] = {"ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B",
                                      "ViewLayer.Depth.Z"};

static void exr_keeps_floats_and_names(void **state)
{
    (void)state;
    struct image out, in;
    make(&out, layered, 4);
    const struct image_attribute attribute = {"burnish:method", "path"};
    assert_true(image_write(in_folder("a.exr"), &out, false, &attribute, 1, error));
    assert_true(image_read(in_folder("a.exr"), false, &in, error));
    assert_int_equal(in.width, 5);
    assert_int_equal(in.height, 3);
    assert_int_equal(in.channel_count, 4);
    for (int c = 0; c < 4; ++c) {
        int from = image_channel(&in, layered[c]);
        assert_true(from >= 0);
        for (int i = 0; i < 15; ++i) assert_true(in.pixels[i * 4 + from] == out.pixels[i * 4 + c]);
    }
    image_free(&in);
    image_free(&out);
    unlink(in_folder("a.exr"));
}

static void half_rounds_to_eleven_bits(void **state)
{
    (void)state;
    struct image out, in;
    make(&out, layered, 3);
    assert_true(image_write(in_folder("a.exr"), &out, true, NULL, 0, error));
    assert_true(image_read(in_folder("a.exr"), false, &in, error));
    int rounded = 0;
    for (int c = 0; c < 3; ++c) {
        int from = image_channel(&in, layered[c]);
        for (int i = 0; i < 15; ++i) {
            float x = out.pixels[i * 3 + c], y = in.pixels[i * 3 + from];
            assert_true(y - x <= (x < 0 ? -x : x) / 2048 && x - y <= (x < 0 ? -x : x) / 2048);
            rounded += x != y;
        }
    }
    assert_true(rounded > 15);
    image_free(&in);
    image_free(&out);
    unlink(in_folder("a.exr"));
}

static size_t slurp(const char *path, char *bytes, size_t size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t count = fread(bytes, 1, size, file);
    fclose(file);
    assert_true(count < size);
    return count;
}

static void bytes_do_not_depend_on_the_time(void **state)
{
    (void)state;
    static char first[1 << 16], second[1 << 16];
    const char *const endings[] = {"a.exr", "a.png"};
    struct image out;
    size_t sizes[2];
    make(&out, layered, 3);
    for (int i = 0; i < 2; ++i) {
        assert_true(image_write(in_folder(endings[i]), &out, false, NULL, 0, error));
        sizes[i] = slurp(in_folder(endings[i]), first + i * 32768, 32768);
    }
    sleep(1); /* the dates in such headers count seconds */
    for (int i = 0; i < 2; ++i) {
        assert_true(image_write(in_folder(endings[i]), &out, false, NULL, 0, error));
        assert_int_equal(sizes[i], slurp(in_folder(endings[i]), second + i * 32768, 32768));
        assert_memory_equal(first + i * 32768, second + i * 32768, sizes[i]);
        unlink(in_folder(endings[i]));
    }
    image_free(&out);
}

/* IEC 61966-2-1 evaluated by hand: 8-bit values and their linear light. */
static void srgb_decodes_colours_not_alpha(void **state)
{
    (void)state;
    static const struct { int byte; float linear; } known[] = {
        {0, 0}, {10, 0.003035270f}, {11, 0.003346536f}, {128, 0.215860500f}, {188, 0.502886458f}, {255, 1}};
    static const char *const names[] = {"R", "G", "B", "A"};
    struct image out, in;
    assert_true(image_alloc(&out, 6, 1, 4));
    for (int c = 0; c < 4; ++c) strcpy(out.channels[c], names[c]);
    for (int i = 0; i < 6; ++i)
        for (int c = 0; c < 4; ++c) out.pixels[i * 4 + c] = c == 3 ? 0.4f : (float)known[i].byte / 255;
    assert_true(image_write(in_folder("a.png"), &out, false, NULL, 0, error));
    assert_true(image_read(in_folder("a.png"), true, &in, error));
    for (int i = 0; i < 6; ++i) {
        for (int c = 0; c < 3; ++c) assert_float_equal(in.pixels[i * 4 + c], known[i].linear, 1e-6f);
        assert_float_equal(in.pixels[i * 4 + 3], 0.4f, 1e-6f); /* and the colours are not multiplied by it */
    }
    image_free(&in);
    assert_true(image_read(in_folder("a.png"), false, &in, error));
    for (int i = 0; i < 6; ++i) assert_float_equal(in.pixels[i * 4], (float)known[i].byte / 255, 1e-6f);
    image_free(&in);
    image_free(&out);
    unlink(in_folder("a.png"));
    for (int i = 0; i < 6; ++i)
        assert_float_equal(image_srgb_encode(known[i].linear), (float)known[i].byte / 255, 1e-6f);
}

static void channels_are_found_by_layer(void **state)
{
    (void)state;
    static const char *const names[] = {"ViewLayer.Combined.R", "ViewLayer.Indirect.R", "MyCombined.G", "Combined.B"};
    struct image image;
    make(&image, names, 4);
    assert_int_equal(image_channel(&image, "Combined.R"), 0);
    assert_int_equal(image_channel(&image, "Indirect.R"), 1);
    assert_int_equal(image_channel(&image, "Combined.G"), -1);
    assert_int_equal(image_channel(&image, "Combined.B"), 3);
    strcpy(image.channels[2], "G");
    assert_int_equal(image_channel(&image, "Combined.G"), 2);
    assert_int_equal(image_channel(&image, "Indirect.G"), -1);
    image_free(&image);
}

static void failures_name_the_file(void **state)
{
    (void)state;
    struct image image;
    assert_false(image_read(in_folder("none.exr"), false, &image, error));
    assert_non_null(strstr(error, "none.exr"));
    assert_null(image.pixels);

    FILE *file = fopen(in_folder("text.png"), "w");
    assert_non_null(file);
    fputs("not a picture", file);
    fclose(file);
    assert_false(image_read(in_folder("text.png"), false, &image, error));
    assert_non_null(strstr(error, "text.png"));
    unlink(in_folder("text.png"));

    make(&image, layered, 4);
    assert_false(image_write(in_folder("missing/a.exr"), &image, false, NULL, 0, error));
    assert_non_null(strstr(error, "missing/a.exr"));
    assert_int_equal(mkdir(in_folder("d.exr"), 0700), 0); /* written beside it, but cannot take its place */
    assert_false(image_write(in_folder("d.exr"), &image, false, NULL, 0, error));
    assert_int_equal(rmdir(in_folder("d.exr")), 0);
    assert_false(image_write(in_folder("a.jpg"), &image, false, NULL, 0, error));
    assert_non_null(strstr(error, ".exr or .png"));
    assert_false(image_write(in_folder("a.unheard"), &image, false, NULL, 0, error));
    image_free(&image);
}

static void a_truncated_picture_is_refused(void **state)
{
    (void)state;
    struct image out, in;
    make(&out, layered, 3);
    assert_true(image_write(in_folder("a.exr"), &out, false, NULL, 0, error));
    assert_int_equal(truncate(in_folder("a.exr"), 500), 0);
    if (image_read(in_folder("a.exr"), false, &in, error)) fail_msg("a picture cut short was read");
    assert_non_null(strstr(error, "a.exr"));
    assert_null(in.pixels);
    image_free(&out);
    unlink(in_folder("a.exr"));
}

/* Comes last: each writer has cleaned up after itself, each test too. */
static void nothing_is_left(void **state)
{
    (void)state;
    assert_int_equal(rmdir(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exr_keeps_floats_and_names),     cmocka_unit_test(half_rounds_to_eleven_bits),
        cmocka_unit_test(bytes_do_not_depend_on_the_time), cmocka_unit_test(srgb_decodes_colours_not_alpha),
        cmocka_unit_test(channels_are_found_by_layer),     cmocka_unit_test(failures_name_the_file),
        cmocka_unit_test(a_truncated_picture_is_refused),  cmocka_unit_test(nothing_is_left)};
    return cmocka_run_group_tests(tests, set_up, NULL);
}
