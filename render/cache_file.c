/* SPDX-License-Identifier: Apache-2.0 */
#include "render/cache_file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "import/scene_hash.h"
#include "render/image.h"

/* VERSION rises with every change of what the file holds or of what it means, that of records included. */
enum { VERSION = 3, BYTE_ORDER_MARK = 0x01020304, BYTE_ORDER_SWAPPED = 0x04030201 };
static const char magic[8] = "BURNISHC";

/* What --method calls each kind. */
enum { KINDS = 4 };
static const char *const kinds[KINDS] = {
    [FILL_DIFFUSE] = "hybrid", [FILL_EAS] = "eas", [FILL_HSH] = "hsh", [FILL_NONE] = "gather"};

/* The caches of struct fill. */
enum { BOUNCED, DIFFUSE, GLOSSY, CACHES };

struct header {
    char magic[8];
    uint32_t byte_order, version;
    uint64_t scene, seed;
    uint32_t kind, lamps, surfaces, closure_count;
    struct scene_camera camera;
    float stretch[CACHES];
    uint32_t zones[CACHES], eas_count, hsh_count, photon_count;
    float reach;
};
static_assert(sizeof(struct header) == 184, "no padding");

/* What --set may have changed of a closure. */
struct property {
    float exponent, roughness;
    int exponent_texture, roughness_texture;
};
static_assert(sizeof(struct property) == 16 && sizeof(struct zone) == 28 && sizeof(rgb) == 12, "no padding");

static struct property property_of(const struct scene_closure *closure)
{
    return (struct property){closure->exponent.value, closure->roughness.value, closure->exponent.texture,
                             closure->roughness.texture};
}

static uint32_t count_closures(const struct scene *scene)
{
    uint32_t count = 0;
    for (int i = 0; i < scene->material_count; i++) count += (uint32_t)scene->materials[i].closure_count;
    return count;
}

/* All but the checksum at the end. */
static uint64_t bytes_before_checksum(const struct header *header)
{
    const uint32_t *zones = header->zones;
    return sizeof *header + (uint64_t)header->closure_count * sizeof(struct property) +
           (uint64_t)zones[BOUNCED] * (sizeof(struct zone) + sizeof(rgb)) +
           ((uint64_t)zones[DIFFUSE] + zones[GLOSSY]) * (sizeof(struct zone) + sizeof(struct record)) +
           (uint64_t)header->eas_count * sizeof(struct eas) + (uint64_t)header->hsh_count * sizeof(float) +
           (uint64_t)header->photon_count * sizeof(struct photon);
}

static void put(char **to, const void *from, size_t bytes)
{
    if (bytes) memcpy(*to, from, bytes);
    *to += bytes;
}

static void put_records(char **to, const struct record_cache *cache)
{
    put(to, cache->zones.zones, cache->zones.count * sizeof *cache->zones.zones);
    put(to, cache->records, cache->zones.count * sizeof *cache->records);
    put(to, cache->eas, cache->eas_count * sizeof *cache->eas);
    put(to, cache->hsh, cache->hsh_count * sizeof *cache->hsh);
}

/* The file's bytes, for the caller to free. NULL: no memory. */
static char *assemble(const struct header *header, const struct scene *scene, const struct fill *fill, size_t *size)
{
    uint64_t checked = bytes_before_checksum(header), checksum;
    char *bytes = malloc(checked + sizeof checksum), *to = bytes;
    if (!bytes) return NULL;
    put(&to, header, sizeof *header);
    for (int i = 0; i < scene->material_count; i++)
        for (int k = 0; k < scene->materials[i].closure_count; k++) {
            struct property property = property_of(&scene->materials[i].closures[k]);
            put(&to, &property, sizeof property);
        }
    put(&to, fill->bounced.zones.zones, fill->bounced.zones.count * sizeof *fill->bounced.zones.zones);
    put(&to, fill->bounced.e, fill->bounced.zones.count * sizeof *fill->bounced.e);
    put_records(&to, &fill->diffuse);
    put_records(&to, &fill->glossy);
    put(&to, fill->bounced.caustics.photons, fill->bounced.caustics.count * sizeof *fill->bounced.caustics.photons);
    checksum = scene_hash_bytes(0, bytes, checked);
    put(&to, &checksum, sizeof checksum);
    *size = checked + sizeof checksum;
    return bytes;
}

