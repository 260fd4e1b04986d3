/* SPDX-License-Identifier: Apache-2.0 */
/* Caches in a file: they come back as they were, and no file, whatever its bytes, breaks the program. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "import/scene_hash.h"
#include "render/cache_file.h"
#include "render/cached.h"
#include "render/rng.h"
#include "tests/stage.h"

enum { ZONES = 100, EAS = 5 * ZONES, HSH = 161, SIZE = 8, HASH = 77 };
static const char path[] = "build/cache_file_test.tmp";
static const struct fill_options options = {.kind = FILL_EAS, .seed = 3};

static float3 spread(struct rng *rng) { return vec3(rng_float(rng) - .5f, rng_float(rng) - .5f, rng_float(rng) - .5f); }

static void add_zones(struct cache *cache, struct rng *rng)
{
    *cache = cache_empty(1.5f);
    for (int i = 0; i < ZONES; i++) {
        float3 p = {4 * rng_float(rng) - 2, 4 * rng_float(rng) - 2, -2};
        assert_true(cache_insert(cache, (struct zone){p, {0, 0, 1}, .1f + .3f * rng_float(rng)}, .1f));
    }
}

static void add_records(struct record_cache *cache, uint32_t eas_count, struct rng *rng)
{
    add_zones(&cache->zones, rng);
    cache->records = calloc(ZONES, sizeof *cache->records);
    cache->eas = calloc(eas_count + 1, sizeof *cache->eas);
    cache->hsh = calloc(HSH, sizeof *cache->hsh);
    cache->hsh_count = eas_count ? HSH : 0;
    cache->eas_count = eas_count;
    for (uint32_t i = 0; i < ZONES; i++)
        cache->records[i] = (struct record){{.e = {1, 2, 3}}, i * (eas_count / ZONES), eas_count / ZONES, 0, 0};
    for (uint32_t i = 0; i < eas_count; i++)
        cache->eas[i] =
            eas_make(vec3(0, 0, -2), mad(vec3(0, 0, 1), spread(rng), 2), spread(rng), vec3(1, 2, 3), .1f, i % 3 == 0);
}

static void add_photons(struct caustics *caustics, struct rng *rng)
{
    *caustics = (struct caustics){.photons = calloc(ZONES, sizeof *caustics->photons), .count = ZONES, .reach = .4f};
    for (int i = 0; i < ZONES; i++)
        caustics->photons[i] =
            (struct photon){{4 * rng_float(rng) - 2, 4 * rng_float(rng) - 2, -2}, {0, 0, 1}, {1, rng_float(rng), 1}};
    assert_true(caustics_index(caustics));
}

/* Caches about the floor of new_scene, made without a ray. */
static struct fill new_fill(void)
{
    struct rng rng = rng_seed(1, 2, 3);
    struct fill fill = {.options = options, .tables = mean_brdf_build()};
    add_zones(&fill.bounced.zones, &rng);
    add_photons(&fill.bounced.caustics, &rng);
    fill.bounced.e = calloc(ZONES, sizeof *fill.bounced.e);
    add_records(&fill.diffuse, 0, &rng);
    add_records(&fill.glossy, EAS, &rng);
    cache_reindex(&fill.bounced.zones);
    cache_reindex(&fill.diffuse.zones);
    cache_reindex(&fill.glossy.zones);
    return fill;
}

static struct stage *new_scene(void)
{
    struct stage *s = new_stage();
    add_quad(s, vec3(-1, 0, -2), vec3(1, 0, 0), vec3(0, 2, 0), grey(.4f, .3f, 60, 0));
    add_quad(s, vec3(1, 0, -2), vec3(1, 0, 0), vec3(0, 2, 0), grey(.4f, 0, 0, 0));
    s->scene.camera.width = s->scene.camera.height = SIZE;
    s->scene.world.radiance[0] = 1;
    s->materials[0].name = "Gloss";
    return s;
}

