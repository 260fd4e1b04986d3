/* SPDX-License-Identifier: Apache-2.0 */
#include "import/buffer.h"

#include <assert.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "scene.bin is little-endian and read as it stands");

static const char *const type_words[] = {"float", "float2", "float3", "uint", "uint2", NULL};
static const int type_numbers[] = {1, 2, 3, 1, 2};

/* Reads the whole file, which must have `bytes` bytes. */
static void read_bytes(const struct json_node *at, const char *path, size_t bytes, struct scene *scene)
{
    FILE *stream = fopen(path, "rb");
    struct stat status;
    if (!stream || fstat(fileno(stream), &status)) {
        json_fail(at, "file", "%s cannot be opened: %s", path, strerror(errno));
    } else if (!S_ISREG(status.st_mode)) {
        json_fail(at, "file", "%s is not a file", path);
    } else if ((size_t)status.st_size != bytes) {
        json_fail(at, "bytes",
                  "%s has %zu bytes, expected %zu: the file was cut short or belongs to another scene.json", path,
                  (size_t)status.st_size, bytes);
    } else if (!(scene->buffer = malloc(bytes + 1))) {
        json_fail(at, NULL, "out of memory");
    } else {
        scene->buffer_bytes = bytes;
        if (fread(scene->buffer, 1, bytes, stream) != bytes)
            json_fail(at, "file", "%s cannot be read: %s", path,
                      ferror(stream) ? strerror(errno) : "it became shorter");
    }
    if (stream) fclose(stream);
}

/* A size in bytes: exact up to 2^53, far beyond any file. */
static size_t get_bytes(struct json_node *at, const char *key)
{
    double number = json_get_number(at, key, 0, 9007199254740992.0);
    if (number != floor(number)) json_fail(at, key, "found %g, expected a whole number", number);
    return (size_t)number;
}

void buffer_read(struct json_node *root, const char *folder, struct scene *scene, struct buffer *buffer)
{
    *buffer = (struct buffer){0};
    struct json_node at = json_get_object(root, "buffer");
    char *file = json_get_text(&at, "file");
    size_t bytes = get_bytes(&at, "bytes");
    json_end(&at);
    if (!root->file->failed) {
        char path[4096];
        if (snprintf(path, sizeof path, "%s/%s", folder, file) >= (int)sizeof path)
            json_fail(&at, "file", "the path is longer than %zu bytes", sizeof path);
        else read_bytes(&at, path, bytes, scene);
    }
    free(file);
    buffer->bytes = scene->buffer;

    struct json_node list = json_get_list(root, "views");
    buffer->views = json_new_array(&list, sizeof *buffer->views, &buffer->view_count);
    for (int i = 0; i < buffer->view_count; i++) {
        struct buffer_view *view = &buffer->views[i];
        struct json_node item = json_get_item(&list, i);
        view->offset = get_bytes(&item, "offset");
        view->count = json_get_integer(&item, "count", 0, INT_MAX);
        view->type = json_get_word(&item, "type", type_words);
        json_end(&item);
        if (view->offset % 4) json_fail(&item, "offset", "found %zu, expected a multiple of 4", view->offset);
        size_t end = view->offset + (size_t)view->count * type_numbers[view->type] * 4;
        if (end > bytes) json_fail(&item, NULL, "ends at byte %zu, but the buffer has %zu", end, bytes);
    }
}

void buffer_free(struct buffer *buffer)
{
    free(buffer->views);
    *buffer = (struct buffer){0};
}

const void *buffer_span(const struct buffer *buffer, struct json_node *at, const char *key, enum buffer_type type,
                        const char *mesh, uint32_t *count)
{
    *count = 0;
    int index = json_get_index(at, key, buffer->view_count, "views");
    if (index == SCENE_NONE) return NULL;
    const struct buffer_view *view = &buffer->views[index];
    if (view->type != type) {
        json_fail(at, key, "view %d holds %s, expected %s", index, type_words[view->type], type_words[type]);
        return NULL;
    }
    const void *span = buffer->bytes + view->offset;
    if (type <= BUFFER_FLOAT3) {
        const float *numbers = span;
        size_t length = (size_t)view->count * type_numbers[type];
        for (size_t i = 0; i < length; i++)
            if (!isfinite(numbers[i])) {
                json_fail(at, key, "%s%s%selement %zu of view %d holds %g, expected finite numbers",
                          mesh ? "mesh \"" : "", mesh ? mesh : "", mesh ? "\": " : "", i / type_numbers[type], index,
                          numbers[i]);
                return NULL;
            }
    }
    *count = view->count;
    return span;
}
