/* SPDX-License-Identifier: Apache-2.0 */
#include "import/scene_hash.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

#include "import/json.h"

/* The document without what a cache may outlive, in one spelling. NULL: no memory. */
static char *spell(json_t *root)
{
    json_object_del(root, "camera");
    json_object_del(root, "notes");
    json_object_del(root, "generator");
    size_t i, k;
    json_t *material, *closure;
    json_array_foreach(json_object_get(root, "materials"), i, material)
    {
        json_array_foreach(json_object_get(material, "closures"), k, closure)
        {
            json_object_del(closure, "exponent");
            json_object_del(closure, "roughness");
        }
    }
    return json_dumps(root, JSON_COMPACT | JSON_SORT_KEYS);
}

static bool hash_file(const char *path, uint64_t *hash)
{
    enum { BLOCK = 1 << 16 };
    char *block = malloc(BLOCK);
    FILE *file = block ? fopen(path, "rb") : NULL;
    size_t count = 0;
    while (file && (count = fread(block, 1, BLOCK, file)) > 0) *hash = scene_hash_bytes(*hash, block, count);
    bool done = file && !ferror(file);
    if (file) fclose(file);
    free(block);
    return done;
}

bool scene_hash(const char *folder, const struct scene *scene, uint64_t *hash, char error[SCENE_ERROR])
{
    char path[4096];
    snprintf(path, sizeof path, "%s/scene.json", folder); /* scene_read found that it fits */
    struct json_file file;
    json_open(path, &file, error);
    char *text = file.failed ? NULL : spell(file.root);
    if (!file.failed && !text) snprintf(error, SCENE_ERROR, "%.200s: out of memory", path);
    bool done = text != NULL;
    if (done) {
        *hash = scene_hash_bytes(0, text, strlen(text));
        *hash = scene_hash_bytes(*hash, scene->buffer, scene->buffer_bytes);
    }
    for (int i = 0; done && i < scene->image_count; i++)
        if (!hash_file(scene->images[i].file, hash)) {
            snprintf(error, SCENE_ERROR, "%.400s cannot be read: %s", scene->images[i].file, strerror(errno));
            done = false;
        }
    free(text);
    json_close(&file);
    return done;
}