/* All that the file can tell of the caches, as pixels. */
static void draw(const struct model *model, const struct fill *fill, struct pixel pixels[SIZE * SIZE])
{
    struct cached cached;
    assert_true(cached_prepare(model, fill, &cached));
    memset(pixels, 0, SIZE * SIZE * sizeof *pixels);
    struct shadow_memory memory;
    direct_forget(&memory);
    for (int i = 0; i < SIZE * SIZE; i++) cached_pixel(&cached, i % SIZE, i / SIZE, 2, 9, &memory, &pixels[i]);
    cached_free(&cached);
}

static char *slurp(size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *bytes = malloc(1 << 20);
    *size = fread(bytes, 1, 1 << 20, file);
    assert_in_range(*size, 1000, (1 << 20) - 1);
    fclose(file);
    return bytes;
}

static void spill(const char *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

static void comes_back_as_it_was(void **state)
{
    (void)state;
    struct stage *s = new_scene();
    struct model model = build(s);
    struct fill fill = new_fill(), loaded;
    struct pixel before[SIZE * SIZE], after[SIZE * SIZE];
    struct cache_file_change change;
    char error[SCENE_ERROR];
    draw(&model, &fill, before);
    assert_true(before[SIZE * SIZE / 2].indirect.x > 0 && before[SIZE * SIZE / 2].eas_count > 0);
    assert_true(cache_file_write(path, HASH, &s->scene, &fill, error));
    assert_true(cache_file_read(path, HASH, &s->scene, &options, &loaded, &change, error));
    assert_false(change.camera || change.materials);
    draw(&model, &loaded, after);
    assert_memory_equal(before, after, sizeof before);
    size_t size, size_again;
    char *bytes = slurp(&size), *again;
    assert_true(cache_file_write(path, HASH, &s->scene, &loaded, error));
    again = slurp(&size_again);
    assert_int_equal(size, size_again);
    assert_memory_equal(bytes, again, size);
    free(bytes);
    free(again);
    fill_free(&fill);
    fill_free(&loaded);
    remove(path);
    end(s, &model);
}

static void refuse(uint64_t hash, struct fill_options asked, const struct stage *s, const char *words)
{
    struct fill fill;
    struct cache_file_change change;
    char error[SCENE_ERROR];
    assert_false(cache_file_read(path, hash, &s->scene, &asked, &fill, &change, error));
    if (strncmp(error, path, sizeof path - 1) != 0 || !strstr(error, words))
        fail_msg("\"%s\", expected \"%s\"", error, words);
    assert_null(fill.glossy.records);
}

static void says_what_differs(void **state)
{
    (void)state;
    struct stage *s = new_scene();
    struct fill fill = new_fill(), loaded;
    struct cache_file_change change;
    char error[SCENE_ERROR];
    assert_true(cache_file_write(path, HASH, &s->scene, &fill, error));
    refuse(HASH + 1, options, s, "another scene");
    refuse(HASH, (struct fill_options){.kind = FILL_DIFFUSE, .seed = 3}, s, "made with --method eas, expected hybrid");
    refuse(HASH, (struct fill_options){.kind = FILL_EAS, .lamps = true, .seed = 3}, s,
           "--records indirect, expected all");
    refuse(HASH, (struct fill_options){.kind = FILL_EAS, .seed = 4}, s, "--seed 3, expected 4");

    s->scene.camera.transform[3] += 1;
    s->materials[0].closures->exponent.value = 59;
    assert_true(cache_file_read(path, HASH, &s->scene, &options, &loaded, &change, error));
    assert_true(change.camera && change.materials && strstr(change.stale, "exponent of material 'Gloss': light"));
    assert_null(strstr(change.stale, "coarse"));
    fill_free(&loaded);
    s->materials[0].closures->exponent.value = 61;
    assert_true(cache_file_read(path, HASH, &s->scene, &options, &loaded, &change, error));
    assert_non_null(strstr(change.stale, "coarse"));
    fill_free(&loaded);

    size_t size;
    char *bytes = slurp(&size);
    spill("nothing", 7);
    refuse(HASH, options, s, "no cache");
    bytes[12] ^= 3; /* the version */
    spill(bytes, size);
    refuse(HASH, options, s, "version 0 of the format, expected 3");
    for (int i = 8; i < 10; i++) { /* the byte order */
        char swap = bytes[i];
        bytes[i] = bytes[19 - i];
        bytes[19 - i] = swap;
    }
    spill(bytes, size);
    refuse(HASH, options, s, "byte order");
    remove(path);
    refuse(HASH, options, s, "cannot be read");
    free(bytes);
    fill_free(&fill);
    free(s);
}

/* Writes so many bytes with a checksum that fits. */
static void spill_sealed(char *bytes, size_t size)
{
    uint64_t checksum = scene_hash_bytes(0, bytes, size - sizeof checksum);
    memcpy(bytes + size - sizeof checksum, &checksum, sizeof checksum);
    spill(bytes, size);
}

/* The one place in the file that holds these four bytes. */
static size_t place_of(const char *bytes, size_t size, const void *word)
{
    size_t found = 0;
    for (size_t at = 0; at + 12 <= size; at += 4)
        if (memcmp(bytes + at, word, 4) == 0) {
            assert_true(!found);
            found = at;
        }
    assert_true(found);
    return found;
}

/* Numbers that stand in one place of the file each, and what may not stand there, whatever the checksum says. */
static void refuses_what_cannot_be(void **state)
{
    (void)state;
    struct stage *s = new_scene();
    struct fill fill = new_fill(), loaded;
    struct cache_file_change change;
    char error[SCENE_ERROR];
    struct zone *zone = &fill.glossy.zones.zones[7];
    struct record *record = &fill.glossy.records[8];
    struct eas *near = &fill.glossy.eas[10], *far = &fill.glossy.eas[12];
    struct caustics *caustics = &fill.bounced.caustics;
    fill.diffuse.zones.stretch = 1.25f;
    *zone = (struct zone){{.123f, .2f, -2}, {.28f, .96f, 0}, .321f};
    fill.bounced.e[4].y = .543f;
    record->first_eas = 83;
    record->eas_count = 391;
    record->irradiance.translation[2].y = .765f;
    record->first_hsh = 17;
    record->hsh_order = 4; /* 144 floats */
    fill.glossy.hsh[30] = .654f;
    near->area = .111f;
    near->radiance.y = 2.22f;
    far->position = vec3(0, .352f, .936f);
    far->area = .333f;
    far->normal.y = -.0f; /* the one such word */
    caustics->photons[9] = (struct photon){{.567f, 0, -2}, {0, .6f, .8f}, {1, .789f, 1}};
    caustics->reach = .456f;
    assert_true(!near->infinite && far->infinite);
    assert_true(cache_file_write(path, HASH, &s->scene, &fill, error));
    size_t size;
    char *bytes = slurp(&size);
    const struct {
        float was, now;
    } floats[] = {{1.25f, .9f},   {1.25f, 5},    {1.25f, NAN},     {.123f, INFINITY}, {.123f, 1e16f}, {.28f, .5f},
                  {.321f, 0},     {.321f, -.3f}, {.321f, 1.5e-8f}, {.321f, 1e10f},    {.321f, NAN},   {.543f, NAN},
                  {.765f, 1e20f}, {.111f, -.1f}, {.111f, NAN},     {2.22f, INFINITY}, {.352f, .5f},   {.333f, 6.4f},
                  {.936f, 1e30f}, {-.0f, 1},     {.654f, NAN},  {.567f, INFINITY}, {.6f, .7f},
                  {.789f, NAN},   {.456f, 0},    {.456f, NAN},    {.456f, 1e10f}};
    const struct {
        uint32_t was, now;
    } words[] = {{391, 418}, {391, UINT32_MAX}, {83, 110}, {83, UINT32_MAX}, {17, 18}, {17, UINT32_MAX},
                 {4, 5},     {4, UINT32_MAX},   {4, 1000}};
    const int float_count = sizeof floats / sizeof *floats, word_count = sizeof words / sizeof *words;
    for (int i = 0; i < float_count + word_count; i++) {
        const void *was = i < float_count ? (const void *)&floats[i].was : &words[i - float_count].was;
        const void *now = i < float_count ? (const void *)&floats[i].now : &words[i - float_count].now;
        size_t at = place_of(bytes, size, was);
        memcpy(bytes + at, now, 4);
        spill_sealed(bytes, size);
        if (cache_file_read(path, HASH, &s->scene, &options, &loaded, &change, error)) fail_msg("case %d is read", i);
        assert_true(strstr(error, "damaged") && !loaded.glossy.records && !loaded.bounced.e && !loaded.tables);
        memcpy(bytes + at, was, 4);
    }
    const uint32_t last = 417, was = 391;
    memcpy(bytes + place_of(bytes, size, &was), &last, 4);
    spill_sealed(bytes, size);
    assert_true(cache_file_read(path, HASH, &s->scene, &options, &loaded, &change, error));
    fill_free(&loaded);
    /* No word of the arrays may have all bits set: no number, no index, no flag. */
    for (size_t at = size / 4 * 4 - 12; at > 256; at -= at > 4 * 97 ? 4 * 97 : at) {
        uint32_t kept, ones = UINT32_MAX;
        memcpy(&kept, bytes + at, 4);
        memcpy(bytes + at, &ones, 4);
        spill_sealed(bytes, size);
        if (cache_file_read(path, HASH, &s->scene, &options, &loaded, &change, error)) fail_msg("byte %zu is read", at);
        memcpy(bytes + at, &kept, 4);
    }
    free(bytes);
    fill_free(&fill);
    remove(path);
    free(s);
}

/* Writes something somewhere; a third of the places are in the header. */
static void mutate(char *bytes, size_t size, struct rng *rng)
{
    const float values[] = {0, -1, 1e-30f, 1e30f, INFINITY, NAN, 3, -1e12f};
    size_t at = rng_uint(rng) % (rng_uint(rng) % 3 ? size - 12 : 160);
    switch (rng_uint(rng) % 3) {
    case 0: bytes[at] = (char)(bytes[at] ^ (1 << rng_uint(rng) % 8)); return;
    case 1: memcpy(bytes + at / 4 * 4, &values[rng_uint(rng) % 8], 4); return;
    default: memset(bytes + at / 4 * 4, rng_uint(rng) % 2 ? 255 : 0, 4); return;
    }
}

/* Without a new checksum each change is found. With one, a file that was changed or cut short is refused, or a picture
 * can be drawn from it. */
static void survives_any_bytes(void **state)
{
    (void)state;
    enum { MUTATIONS = 400 };
    struct stage *s = new_scene();
    struct model model = build(s);
    struct fill fill = new_fill(), loaded;
    struct cache_file_change change;
    struct pixel pixels[SIZE * SIZE];
    struct rng rng = rng_seed(5, 6, 7);
    char error[SCENE_ERROR];
    assert_true(cache_file_write(path, HASH, &s->scene, &fill, error));
    size_t size;
    char *bytes = slurp(&size), *copy = malloc(size);
    int used = 0, refused = 0;
    for (int i = 0; i < MUTATIONS; i++) {
        bool sealed = i % 3 == 0;
        memcpy(copy, bytes, size);
        size_t kept = i % 5 ? size : rng_uint(&rng) % size;
        for (int k = 0; k <= i % 2; k++) mutate(copy, size, &rng);
        if (sealed && kept > 8) spill_sealed(copy, kept);
        else spill(copy, kept);
        bool read = cache_file_read(path, HASH, &s->scene, &options, &loaded, &change, error);
        if (read && !sealed && memcmp(copy, bytes, size) != 0) fail_msg("mutation %d wasn't noticed", i);
        if (read) {
            draw(&model, &loaded, pixels);
            fill_free(&loaded);
            used++;
        } else {
            assert_true(strncmp(error, path, sizeof path - 1) == 0 && strlen(error) > sizeof path);
            refused += sealed;
        }
    }
    assert_true(used > 10 && refused > 50);
    free(bytes);
    free(copy);
    fill_free(&fill);
    remove(path);
    end(s, &model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(comes_back_as_it_was), cmocka_unit_test(says_what_differs),
                                       cmocka_unit_test(refuses_what_cannot_be), cmocka_unit_test(survives_any_bytes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
