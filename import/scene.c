/* SPDX-License-Identifier: Apache-2.0 */
#include "import/scene.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "import/buffer.h"
#include "import/json.h"
#include "import/materials.h"
#include "import/meshes.h"
#include "import/textures.h"

#define SCENE_VERSION 1
#define PI 3.14159265358979323846

/* The largest angle that is let through as pi: Blender's own is a float just above it. */
#define PI_ABOVE 3.1415928

static void read_heading(struct json_node *root)
{
    json_get_word(root, "format", (const char *const[]){"burnish-scene", NULL});
    int version = json_get_integer(root, "version", 1, 1000000);
    if (version > SCENE_VERSION)
        json_fail(root, "version", "found %d, expected at most %d: the scene is newer than this program", version,
                  SCENE_VERSION);
    free(json_get_text(root, "generator"));
    json_get_word(root, "units", (const char *const[]){"metre", NULL});
    json_get_word(root, "up", (const char *const[]){"z", NULL});
    json_get_word(root, "colour_space", (const char *const[]){"linear-rec709", NULL});
}

/* 12 numbers whose 3 x 3 part can be inverted, however large or small its axes. */
static void read_transform(struct json_node *at, float transform[static 12])
{
    json_get_numbers(at, "transform", -HUGE_VAL, 12, transform);
    double m[3][3], volume = 1;
    for (int column = 0; column < 3; column++) {
        double length = 0;
        for (int row = 0; row < 3; row++) {
            m[row][column] = transform[4 * row + column];
            length += m[row][column] * m[row][column];
        }
        volume *= sqrt(length);
    }
    double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    if (!(fabs(determinant) > 1e-6 * volume))
        json_fail(at, "transform", "determinant %g, expected other than 0: the transform flattens space", determinant);
}

/* Longitudes go once round at most, latitudes from pole to pole. */
static void check_panorama(struct json_node *at, float window[static 4])
{
    if (window[1] - window[0] > 2 * PI_ABOVE || window[2] < -PI_ABOVE / 2 || window[3] > PI_ABOVE / 2)
        json_fail(at, "window", "found [%g, %g, %g, %g], expected at most once round and latitudes from -pi/2 to pi/2",
                  window[0], window[1], window[2], window[3]);
    window[2] = fmaxf(window[2], -PI / 2);
    window[3] = fminf(window[3], PI / 2);
}

static void read_lens(struct json_node *at, struct scene_lens *lens)
{
    struct json_node object = json_get_object(at, "lens");
    lens->radius = json_get_number(&object, "radius", 0, HUGE_VAL);
    lens->focus = json_get_number(&object, "focus", 1e-6, HUGE_VAL);
    lens->blades = json_get_integer(&object, "blades", 0, 1000);
    lens->rotation = json_get_number(&object, "rotation", -HUGE_VAL, HUGE_VAL);
    lens->ratio = json_get_number(&object, "ratio", 1e-3, 1e3);
    if (lens->blades == 1 || lens->blades == 2)
        json_fail(&object, "blades", "found %d, expected 0 or at least 3", lens->blades);
    json_end(&object);
}

static void read_camera(struct json_node *root, struct scene_camera *camera)
{
    static const char *const types[] = {"perspective", "orthographic", "panoramic", NULL};
    struct json_node at = json_get_object(root, "camera");
    camera->type = json_get_word(&at, "type", types);
    read_transform(&at, camera->transform);
    json_get_numbers(&at, "window", -HUGE_VAL, 4, camera->window);
    const float *window = camera->window;
    if (camera->type == CAMERA_PANORAMIC) check_panorama(&at, camera->window);
    if (!(window[0] < window[1]) || !(window[2] < window[3]))
        json_fail(&at, "window", "found [%g, %g, %g, %g], expected left < right and bottom < top", window[0], window[1],
                  window[2], window[3]);
    float resolution[2];
    json_get_numbers(&at, "resolution", 1, 2, resolution);
    for (int i = 0; i < 2; i++)
        if (resolution[i] > 65536 || resolution[i] != floorf(resolution[i]))
            json_fail(&at, "resolution", "found %g, expected whole numbers from 1 to 65536", resolution[i]);
    if (camera->type == CAMERA_PERSPECTIVE && json_has(&at, "lens")) read_lens(&at, &camera->lens);
    if (at.file->failed) return;
    camera->width = (int)resolution[0];
    camera->height = (int)resolution[1];
    json_end(&at);
}

static void read_world(struct json_node *root, struct scene *scene)
{
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    struct scene_world *world = &scene->world;
    world->texture = SCENE_NONE;
    memcpy(world->transform, identity, sizeof identity);
    if (!json_has(root, "world")) return;
    struct json_node at = json_get_object(root, "world");
    json_get_numbers(&at, "radiance", 0, 3, world->radiance);
    if (json_has(&at, "texture")) {
        world->texture = json_get_index(&at, "texture", scene->texture_count, "textures");
        if (world->texture != SCENE_NONE && scene->textures[world->texture].type != TEXTURE_IMAGE)
            json_fail(&at, "texture", "texture %d is no image, expected one", world->texture);
    }
    if (json_has(&at, "transform")) read_transform(&at, world->transform);
    json_end(&at);
}

