/* SPDX-License-Identifier: Apache-2.0 */
#include "render/shade.h"

#include "render/bumps.h"
#include "render/pane.h"
#include "render/surface.h"
#include "render/transform.h"

/* A normal whose mirror direction of wo stands at least this far above ng's horizon (or nearly as far as wo itself).
 * With n at angle a from ng in the plane of both, and wo at angle b there with length w, the mirror direction has the
 * component w cos(2a - b) along ng; the largest a that keeps it at t is (b + acos(t/w)) / 2. */
static float3 pull_normal(float3 n, float3 ng, float3 wo)
{
    float cos_o = dot(wo, ng), least = minf(0.9f * cos_o, 0.01f);
    if (dot(reflect(wo, n), ng) >= least) return n;
    float3 side = normalize(mad(n, ng, -dot(n, ng)));
    float wo_side = dot(wo, side), w = sqrtf(wo_side * wo_side + cos_o * cos_o);
    float a = (atan2f(wo_side, cos_o) + acosf(clampf(least / w, -1, 1))) / 2;
    return normalize(mad(scale(ng, cosf(a)), side, sinf(a)));
}

/* SCENE_NONE: the default one. */
static int material_at(const struct model *model, const struct hit *hit)
{
    const struct scene_object *object = &model->scene->objects[hit->object];
    uint32_t slot = model->objects[hit->object].triangles->slots[hit->triangle];
    return slot < object->slot_count ? object->materials[slot] : SCENE_NONE;
}

bool shade_may_pass(const struct model *model, const struct hit *hit)
{
    int material = material_at(model, hit);
    return material != SCENE_NONE && surface_may_pass(&model->scene->materials[material]);
}

/* The axes of uv on the triangle that was hit. */
static struct uv_axes axes_at(const struct model *model, const struct hit *hit)
{
    const struct trace_object *object = &model->objects[hit->object];
    const struct triangles *t = object->triangles;
    const uint32_t *index = t->indices + 3 * (size_t)hit->triangle;
    float3 corners[3];
    float2 uvs[3];
    if (!t->uvs) return (struct uv_axes){0};
    for (int i = 0; i < 3; i++) {
        corners[i] = vec_from(t->positions + 3 * (size_t)index[i]);
        if (object->instanced) corners[i] = transform_point(object->transform, corners[i]);
        uvs[i] = (float2){t->uvs[2 * (size_t)index[i]], t->uvs[2 * (size_t)index[i] + 1]};
    }
    return uv_axes(corners, uvs);
}

static void shade_material(const struct model *model, const struct scene_material *material, const struct hit *hit,
                           struct point *point)
{
    const struct textures *textures = &model->textures;
    bool bent = material->normal.type != NORMAL_OF_MESH;
    struct texture_place place = {
        .uv = surface_uv(model->objects[hit->object].triangles, hit->triangle, hit->u, hit->v),
        .cosine = fabsf(dot(point->n, point->wo)),
        .front = point->front};
    struct uv_axes axes = {0};
    float3 unbent = vec3(0, 0, 0), bumped = unbent;
    if (bent || surface_has_tangent(material)) axes = axes_at(model, hit);
    point->emission = surface_emission(textures, material, &place);
    if (bent) {
        unbent = point->n;
        float step = material->normal.filter * camera_pixel_step(&model->scene->camera, point->p);
        point->n = bumps_normal(textures, &material->normal, &place, &axes, point->n, step);
        bumped = point->n;
    }
    if (surface_is_glossy(material)) point->n = pull_normal(point->n, point->ng, point->wo);
    surface_brdf(textures, material, &place, point->n, point->wo, axes.du, &point->brdf);
    point->brdf.unbent = unbent;
    point->brdf.bent = bumped;
}

void shade_point(const struct model *model, struct ray ray, const struct hit *hit, struct point *point)
{
    const struct trace_object *object = &model->objects[hit->object];
    const struct triangles *t = object->triangles;
    const uint32_t *index = t->indices + 3 * (size_t)hit->triangle;
    float3 corners[3];
    for (int i = 0; i < 3; i++) corners[i] = vec_from(t->positions + 3 * (size_t)index[i]);
    float3 p = mad(mad(scale(corners[0], 1 - hit->u - hit->v), corners[1], hit->u), corners[2], hit->v);
    float3 ng = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
    if (object->instanced) {
        p = transform_point(object->transform, p);
        ng = transform_normal(object->transform, ng);
    }
    ng = normalize(ng);
    float3 n = surface_normal(object, hit->triangle, hit->u, hit->v);
    if (!(dot(n, n) > 0)) n = ng;
    /* One by one: the room for lobes is large, and need not be zero. */
    point->p = p;
    point->wo = scale(ray.dir, -1);
    point->emission = vec3(0, 0, 0);
    point->object = hit->object;
    point->triangle = hit->triangle;
    point->front = dot(ng, point->wo) >= 0;
    point->ng = point->front ? ng : scale(ng, -1);
    point->n = point->front ? n : scale(n, -1);
    point->origin = trace_offset(p, point->ng, model->radius);
    point->beyond = trace_offset(p, scale(point->ng, -1), model->radius);
    point->material = material_at(model, hit);
    if (point->material == SCENE_NONE) point->brdf = (struct brdf){.kd = {0.8f, 0.8f, 0.8f}};
    else shade_material(model, &model->scene->materials[point->material], hit, point);
}

float shade_curvature(const struct model *model, const struct point *point, float *steepest)
{
    const struct trace_object *object = &model->objects[point->object];
    const uint32_t *index = object->triangles->indices + 3 * (size_t)point->triangle;
    float3 p[3], n[3];
    for (int i = 0; i < 3; i++) {
        p[i] = vec_from(object->triangles->positions + 3 * (size_t)index[i]);
        n[i] = vec_from(object->triangles->normals + 3 * (size_t)index[i]);
        if (object->instanced) {
            p[i] = transform_point(object->transform, p[i]);
            n[i] = normalize(transform_normal(object->transform, n[i]));
        }
    }
    float sum = 0, along = 0;
    *steepest = 0;
    for (int i = 0; i < 3; i++) {
        float3 step = sub(p[(i + 1) % 3], p[i]), turn = sub(n[(i + 1) % 3], n[i]);
        float d2 = maxf(dot(step, step), 1e-30f);
        *steepest = maxf(*steepest, sqrtf(dot(turn, turn) / d2));
        sum += dot(turn, step);
        along += d2;
    }
    return (point->front ? sum : -sum) / along;
}

static rgb direct_from(const struct model *model, const struct point *point, bool beyond, const float u[static 3],
                       bool mis)
{
    const rgb black = {0};
    struct side side = shade_side(point, beyond);
    struct light_sample sample;
    if (!lights_sample(model->lights, side.origin, side.n, u, &sample)) return black;
    float cos_i = dot(side.n, sample.wi), pdf;
    if (cos_i <= 0 || dot(side.ng, sample.wi) <= 0) return black;
    rgb f = brdf_eval_pdf(&point->brdf, point->n, point->wo, sample.wi, &pdf);
    if (is_black(f)) return black;
    rgb lit = pane_transmittance(model, side.origin, sample.wi, sample.reach);
    float weight = mis && sample.pdf > 0 ? mis_weight(sample.pdf, pdf) : 1;
    return mul(mul(f, lit), scale(sample.weight, cos_i * weight));
}

rgb shade_direct(const struct model *model, const struct point *point, const float u[static 3], bool mis)
{
    rgb light = direct_from(model, point, false, u, mis);
    return brdf_spreads(&point->brdf) ? add(light, direct_from(model, point, true, u, mis)) : light;
}
