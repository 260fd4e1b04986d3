/* SPDX-License-Identifier: Apache-2.0 */
#include "import/materials.h"

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

static void read_textures(struct json_node *root, struct scene *scene)
{
    static const char *const types[] = {"image", "checker", NULL};
    static const char *const interpolations[] = {"linear", "closest", NULL};
    static const char *const extensions[] = {"repeat", "extend", "clip", NULL};
    struct json_node list = json_get_list(root, "textures");
    scene->textures = json_new_array(&list, sizeof *scene->textures, &scene->texture_count);
    for (int i = 0; i < scene->texture_count; i++) {
        struct scene_texture *texture = &scene->textures[i];
        struct json_node item = json_get_item(&list, i);
        texture->type = json_get_word(&item, "type", types);
        texture->image = SCENE_NONE;
        if (texture->type == TEXTURE_IMAGE) {
            texture->image = json_get_index(&item, "image", scene->image_count, "images");
            texture->interpolation = json_get_word(&item, "interpolation", interpolations);
            texture->extension = json_get_word(&item, "extension", extensions);
        } else {
            json_get_numbers(&item, "colour1", 0, 3, texture->colour1);
            json_get_numbers(&item, "colour2", 0, 3, texture->colour2);
            texture->scale = json_get_number(&item, "scale", 1e-6, HUGE_VAL);
        }
        json_get_numbers(&item, "uv_transform", -HUGE_VAL, 6, texture->uv_transform);
        json_end(&item);
    }
}

/* {"texture": i} */
static int read_texture_of(struct json_node *at, const char *key, const struct scene *scene)
{
    struct json_node object = json_get_object(at, key);
    int texture = json_get_index(&object, "texture", scene->texture_count, "textures");
    json_end(&object);
    return texture;
}

static struct scene_colour read_colour(struct json_node *at, const char *key, const struct scene *scene)
{
    struct scene_colour colour = {.texture = SCENE_NONE};
    if (json_has_object(at, key)) colour.texture = read_texture_of(at, key, scene);
    else json_get_numbers(at, key, 0, 3, colour.value);
    return colour;
}

static struct scene_scalar read_scalar(struct json_node *at, const char *key, double max, const struct scene *scene)
{
    struct scene_scalar scalar = {.texture = SCENE_NONE};
    if (json_has_object(at, key)) scalar.texture = read_texture_of(at, key, scene);
    else scalar.value = json_get_number(at, key, 0, max);
    return scalar;
}

static void read_materials(struct json_node *root, struct scene *scene)
{
    static const char *const types[] = {"diffuse", "phong", "principled", NULL};
    static const char *const sides[] = {"both", "front", NULL};
    struct json_node list = json_get_list(root, "materials");
    scene->materials = json_new_array(&list, sizeof *scene->materials, &scene->material_count);
    for (int i = 0; i < scene->material_count; i++) {
        struct scene_material *material = &scene->materials[i];
        struct json_node item = json_get_item(&list, i);
        material->name = json_get_text(&item, "name");
        material->type = json_get_word(&item, "type", types);
        material->ks.texture = material->exponent.texture = SCENE_NONE;
        material->metallic.texture = material->roughness.texture = SCENE_NONE;
        switch (material->type) {
        case MATERIAL_DIFFUSE: material->colour = read_colour(&item, "colour", scene); break;
        case MATERIAL_PHONG:
            material->colour = read_colour(&item, "kd", scene);
            material->ks = read_colour(&item, "ks", scene);
            material->exponent = read_scalar(&item, "exponent", HUGE_VAL, scene);
            break;
        case MATERIAL_PRINCIPLED:
            material->colour = read_colour(&item, "base_colour", scene);
            material->metallic = read_scalar(&item, "metallic", 1, scene);
            material->roughness = read_scalar(&item, "roughness", 1, scene);
            material->ior = json_get_number(&item, "ior", 1, HUGE_VAL);
            material->specular_level = json_get_number(&item, "specular_level", 0, HUGE_VAL);
            json_get_numbers(&item, "specular_tint", 0, 3, material->specular_tint);
            break;
        }
        if (json_has(&item, "emission")) json_get_numbers(&item, "emission", 0, 3, material->emission);
        if (json_has(&item, "emission_sides"))
            material->emission_front_only = json_get_word(&item, "emission_sides", sides);
        json_end(&item);
    }
}

void materials_read(struct json_node *root, const char *folder, struct scene *scene)
{
    read_images(root, folder, scene);
    read_textures(root, scene);
    read_materials(root, scene);
}