static bool read_flag(struct json_node *at, const char *key, bool absent)
{
    return json_has(at, key) ? json_get_bool(at, key) : absent;
}

static void read_objects(struct json_node *root, struct scene *scene)
{
    struct json_node list = json_get_list(root, "objects");
    scene->objects = json_new_array(&list, sizeof *scene->objects, &scene->object_count);
    uint32_t *top_slots = calloc(scene->mesh_count + 1, sizeof *top_slots);
    if (!top_slots) json_fail(&list, NULL, "out of memory");
    for (int i = 0; top_slots && i < scene->mesh_count && !root->file->failed; i++)
        top_slots[i] = meshes_top_slot(&scene->meshes[i]);
    for (int i = 0; i < scene->object_count; i++) {
        struct scene_object *object = &scene->objects[i];
        struct json_node item = json_get_item(&list, i);
        object->name = json_get_text(&item, "name");
        object->mesh = json_get_index(&item, "mesh", scene->mesh_count, "meshes");
        object->materials =
            json_get_indices(&item, "materials", scene->material_count, "materials", &object->slot_count);
        read_transform(&item, object->transform);
        object->hidden = !read_flag(&item, "camera", true);
        object->shadowless = !read_flag(&item, "shadow", true);
        json_end(&item);
        if (root->file->failed) break;
        if (object->slot_count && top_slots[object->mesh] >= object->slot_count)
            json_fail(&item, "materials", "found %u, expected %u: a face of mesh \"%s\" uses slot %u",
                      object->slot_count, top_slots[object->mesh] + 1, scene->meshes[object->mesh].name,
                      top_slots[object->mesh]);
    }
    free(top_slots);
}

static float read_angle(struct json_node *at, const char *key, double min)
{
    return fmin(json_get_number(at, key, min, PI_ABOVE), PI);
}

static void read_light(struct json_node *at, struct scene_light *light)
{
    static const char *const types[] = {"point", "spot", "area", "sun", NULL};
    static const char *const round_shapes[] = {"sphere", "disc", NULL};
    static const char *const flat_shapes[] = {"rectangle", "ellipse", NULL};
    light->name = json_get_text(at, "name");
    light->type = json_get_word(at, "type", types);
    read_transform(at, light->transform);
    json_get_numbers(at, light->type == LIGHT_SUN ? "irradiance" : "power", 0, 3, light->power);
    switch (light->type) {
    case LIGHT_SPOT:
        light->angle = read_angle(at, "angle", 1e-6);
        light->blend = json_get_number(at, "blend", 0, 1);
        /* fall through */
    case LIGHT_POINT:
        light->shape = LIGHT_SPHERE + json_get_word(at, "shape", round_shapes);
        light->radius = json_get_number(at, "radius", 0, HUGE_VAL);
        break;
    case LIGHT_AREA:
        light->shape = LIGHT_RECTANGLE + json_get_word(at, "shape", flat_shapes);
        json_get_numbers(at, "size", 0, 2, light->size);
        if (!(light->size[0] > 0 && light->size[1] > 0))
            json_fail(at, "size", "found [%g, %g], expected an extent on both axes", light->size[0], light->size[1]);
        light->spread = json_has(at, "spread") ? read_angle(at, "spread", 1e-6) : PI;
        break;
    case LIGHT_SUN: light->angle = read_angle(at, "angle", 0); break;
    }
    light->seen = read_flag(at, "camera", false);
    light->shadowless = !read_flag(at, "shadow", true);
    json_end(at);
}

static void read_lights(struct json_node *root, struct scene *scene)
{
    struct json_node list = json_get_list(root, "lights");
    scene->lights = json_new_array(&list, sizeof *scene->lights, &scene->light_count);
    for (int i = 0; i < scene->light_count; i++) {
        struct json_node item = json_get_item(&list, i);
        read_light(&item, &scene->lights[i]);
    }
}

static void read_notes(struct json_node *root, struct scene *scene)
{
    struct json_node list = json_get_list(root, "notes");
    scene->notes = json_new_array(&list, sizeof *scene->notes, &scene->note_count);
    for (int i = 0; i < scene->note_count; i++) {
        struct scene_note *note = &scene->notes[i];
        struct json_node item = json_get_item(&list, i);
        note->object = json_has(&item, "object") ? json_get_text(&item, "object") : NULL;
        note->material = json_has(&item, "material") ? json_get_text(&item, "material") : NULL;
        note->node = json_has(&item, "node") ? json_get_text(&item, "node") : NULL;
        note->text = json_get_text(&item, "text");
        json_end(&item);
    }
}

