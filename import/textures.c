/* SPDX-License-Identifier: Apache-2.0 */
#include "import/textures.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void read_images(struct json_node *root, const char *folder, struct scene *scene)
{
    static const char *const colour_spaces[] = {"srgb", "linear", "data", NULL};
    struct json_node list = json_get_list(root, "images");
    scene->images = json_new_array(&list, sizeof *scene->images, &scene->image_count);
    for (int i = 0; i < scene->image_count; i++) {
        struct json_node item = json_get_item(&list, i);
        char *name = json_get_text(&item, "file");
        scene->images[i].colour_space = json_get_word(&item, "colour_space", colour_spaces);
        json_end(&item);
        if (!name) return;
        char *path = malloc(strlen(folder) + strlen(name) + 2);
        scene->images[i].file = path;
        struct stat status;
        if (!path) json_fail(&item, NULL, "out of memory");
        else if (sprintf(path, "%s/%s", folder, name), stat(path, &status) || access(path, R_OK))
            json_fail(&item, "file", "%s cannot be read: %s", path, strerror(errno));
        else if (!S_ISREG(status.st_mode)) json_fail(&item, "file", "%s is not a file", path);
        free(name);
    }
}

/* The colours by angle of one side; their count has to be *count where it isn't 0 yet. */
static const float *read_side(struct json_node *at, const char *key, const struct buffer *buffer, uint32_t *count)
{
    uint32_t found;
    const float *colours = buffer_span(buffer, at, key, BUFFER_FLOAT3, NULL, &found);
    if (at->file->failed) return NULL;
    if (found < 2) json_fail(at, key, "found %u elements, expected 2 or more", found);
    if (*count && found != *count)
        json_fail(at, key, "found %u elements, expected %u: as many as front", found, *count);
    for (size_t i = 0; i < 3 * (size_t)found; i++)
        if (colours[i] < 0) json_fail(at, key, "element %zu holds %g, expected at least 0", i / 3, colours[i]);
    *count = found;
    return colours;
}

static void read_image_texture(struct json_node *at, const struct scene *scene, struct scene_texture *texture)
{
    static const char *const interpolations[] = {"linear", "closest", NULL};
    static const char *const extensions[] = {"repeat", "extend", "clip", "mirror", NULL};
    texture->image = json_get_index(at, "image", scene->image_count, "images");
    texture->interpolation = json_get_word(at, "interpolation", interpolations);
    texture->extension = json_get_word(at, "extension", extensions);
    if (!json_has(at, "channel")) return;
    json_get_word(at, "channel", (const char *const[]){"alpha", NULL});
    texture->alpha = true;
}

static void read_texture(struct json_node *at, const struct buffer *buffer, const struct scene *scene,
                         struct scene_texture *texture)
{
    static const char *const types[] = {"image", "checker", "angle", NULL};
    texture->type = json_get_word(at, "type", types);
    texture->image = SCENE_NONE;
    switch (texture->type) {
    case TEXTURE_IMAGE: read_image_texture(at, scene, texture); break;
    case TEXTURE_CHECKER:
        json_get_numbers(at, "colour1", 0, 3, texture->colour1);
        json_get_numbers(at, "colour2", 0, 3, texture->colour2);
        texture->scale = json_get_number(at, "scale", 1e-6, HUGE_VAL);
        break;
    case TEXTURE_ANGLE:
        texture->front = texture->back = read_side(at, "front", buffer, &texture->sample_count);
        if (json_has(at, "back")) texture->back = read_side(at, "back", buffer, &texture->sample_count);
        break;
    }
    if (texture->type != TEXTURE_ANGLE) json_get_numbers(at, "uv_transform", -HUGE_VAL, 6, texture->uv_transform);
    json_end(at);
}

void textures_read(struct json_node *root, const char *folder, const struct buffer *buffer, struct scene *scene)
{
    read_images(root, folder, scene);
    struct json_node list = json_get_list(root, "textures");
    scene->textures = json_new_array(&list, sizeof *scene->textures, &scene->texture_count);
    for (int i = 0; i < scene->texture_count; i++) {
        struct json_node item = json_get_item(&list, i);
        read_texture(&item, buffer, scene, &scene->textures[i]);
    }
}
