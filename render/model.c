/* SPDX-License-Identifier: Apache-2.0 */
#include "render/model.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/transform.h"

/* Moves a mesh to world space. Where the transform mirrors, triangles are turned round: their front stays the side that
 * the mesh's normals show. */
static void place(struct triangles *t, const float m[static 12])
{
    for (uint32_t i = 0; i < t->vertex_count; i++) {
        float *p = t->positions + 3 * (size_t)i, *q = t->normals + 3 * (size_t)i;
        float3 position = transform_point(m, vec_from(p)), normal = transform_normal(m, vec_from(q));
        normal = normalize(normal);
        memcpy(p, &position, sizeof position);
        memcpy(q, &normal, sizeof normal);
    }
    if (transform_determinant(m) < 0)
        for (uint32_t i = 0; i < t->triangle_count; i++) {
            uint32_t *index = t->indices + 3 * (size_t)i, swap = index[1];
            index[1] = index[2];
            index[2] = swap;
        }
}

/* Tessellates each mesh that an object shows, at the highest level any of its objects asks for. */
static bool tessellate_meshes(struct model *model, const uint32_t *users, char error[static SCENE_ERROR])
{
    const struct scene *scene = model->scene;
    bool good = true;
#pragma omp parallel for schedule(dynamic)
    for (int m = 0; m < scene->mesh_count; m++) {
        if (users[m] == 0)
            continue;
        int level = 0, last = 0;
        for (int i = 0; i < scene->object_count; i++)
            if (scene->objects[i].mesh == m) {
                int one = tessellate_level(&scene->meshes[m], scene->objects[i].transform, &scene->camera,
                                           TESSELLATE_EDGE_PIXELS);
                level = one > level ? one : level;
                last = i;
            }
        char sentence[SCENE_ERROR];
        if (tessellate(&scene->meshes[m], level, &model->triangles[m], sentence)) {
            if (users[m] == 1)
                place(&model->triangles[m], scene->objects[last].transform);
            continue;
        }
#pragma omp critical
        {
            memcpy(error, sentence, SCENE_ERROR);
            good = false;
        }
    }
    return good;
}

static void place_objects(struct model *model, const uint32_t *users)
{
    const struct scene *scene = model->scene;
    for (int i = 0; i < scene->object_count; i++) {
        const struct scene_object *object = &scene->objects[i];
        bool shared = users[object->mesh] > 1;
        model->objects[i] = (struct trace_object){&model->triangles[object->mesh],
                                                  {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, shared};
        if (shared)
            memcpy(model->objects[i].transform, object->transform, sizeof object->transform);
    }
    for (int m = 0; m < scene->mesh_count; m++)
        model->triangle_count += model->triangles[m].triangle_count;
}

/* Half the diagonal of the box about all objects. */
static float bounding_radius(const struct model *model)
{
    float3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < model->scene->object_count; i++) {
        const struct trace_object *object = &model->objects[i];
        for (uint32_t k = 0; k < object->triangles->vertex_count; k++) {
            float3 p = transform_point(object->transform, vec_from(object->triangles->positions + 3 * (size_t)k));
            low = vec3(fminf(low.x, p.x), fminf(low.y, p.y), fminf(low.z, p.z));
            high = vec3(fmaxf(high.x, p.x), fmaxf(high.y, p.y), fmaxf(high.z, p.z));
        }
    }
    return high.x >= low.x ? length(sub(high, low)) / 2 : 0;
}

static bool build(struct model *model, uint32_t *users, char error[static SCENE_ERROR])
{
    const struct scene *scene = model->scene;
    for (int i = 0; i < scene->object_count; i++)
        users[scene->objects[i].mesh]++;
    double start = omp_get_wtime();
    if (!tessellate_meshes(model, users, error))
        return false;
    place_objects(model, users);
    model->radius = bounding_radius(model);
    model->tessellate_s = omp_get_wtime() - start;

    start = omp_get_wtime();
    model->trace = trace_build(model->objects, (uint32_t)scene->object_count, error);
    if (!model->trace)
        return false;
    model->bvh_s = omp_get_wtime() - start;
    if (!textures_load(scene, &model->textures, error))
        return false;
    model->lights = lights_build(scene, &model->textures, model->objects, model->radius, error);
    return model->lights != NULL;
}

bool model_build(const struct scene *scene, struct model *model, char error[static SCENE_ERROR])
{
    *model = (struct model){.scene = scene};
    model->triangles = calloc((size_t)scene->mesh_count + 1, sizeof *model->triangles);
    model->objects = calloc((size_t)scene->object_count + 1, sizeof *model->objects);
    uint32_t *users = calloc((size_t)scene->mesh_count + 1, sizeof *users);
    bool good = model->triangles && model->objects && users;
    if (good)
        good = build(model, users, error);
    else
        snprintf(error, SCENE_ERROR, "not enough memory for %d objects", scene->object_count);
    free(users);
    if (!good)
        model_free(model);
    return good;
}

void model_free(struct model *model)
{
    lights_free(model->lights);
    textures_free(&model->textures);
    trace_free(model->trace);
    if (model->triangles)
        for (int m = 0; m < model->scene->mesh_count; m++)
            triangles_free(&model->triangles[m]);
    free(model->triangles);
    free(model->objects);
    *model = (struct model){0};
}

float model_radius(const struct model *model) { return model->radius; }
