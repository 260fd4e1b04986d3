/* SPDX-License-Identifier: Apache-2.0 */
#include "render/model.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "import/level.h"
#include "render/surface.h"
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

/* What a mesh's objects ask of it. */
struct demand {
    uint32_t users;
    int level, last;
};

/* Lowers a demand to what the bends of the mesh ask for. */
static bool weigh_bends(const struct scene *scene, int m, struct demand *demand, char error[static SCENE_ERROR])
{
    const struct scene_mesh *mesh = &scene->meshes[m];
    struct bends bends;
    int most = demand->level, level = 0;
    if (most <= 1) return true;
    if (!bends_measure(mesh, &bends, error)) return false;
    for (int i = 0; i < scene->object_count; i++) {
        if (scene->objects[i].mesh != m) continue;
        int own = level_by_bends(mesh, &bends, scene->objects[i].transform, &scene->camera, most);
        level = own > level ? own : level;
    }
    demand->level = level;
    bends_free(&bends);
    return true;
}

static bool gather_demands(const struct scene *scene, struct demand *demands, char error[static SCENE_ERROR])
{
    int *levels = malloc(((size_t)scene->object_count + 1) * sizeof *levels);
    bool good = levels != NULL;
    if (!good) snprintf(error, SCENE_ERROR, "not enough memory for %d objects", scene->object_count);
#pragma omp parallel for schedule(dynamic) if (good)
    for (int i = 0; i < (good ? scene->object_count : 0); i++) {
        const struct scene_object *object = &scene->objects[i];
        levels[i] =
            level_by_edges(&scene->meshes[object->mesh], object->transform, &scene->camera, LEVEL_EDGE_PIXELS);
    }
    for (int i = 0; good && i < scene->object_count; i++) {
        struct demand *demand = &demands[scene->objects[i].mesh];
        demand->users++;
        demand->level = levels[i] > demand->level ? levels[i] : demand->level;
        demand->last = i;
    }
    free(levels);
#pragma omp parallel for schedule(dynamic)
    for (int m = 0; m < (good ? scene->mesh_count : 0); m++) {
        char sentence[SCENE_ERROR];
        if (weigh_bends(scene, m, &demands[m], sentence)) continue;
#pragma omp critical
        {
            memcpy(error, sentence, SCENE_ERROR);
            good = false;
        }
    }
    return good;
}

/* Tessellates each mesh that an object shows, at the highest level any of its objects asks for. */
static bool tessellate_meshes(struct model *model, const struct demand *demands, char error[static SCENE_ERROR])
{
    const struct scene *scene = model->scene;
    bool good = true;
#pragma omp parallel for schedule(dynamic)
    for (int m = 0; m < scene->mesh_count; m++) {
        char sentence[SCENE_ERROR];
        if (demands[m].users == 0) continue;
        if (tessellate(&scene->meshes[m], demands[m].level, &model->triangles[m], sentence)) {
            if (demands[m].users == 1) place(&model->triangles[m], scene->objects[demands[m].last].transform);
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

static void place_objects(struct model *model, const struct demand *demands)
{
    const struct scene *scene = model->scene;
    for (int i = 0; i < scene->object_count; i++) {
        const struct scene_object *object = &scene->objects[i];
        bool shared = demands[object->mesh].users > 1;
        model->objects[i] =
            (struct trace_object){.triangles = &model->triangles[object->mesh],
                                  .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                  .instanced = shared,
                                  .hidden = object->hidden,
                                  .shadowless = object->shadowless};
        if (shared) memcpy(model->objects[i].transform, object->transform, sizeof object->transform);
    }
    for (int m = 0; m < scene->mesh_count; m++) model->triangle_count += model->triangles[m].triangle_count;
}

static bool build(struct model *model, struct demand *demands, char error[static SCENE_ERROR])
{
    const struct scene *scene = model->scene;
    double start = omp_get_wtime();
    if (!gather_demands(scene, demands, error)) return false;
    if (!tessellate_meshes(model, demands, error)) return false;
    place_objects(model, demands);
    model->tessellate_s = omp_get_wtime() - start;

    start = omp_get_wtime();
    model->trace = trace_build(model->objects, (uint32_t)scene->object_count, error);
    if (!model->trace) return false;
    model->radius = trace_radius(model->trace);
    model->bvh_s = omp_get_wtime() - start;
    if (!textures_load(scene, &model->textures, error)) return false;
    for (int i = 0; i < scene->material_count && !model->panes; i++)
        model->panes = surface_may_pass(&scene->materials[i]);
    model->lights = lights_build(scene, &model->textures, model->objects, model->radius, error);
    return model->lights != NULL;
}

bool model_build(const struct scene *scene, struct model *model, char error[static SCENE_ERROR])
{
    *model = (struct model){.scene = scene};
    model->triangles = calloc((size_t)scene->mesh_count + 1, sizeof *model->triangles);
    model->objects = calloc((size_t)scene->object_count + 1, sizeof *model->objects);
    struct demand *demands = calloc((size_t)scene->mesh_count + 1, sizeof *demands);
    bool good = model->triangles && model->objects && demands;
    if (good) good = build(model, demands, error);
    else snprintf(error, SCENE_ERROR, "not enough memory for %d objects", scene->object_count);
    free(demands);
    if (!good) model_free(model);
    return good;
}

void model_free(struct model *model)
{
    lights_free(model->lights);
    textures_free(&model->textures);
    trace_free(model->trace);
    if (model->triangles)
        for (int m = 0; m < model->scene->mesh_count; m++) triangles_free(&model->triangles[m]);
    free(model->triangles);
    free(model->objects);
    *model = (struct model){0};
}
