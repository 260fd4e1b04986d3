/* SPDX-License-Identifier: Apache-2.0 */
#include "render/surfaces.h"

#include <stdlib.h>

#include "render/rng.h"
#include "render/transform.h"

/* Diffuse walks that look for a way out, and points of each. */
enum { WALKS = 2, STEPS = 8, SEED_WALK = 501 };

float3 surfaces_across(const struct trace_object *object, uint32_t triangle)
{
    const struct triangles *t = object->triangles;
    float3 p[3];
    for (int i = 0; i < 3; i++) {
        p[i] = vec_from(t->positions + 3 * (size_t)t->indices[3 * (size_t)triangle + (size_t)i]);
        if (object->instanced) p[i] = transform_point(object->transform, p[i]);
    }
    return cross(sub(p[1], p[0]), sub(p[2], p[0]));
}

bool surfaces_build(const struct model *model, struct surfaces *surfaces)
{
    int objects = model->scene->object_count;
    *surfaces = (struct surfaces){model, NULL, malloc(((size_t)objects + 1) * sizeof(size_t))};
    if (!surfaces->first) return false;
    surfaces->first[0] = 0;
    for (int i = 0; i < objects; i++)
        surfaces->first[i + 1] = surfaces->first[i] + model->objects[i].triangles->triangle_count;
    surfaces->reach = malloc((surfaces->first[objects] + 1) * sizeof *surfaces->reach);
    if (!surfaces->reach) {
        surfaces_free(surfaces);
        return false;
    }
    double sum = 0;
    for (int i = 0; i < objects; i++)
        for (uint32_t k = 0; k < model->objects[i].triangles->triangle_count; k++)
            surfaces->reach[surfaces->first[i] + k] = sum += .5f * length(surfaces_across(&model->objects[i], k));
    return true;
}

void surfaces_free(struct surfaces *surfaces)
{
    free(surfaces->reach);
    free(surfaces->first);
    *surfaces = (struct surfaces){0};
}

size_t surfaces_find(const double *reach, size_t count, double at)
{
    size_t low = 0, high = count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (reach[middle] > at) high = middle;
        else low = middle + 1;
    }
    return low;
}

bool surfaces_point(const struct surfaces *surfaces, uint32_t i, struct point *point)
{
    /* The R3 sequence (Roberts 2018). */
    const double steps[3] = {.8191725133961645, .6710436067037893, .5497004779019703};
    double u[3];
    for (int k = 0; k < 3; k++) u[k] = fmod(.5 + steps[k] * (i / 2 + 1), 1);
    uint32_t low = 0, high = (uint32_t)surfaces->model->scene->object_count;
    size_t count = surfaces->first[high];
    if (!count || !(surfaces->reach[count - 1] > 0)) return false;
    size_t triangle = surfaces_find(surfaces->reach, count, u[0] * surfaces->reach[count - 1]);
    while (high - low > 1) { /* the last object that begins there or before */
        uint32_t middle = (low + high) / 2;
        *(surfaces->first[middle] <= triangle ? &low : &high) = middle;
    }
    struct hit hit = {.object = low, .triangle = (uint32_t)(triangle - surfaces->first[low])};
    /* Evenly in the triangle: the square's far half is folded back. */
    bool fold = u[1] + u[2] > 1;
    hit.u = (float)(fold ? 1 - u[1] : u[1]);
    hit.v = (float)(fold ? 1 - u[2] : u[2]);
    struct ray along = {.dir = vec3(0, 0, 1)};
    shade_point(surfaces->model, along, &hit, point);
    float3 front = point->front ? point->ng : scale(point->ng, -1);
    along.dir = scale(front, i % 2 ? 1 : -1);
    shade_point(surfaces->model, along, &hit, point);
    return true;
}

bool surfaces_open(const struct surfaces *surfaces, const struct point *point, uint64_t seed, uint32_t i)
{
    const struct model *model = surfaces->model;
    struct rng rng = rng_seed(seed, SEED_WALK, i);
    for (int walk = 0; walk < WALKS; walk++) {
        struct point at = *point;
        for (int step = 0; step < STEPS; step++) {
            float distance;
            float3 way = camera_way(&model->scene->camera, at.origin, &distance);
            if (dot(way, at.ng) > 0 && !trace_occluded(model->trace, at.origin, way, distance)) return true;
            float u[2] = {rng_float(&rng), rng_float(&rng)};
            struct ray ray = {at.origin, cosine_direction(at.ng, u)};
            struct hit hit;
            if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) return true;
            shade_point(model, ray, &hit, &at);
        }
    }
    return false;
}
