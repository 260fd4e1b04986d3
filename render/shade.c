/* SPDX-License-Identifier: Apache-2.0 */
#include "render/shade.h"

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

static rgb colour_at(const struct textures *textures, const struct scene_colour *colour, float2 uv)
{
    return colour->texture == SCENE_NONE ? vec_from(colour->value) : texture_lookup(textures, colour->texture, uv);
}

static float scalar_at(const struct textures *textures, const struct scene_scalar *scalar, float2 uv)
{
    if (scalar->texture == SCENE_NONE) return scalar->value;
    rgb c = texture_lookup(textures, scalar->texture, uv);
    return (c.x + c.y + c.z) / 3;
}

static void shade_material(const struct model *model, const struct scene_material *material, float2 uv,
                           struct point *point)
{
    const struct textures *textures = &model->textures;
    if (point->front || !material->emission_front_only) point->emission = vec_from(material->emission);
    rgb colour = colour_at(textures, &material->colour, uv);
    if (material->type == MATERIAL_DIFFUSE) {
        point->brdf = (struct brdf){.kd = colour};
        return;
    }
    point->n = pull_normal(point->n, point->ng, point->wo);
    if (material->type == MATERIAL_PHONG) {
        point->brdf = brdf_phong(colour, colour_at(textures, &material->ks, uv),
                                 maxf(scalar_at(textures, &material->exponent, uv), 0));
        return;
    }
    struct principled principled = {.base_colour = colour,
                                    .specular_tint = vec_from(material->specular_tint),
                                    .metallic = scalar_at(textures, &material->metallic, uv),
                                    .roughness = scalar_at(textures, &material->roughness, uv),
                                    .ior = material->ior,
                                    .specular_level = material->specular_level};
    point->brdf = brdf_principled(&principled, dot(point->n, point->wo));
}

static inline float3 interpolate(const float *a, const float *b, const float *c, float u, float v)
{
    float w = 1 - u - v;
    return vec3(w * a[0] + u * b[0] + v * c[0], w * a[1] + u * b[1] + v * c[1], w * a[2] + u * b[2] + v * c[2]);
}

void shade_point(const struct model *model, struct ray ray, const struct hit *hit, struct point *point)
{
    const struct trace_object *object = &model->objects[hit->object];
    const struct triangles *t = object->triangles;
    const uint32_t *index = t->indices + 3 * (size_t)hit->triangle;
    const float *corners[3];
    for (int i = 0; i < 3; i++) corners[i] = t->positions + 3 * (size_t)index[i];
    float3 p = interpolate(corners[0], corners[1], corners[2], hit->u, hit->v);
    float3 ng = cross(sub(vec_from(corners[1]), vec_from(corners[0])), sub(vec_from(corners[2]), vec_from(corners[0])));
    float3 n = interpolate(t->normals + 3 * (size_t)index[0], t->normals + 3 * (size_t)index[1],
                           t->normals + 3 * (size_t)index[2], hit->u, hit->v);
    if (object->instanced) {
        p = transform_point(object->transform, p);
        ng = transform_normal(object->transform, ng);
        n = transform_normal(object->transform, n);
    }
    ng = normalize(ng);
    n = dot(n, n) > 0 ? normalize(n) : ng;
    *point = (struct point){
        .p = p, .wo = scale(ray.dir, -1), .object = hit->object, .triangle = hit->triangle, .material = SCENE_NONE};
    point->front = dot(ng, point->wo) >= 0;
    point->ng = point->front ? ng : scale(ng, -1);
    point->n = point->front ? n : scale(n, -1);
    point->origin = trace_offset(p, point->ng, model->radius);

    const struct scene_object *source = &model->scene->objects[hit->object];
    uint32_t slot = t->slots[hit->triangle];
    if (slot < source->slot_count) point->material = source->materials[slot];
    if (point->material == SCENE_NONE) {
        point->brdf = (struct brdf){.kd = {0.8f, 0.8f, 0.8f}};
        return;
    }
    float2 uv = {0, 0};
    if (t->uvs) {
        const float *a = t->uvs + 2 * (size_t)index[0], *b = t->uvs + 2 * (size_t)index[1];
        const float *c = t->uvs + 2 * (size_t)index[2];
        float w = 1 - hit->u - hit->v;
        uv = (float2){w * a[0] + hit->u * b[0] + hit->v * c[0], w * a[1] + hit->u * b[1] + hit->v * c[1]};
    }
    shade_material(model, &model->scene->materials[point->material], uv, point);
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

rgb shade_direct(const struct model *model, const struct point *point, const float u[static 3], bool mis)
{
    const rgb black = {0};
    struct light_sample sample;
    if (!lights_sample(model->lights, point->origin, point->n, u, &sample)) return black;
    float cos_i = dot(point->n, sample.wi), pdf;
    if (cos_i <= 0 || dot(point->ng, sample.wi) <= 0) return black;
    rgb f = brdf_eval_pdf(&point->brdf, point->n, point->wo, sample.wi, &pdf);
    if (is_black(f) || trace_occluded(model->trace, point->origin, sample.wi, sample.distance)) return black;
    float weight = mis && sample.pdf > 0 ? mis_weight(sample.pdf, pdf) : 1;
    return mul(f, scale(sample.weight, cos_i * weight));
}