bool cache_file_write(const char *path, uint64_t hash, const struct scene *scene, const struct fill *fill,
                      char error[static SCENE_ERROR])
{
    struct header header = {
        .byte_order = BYTE_ORDER_MARK,
        .version = VERSION,
        .scene = hash,
        .seed = fill->options.seed,
        .kind = fill->options.kind,
        .lamps = fill->options.lamps,
        .surfaces = fill->options.surfaces,
        .closure_count = count_closures(scene),
        .camera = scene->camera,
        .stretch = {fill->bounced.zones.stretch, fill->diffuse.zones.stretch, fill->glossy.zones.stretch},
        .zones = {fill->bounced.zones.count, fill->diffuse.zones.count, fill->glossy.zones.count},
        .eas_count = fill->glossy.eas_count,
        .hsh_count = fill->glossy.hsh_count,
        .photon_count = fill->bounced.caustics.count,
        .reach = fill->bounced.caustics.reach};
    memcpy(header.magic, magic, sizeof magic);
    char name[PATH_MAX];
    size_t size;
    char *bytes = assemble(&header, scene, fill, &size);
    if (!bytes || !image_temporary(path, name, sizeof name)) {
        snprintf(error, SCENE_ERROR, "%.400s: %s", path, bytes ? "the name is too long" : "out of memory");
        free(bytes);
        return false;
    }
    FILE *file = fopen(name, "wb");
    bool done = file && fwrite(bytes, 1, size, file) == size;
    if (file && fclose(file) != 0) done = false;
    done = done && rename(name, path) == 0;
    if (!done) {
        snprintf(error, SCENE_ERROR, "%.400s: cannot be written: %s", path, strerror(errno));
        unlink(name);
    }
    free(bytes);
    return done;
}

/* The whole file, for the caller to free. NULL and a sentence where it can't be read. */
static char *load(const char *path, size_t *size, char error[static SCENE_ERROR])
{
    FILE *file = fopen(path, "rb");
    struct stat status;
    char *bytes = NULL;
    if (!file || fstat(fileno(file), &status)) {
        snprintf(error, SCENE_ERROR, "%.400s: cannot be read: %s", path, strerror(errno));
    } else if (!S_ISREG(status.st_mode)) {
        snprintf(error, SCENE_ERROR, "%.400s: is no file", path);
    } else if (!(bytes = malloc((size_t)status.st_size + 1))) {
        snprintf(error, SCENE_ERROR, "%.400s: out of memory", path);
    } else {
        *size = fread(bytes, 1, (size_t)status.st_size, file);
    }
    if (file) fclose(file);
    return bytes;
}

/* NULL where the bytes are those that were written, and for such a scene and such options; else what is wrong, some of
 * it in `found`. */
static const char *check_header(const char *bytes, size_t size, uint64_t hash, const struct scene *scene,
                                const struct fill_options *options, struct header *header, char found[static 256])
{
    if (size < sizeof *header || memcmp(bytes, magic, sizeof magic) != 0) return "is no cache of burnish";
    memcpy(header, bytes, sizeof *header);
    if (header->byte_order == BYTE_ORDER_SWAPPED) return "was written on a machine of the other byte order";
    if (header->version != VERSION) {
        snprintf(found, 256, "has version %u of the format, expected %d: remove it, and it is made again",
                 header->version, VERSION);
        return found;
    }
    uint64_t checked = bytes_before_checksum(header), checksum;
    if (size != checked + sizeof checksum) {
        snprintf(found, 256, "is damaged: found %zu bytes, expected %llu", size,
                 (unsigned long long)(checked + sizeof checksum));
        return found;
    }
    memcpy(&checksum, bytes + checked, sizeof checksum);
    if (header->byte_order != BYTE_ORDER_MARK || checksum != scene_hash_bytes(0, bytes, checked))
        return "is damaged: its checksum does not fit";
    if (header->scene != hash || header->closure_count != count_closures(scene))
        return "belongs to another scene, or to this one before it was changed";
    if (header->kind != options->kind) {
        snprintf(found, 256, "was made with --method %s, expected %s", kinds[header->kind < KINDS ? header->kind : 0],
                 kinds[options->kind]);
        return found;
    }
    if (header->lamps != options->lamps)
        return options->lamps ? "was made with --records indirect, expected all"
                              : "was made with --records all, expected indirect";
    if (header->surfaces != options->surfaces)
        return options->surfaces ? "was made with --fill camera, expected surfaces"
                                 : "was made with --fill surfaces, expected camera";
    snprintf(found, 256, "was made with --seed %llu, expected %llu", (unsigned long long)header->seed,
             (unsigned long long)options->seed);
    return header->seed == options->seed ? NULL : found;
}

