/* SPDX-License-Identifier: Apache-2.0 */
#include "import/materials.h"

#include <math.h>
#include <stdlib.h>

static struct scene_colour grey(float value) { return (struct scene_colour){{value, value, value}, SCENE_NONE}; }
static struct scene_scalar constant(float value) { return (struct scene_scalar){value, SCENE_NONE}; }

struct scene_closure scene_closure_of(enum closure_type type)
{
    return (struct scene_closure){
        .type = type,
        .front = true,
        .back = true,
        .weight = grey(1),
        .colour = grey(0),
        .ks = grey(0),
        .specular_tint = grey(1),
        .coat_tint = grey(1),
        .sheen_tint = grey(1),
        .exponent = constant(0),
        .metallic = constant(0),
        .roughness = constant(0),
        .ior = constant(1.5f),
        .specular_level = constant(0.5f),
        .transmission = constant(0),
        .anisotropy = constant(0),
        .rotation = constant(0),
        .coat_weight = constant(0),
        .coat_roughness = constant(0),
        .coat_ior = constant(1.5f),
        .sheen_weight = constant(0),
        .sheen_roughness = constant(0),
        .distribution = type == CLOSURE_PRINCIPLED ? CLOSURE_MULTI_GGX : CLOSURE_GGX,
    };
}