bool scene_read(const char *folder, struct scene *scene, char error[SCENE_ERROR])
{
    memset(scene, 0, sizeof *scene);
    char path[4096];
    if (snprintf(path, sizeof path, "%s/scene.json", folder) >= (int)sizeof path) {
        snprintf(error, SCENE_ERROR, "%.80s...: the path is longer than %zu bytes", folder, sizeof path);
        return false;
    }
    struct json_file file;
    struct buffer buffer;
    struct json_node root = json_open(path, &file, error);
    read_heading(&root);
    buffer_read(&root, folder, scene, &buffer);
    read_camera(&root, &scene->camera);
    textures_read(&root, folder, &buffer, scene);
    materials_read(&root, scene);
    read_world(&root, scene);
    meshes_read(&root, &buffer, scene);
    read_objects(&root, scene);
    read_lights(&root, scene);
    read_notes(&root, scene);
    json_end(&root);
    buffer_free(&buffer);
    json_close(&file);
    if (file.failed) scene_free(scene);
    return !file.failed;
}

/* Moves the camera by "X,Y,Z". */
static bool shift_camera(struct scene_camera *camera, const char *text, char error[SCENE_ERROR])
{
    float shift[3];
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        char *end;
        shift[i] = strtof(at, &end);
        if (end == at || *end != (i < 2 ? ',' : '\0') || !isfinite(shift[i])) {
            snprintf(error, SCENE_ERROR, "camera/shift: found '%.80s', expected three numbers X,Y,Z", text);
            return false;
        }
        at = end + 1;
    }
    for (int i = 0; i < 3; i++) camera->transform[4 * i + 3] += shift[i];
    return true;
}

/* The property `name` of so many letters, or NULL where the closure has none such. */
static struct scene_scalar *find_property(struct scene_closure *closure, const char *name, int length)
{
    static const char exponent[] = "exponent", roughness[] = "roughness";
    if (length == sizeof exponent - 1 && strncmp(name, exponent, length) == 0)
        return closure->type == CLOSURE_PHONG ? &closure->exponent : NULL;
    if (length == sizeof roughness - 1 && strncmp(name, roughness, length) == 0)
        return scene_closure_has_roughness(closure->type) ? &closure->roughness : NULL;
    return NULL;
}

bool scene_set(struct scene *scene, const char *assignment, char error[SCENE_ERROR])
{
    static const char folder[] = "materials/", camera[] = "camera/shift=";
    if (strncmp(assignment, camera, sizeof camera - 1) == 0)
        return shift_camera(&scene->camera, assignment + sizeof camera - 1, error);
    const char *equals = strrchr(assignment, '='), *slash = equals;
    while (slash && slash > assignment && *slash != '/') slash--;
    size_t start = sizeof folder - 1;
    if (strncmp(assignment, folder, start) != 0 || !slash || slash < assignment + start) {
        snprintf(error, SCENE_ERROR,
                 "%.200s: expected materials/NAME/exponent=VALUE, materials/NAME/roughness=VALUE or camera/shift=X,Y,Z",
                 assignment);
        return false;
    }
    const char *name = assignment + start, *property = slash + 1;
    int name_length = (int)(slash - name), property_length = (int)(equals - property);
    char *end;
    double value = strtod(equals + 1, &end), most = *property == 'e' ? FLT_MAX : 1;
    bool number = end != equals + 1 && !*end && value >= 0 && value <= most, found = false;
    for (int i = 0; i < scene->material_count; i++) {
        struct scene_material *material = &scene->materials[i];
        if (strncmp(material->name, name, (size_t)name_length) != 0 || material->name[name_length] != '\0') continue;
        for (int k = 0; k < material->closure_count; k++) {
            struct scene_scalar *scalar = find_property(&material->closures[k], property, property_length);
            if (!scalar) continue;
            found = true;
            if (number) *scalar = (struct scene_scalar){(float)value, SCENE_NONE};
        }
    }
    if (!found)
        snprintf(error, SCENE_ERROR, "%.200s: no material '%.*s' with the property '%.*s' in the scene", assignment,
                 name_length < 80 ? name_length : 80, name, property_length < 40 ? property_length : 40, property);
    else if (!number)
        snprintf(error, SCENE_ERROR, "%.200s: found '%.40s', expected a number from 0 to %g", assignment, equals + 1,
                 most);
    return found && number;
}

void scene_free(struct scene *scene)
{
    for (int i = 0; i < scene->image_count; i++) free(scene->images[i].file);
    for (int i = 0; i < scene->material_count; i++) {
        free(scene->materials[i].name);
        free(scene->materials[i].closures);
    }
    for (int i = 0; i < scene->mesh_count; i++) free(scene->meshes[i].name);
    for (int i = 0; i < scene->object_count; i++) {
        free(scene->objects[i].name);
        free(scene->objects[i].materials);
    }
    for (int i = 0; i < scene->light_count; i++) free(scene->lights[i].name);
    for (int i = 0; i < scene->note_count; i++) {
        free(scene->notes[i].object);
        free(scene->notes[i].material);
        free(scene->notes[i].node);
        free(scene->notes[i].text);
    }
    free(scene->images);
    free(scene->textures);
    free(scene->materials);
    free(scene->meshes);
    free(scene->objects);
    free(scene->lights);
    free(scene->notes);
    free(scene->buffer);
    memset(scene, 0, sizeof *scene);
}