/* Numbers whose squares are finite. */
static bool are_sane(const float *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!(fabsf(numbers[i]) < 1e15f)) return false;
    return true;
}

static bool is_unit(float3 n) { return fabsf(dot(n, n) - 1) < 1e-3f; }

/* A zone smaller than its place is exact, or beyond all measure, has no place in the index. */
static bool are_zones(const struct zone *zones, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct zone *z = &zones[i];
        float far = maxf(maxf(fabsf(z->p.x), fabsf(z->p.y)), fabsf(z->p.z));
        if (!are_sane(&z->p.x, 7) || !is_unit(z->n) ||
            !(z->radius > far * 1e-8f && z->radius > 1e-9f && z->radius < 1e9f))
            return false;
    }
    return true;
}

static bool are_records(const struct record_cache *cache)
{
    for (uint32_t i = 0; i < cache->zones.count; i++) {
        const struct record *record = &cache->records[i];
        if (!are_sane(&record->irradiance.e.x, sizeof record->irradiance / sizeof(float)) ||
            (uint64_t)record->first_eas + record->eas_count > cache->eas_count || record->hsh_order < 0 ||
            record->hsh_order > HARMONICS_ORDER ||
            (uint64_t)record->first_hsh + hsh_floats(record->hsh_order) > cache->hsh_count)
            return false;
    }
    for (uint32_t i = 0; i < cache->eas_count; i++) {
        const struct eas *eas = &cache->eas[i];
        if (!are_sane(&eas->position.x, offsetof(struct eas, infinite) / sizeof(float)) || eas->area < 0 ||
            eas->infinite > 1 || !is_unit(eas->infinite ? eas->position : eas->normal) ||
            (eas->infinite && (eas->area > 2.001f * PI || dot(eas->normal, eas->normal) > 0)))
            return false;
    }
    return are_sane(cache->hsh, cache->hsh_count);
}

static bool are_photons(const struct caustics *caustics)
{
    for (uint32_t i = 0; i < caustics->count; i++)
        if (!are_sane(&caustics->photons[i].p.x, sizeof(struct photon) / sizeof(float)) ||
            !is_unit(caustics->photons[i].n))
            return false;
    return !caustics->count || (caustics->reach > 1e-9f && caustics->reach < 1e9f);
}

/* A copy of the next bytes, at least one so that it isn't NULL; NULL: no memory. */
static void *take(const char **from, uint64_t count, size_t size)
{
    void *copy = malloc(count * size + 1);
    if (copy) memcpy(copy, *from, count * size);
    *from += count * size;
    return copy;
}

static void take_zones(const char **from, const struct header *header, int which, struct cache *cache)
{
    *cache = cache_empty(header->stretch[which]);
    cache->zones = take(from, header->zones[which], sizeof *cache->zones);
    cache->count = cache->capacity = header->zones[which];
}

static void take_records(const char **from, const struct header *header, int which, struct record_cache *cache)
{
    take_zones(from, header, which, &cache->zones);
    cache->records = take(from, cache->zones.count, sizeof *cache->records);
    cache->record_capacity = cache->zones.count;
    cache->eas_count = cache->eas_capacity = which == GLOSSY ? header->eas_count : 0;
    cache->eas = take(from, cache->eas_count, sizeof *cache->eas);
    cache->hsh_count = cache->hsh_capacity = which == GLOSSY ? header->hsh_count : 0;
    cache->hsh = take(from, cache->hsh_count, sizeof *cache->hsh);
}