bool scene_closure_has_roughness(enum closure_type type)
{
    return type == CLOSURE_GLOSSY || type == CLOSURE_PRINCIPLED || type == CLOSURE_SHEEN || type == CLOSURE_GLASS ||
           type == CLOSURE_REFRACTION;
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

static struct scene_scalar read_scalar(struct json_node *at, const char *key, double min, double max,
                                       const struct scene *scene)
{
    struct scene_scalar scalar = {.texture = SCENE_NONE};
    if (json_has_object(at, key)) scalar.texture = read_texture_of(at, key, scene);
    else scalar.value = json_get_number(at, key, min, max);
    return scalar;
}

/* What may be left out keeps its default. */
static void read_optional(struct json_node *at, const char *key, double min, double max, const struct scene *scene,
                          struct scene_scalar *scalar)
{
    if (json_has(at, key)) *scalar = read_scalar(at, key, min, max, scene);
}

static void read_anisotropy(struct json_node *at, const struct scene *scene, struct scene_closure *closure)
{
    read_optional(at, "anisotropy", -1, 1, scene, &closure->anisotropy);
    read_optional(at, "rotation", -HUGE_VAL, HUGE_VAL, scene, &closure->rotation);
}

static void read_layers(struct json_node *at, const struct scene *scene, struct scene_closure *closure)
{
    if (json_has(at, "coat")) {
        struct json_node coat = json_get_object(at, "coat");
        closure->coat_weight = read_scalar(&coat, "weight", 0, 1, scene);
        closure->coat_roughness = read_scalar(&coat, "roughness", 0, 1, scene);
        closure->coat_ior = read_scalar(&coat, "ior", 1, HUGE_VAL, scene);
        closure->coat_tint = read_colour(&coat, "tint", scene);
        json_end(&coat);
    }
    if (json_has(at, "sheen")) {
        struct json_node sheen = json_get_object(at, "sheen");
        closure->sheen_weight = read_scalar(&sheen, "weight", 0, 1, scene);
        closure->sheen_roughness = read_scalar(&sheen, "roughness", 0, 1, scene);
        closure->sheen_tint = read_colour(&sheen, "tint", scene);
        json_end(&sheen);
    }
}

static void read_principled(struct json_node *at, const struct scene *scene, struct scene_closure *closure)
{
    static const char *const distributions[] = {"ggx", "multi-ggx", NULL};
    closure->colour = read_colour(at, "base_colour", scene);
    closure->metallic = read_scalar(at, "metallic", 0, 1, scene);
    closure->ior = read_scalar(at, "ior", 1, HUGE_VAL, scene);
    closure->specular_level = read_scalar(at, "specular_level", 0, HUGE_VAL, scene);
    closure->specular_tint = read_colour(at, "specular_tint", scene);
    read_optional(at, "transmission", 0, 1, scene, &closure->transmission);
    read_anisotropy(at, scene, closure);
    read_layers(at, scene, closure);
    if (json_has(at, "distribution")) closure->distribution = json_get_word(at, "distribution", distributions);
}

static void read_closure(struct json_node *at, const struct scene *scene, struct scene_closure *closure)
{
    static const char *const types[] = {"diffuse", "phong",      "glossy",      "principled",  "sheen",
                                        "glass",   "refraction", "translucent", "transparent", NULL};
    static const char *const sides[] = {"both", "front", "back", NULL};
    static const char *const distributions[] = {"ggx", "multi-ggx", "beckmann", "ashikhmin-shirley", NULL};
    static const char *const of_glass[] = {"ggx", "multi-ggx", "beckmann", NULL};
    static const char *const of_refraction[] = {"ggx", "beckmann", NULL};
    *closure = scene_closure_of(json_get_word(at, "type", types));
    if (json_has(at, "weight")) closure->weight = read_colour(at, "weight", scene);
    if (json_has(at, "sides")) {
        int word = json_get_word(at, "sides", sides);
        closure->front = word != 2;
        closure->back = word != 1;
    }
    if (scene_closure_has_roughness(closure->type)) closure->roughness = read_scalar(at, "roughness", 0, 1, scene);
    if (closure->type != CLOSURE_PHONG && closure->type != CLOSURE_PRINCIPLED)
        closure->colour = read_colour(at, "colour", scene);
    switch (closure->type) {
    case CLOSURE_PHONG:
        closure->colour = read_colour(at, "kd", scene);
        closure->ks = read_colour(at, "ks", scene);
        closure->exponent = read_scalar(at, "exponent", 0, HUGE_VAL, scene);
        break;
    case CLOSURE_GLOSSY:
        closure->distribution = json_get_word(at, "distribution", distributions);
        read_anisotropy(at, scene, closure);
        break;
    case CLOSURE_PRINCIPLED: read_principled(at, scene, closure); break;
    case CLOSURE_GLASS:
        closure->ior = read_scalar(at, "ior", 0.1, HUGE_VAL, scene);
        closure->distribution = json_get_word(at, "distribution", of_glass);
        break;
    case CLOSURE_REFRACTION:
        closure->ior = read_scalar(at, "ior", 0.1, HUGE_VAL, scene);
        closure->distribution = json_get_word(at, "distribution", of_refraction) ? CLOSURE_BECKMANN : CLOSURE_GGX;
        break;
    case CLOSURE_DIFFUSE: read_optional(at, "roughness", 0, 1, scene, &closure->roughness); break;
    case CLOSURE_SHEEN:
    case CLOSURE_TRANSLUCENT:
    case CLOSURE_TRANSPARENT: break;
    }
    json_end(at);
}

static void read_closures(struct json_node *at, const struct scene *scene, struct scene_material *material)
{
    struct json_node list = json_get_list(at, "closures");
    material->closures = json_new_array(&list, sizeof *material->closures, &material->closure_count);
    for (int i = 0; i < material->closure_count; i++) {
        struct json_node item = json_get_item(&list, i);
        read_closure(&item, scene, &material->closures[i]);
    }
}

static void read_normal(struct json_node *at, const struct scene *scene, struct scene_normal *normal)
{
    struct json_node object = json_get_object(at, "normal");
    const char *key = json_has(&object, "height") ? "height" : "map";
    normal->type = key[0] == 'h' ? NORMAL_HEIGHT : NORMAL_MAP;
    normal->texture = json_get_index(&object, key, scene->texture_count, "textures");
    normal->strength = json_get_number(&object, "strength", 0, HUGE_VAL);
    if (normal->type == NORMAL_HEIGHT) {
        normal->distance = json_get_number(&object, "distance", 0, HUGE_VAL);
        normal->filter = json_has(&object, "filter") ? json_get_number(&object, "filter", 0, HUGE_VAL) : 0.1f;
        normal->invert = json_has(&object, "invert") && json_get_bool(&object, "invert");
    }
    json_end(&object);
    if (normal->texture != SCENE_NONE && scene->textures[normal->texture].type == TEXTURE_ANGLE)
        json_fail(&object, key, "texture %d goes by angle, expected an image or a checker", normal->texture);
}

void materials_read(struct json_node *root, struct scene *scene)
{
    static const char *const sides[] = {"both", "front", "back", NULL};
    struct json_node list = json_get_list(root, "materials");
    scene->materials = json_new_array(&list, sizeof *scene->materials, &scene->material_count);
    for (int i = 0; i < scene->material_count; i++) {
        struct scene_material *material = &scene->materials[i];
        struct json_node item = json_get_item(&list, i);
        material->name = json_get_text(&item, "name");
        if (json_has(&item, "closures")) read_closures(&item, scene, material);
        material->emission = grey(0);
        if (json_has(&item, "emission")) material->emission = read_colour(&item, "emission", scene);
        int word = json_has(&item, "emission_sides") ? json_get_word(&item, "emission_sides", sides) : 0;
        material->emission_front = word != 2;
        material->emission_back = word != 1;
        material->normal.texture = SCENE_NONE;
        if (json_has(&item, "normal")) read_normal(&item, scene, &material->normal);
        json_end(&item);
    }
}