/* NULL, or what is wrong. */
static const char *take_all(const char *from, const struct header *header, const struct scene *scene, struct fill *fill)
{
    take_zones(&from, header, BOUNCED, &fill->bounced.zones);
    fill->bounced.e = take(&from, header->zones[BOUNCED], sizeof *fill->bounced.e);
    take_records(&from, header, DIFFUSE, &fill->diffuse);
    take_records(&from, header, GLOSSY, &fill->glossy);
    struct caustics *caustics = &fill->bounced.caustics;
    caustics->photons = take(&from, header->photon_count, sizeof *caustics->photons);
    caustics->count = header->photon_count;
    caustics->reach = header->reach;
    struct cache *caches[CACHES] = {&fill->bounced.zones, &fill->diffuse.zones, &fill->glossy.zones};
    bool room = fill->bounced.e && fill->diffuse.records && fill->diffuse.eas && fill->diffuse.hsh &&
                fill->glossy.records && fill->glossy.eas && fill->glossy.hsh && caustics->photons;
    for (int i = 0; i < CACHES; i++) room = room && caches[i]->zones;
    if (!room) return "out of memory";
    for (int i = 0; i < CACHES; i++)
        if (!are_zones(caches[i]->zones, caches[i]->count) || !(caches[i]->stretch >= 1 && caches[i]->stretch <= 4))
            return "is damaged: it holds a zone that can't be";
    if (!are_records(&fill->diffuse) || !are_records(&fill->glossy) ||
        !are_sane(&fill->bounced.e->x, 3 * (size_t)header->zones[BOUNCED]))
        return "is damaged: it holds a record that can't be";
    if (!are_photons(caustics)) return "is damaged: it holds a photon that can't be";
    if (caustics->count && !caustics_index(caustics)) return "out of memory";
    for (int i = 0; i < CACHES; i++)
        if (!cache_reindex(caches[i])) return "out of memory";
    return fill_tables(scene, fill) ? NULL : "out of memory";
}

/* What is stale where the properties of materials aren't those that the caches were made with. */
static void compare_materials(const char *properties, const struct scene *scene, struct cache_file_change *change)
{
    const char *name = NULL, *word = NULL;
    int count = 0;
    bool sharper = false;
    for (int i = 0; i < scene->material_count; i++) {
        const struct scene_material *material = &scene->materials[i];
        bool changed = false;
        for (int k = 0; k < material->closure_count; k++) {
            struct property was, is = property_of(&material->closures[k]);
            memcpy(&was, properties, sizeof was);
            properties += sizeof was;
            if (memcmp(&was, &is, sizeof was) == 0) continue;
            changed = true;
            sharper = sharper || is.exponent > was.exponent || is.roughness < was.roughness;
            if (!name) word = material->closures[k].type == CLOSURE_PHONG ? "exponent" : "roughness";
            name = name ? name : material->name;
        }
        count += changed;
    }
    change->materials = count > 0;
    if (!count) return;
    char others[64] = "";
    if (count > 1) snprintf(others, sizeof others, " and %d more", count - 1);
    snprintf(change->stale, sizeof change->stale,
             "was made at another %s of material '%.100s'%s: light that was reflected specularly there on its way to "
             "the records is stale%s",
             word, name, others,
             sharper ? ", and EAS are coarse where it is sharper now: make the cache at the sharpest" : "");
}

bool cache_file_read(const char *path, uint64_t hash, const struct scene *scene, const struct fill_options *options,
                     struct fill *fill, struct cache_file_change *change, char error[static SCENE_ERROR])
{
    size_t size;
    struct header header;
    char found[256];
    *fill = (struct fill){.options = *options};
    *change = (struct cache_file_change){0};
    char *bytes = load(path, &size, error);
    if (!bytes) return false;
    const char *wrong = check_header(bytes, size, hash, scene, options, &header, found);
    if (!wrong) {
        const char *properties = bytes + sizeof header;
        compare_materials(properties, scene, change);
        change->camera = memcmp(&header.camera, &scene->camera, sizeof header.camera) != 0;
        wrong = take_all(properties + header.closure_count * sizeof(struct property), &header, scene, fill);
    }
    if (wrong) {
        snprintf(error, SCENE_ERROR, "%.400s: %s", path, wrong);
        fill_free(fill);
    }
    free(bytes);
    return !wrong;
}
