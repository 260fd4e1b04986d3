/* SPDX-License-Identifier: Apache-2.0 */
#include "render/surface.h"

#include "render/transform.h"

float2 surface_uv(const struct triangles *triangles, uint32_t triangle, float u, float v)
{
    if (!triangles->uvs) return (float2){0, 0};
    const uint32_t *index = triangles->indices + 3 * (size_t)triangle;
    const float *a = triangles->uvs + 2 * (size_t)index[0], *b = triangles->uvs + 2 * (size_t)index[1];
    const float *c = triangles->uvs + 2 * (size_t)index[2];
    float w = 1 - u - v;
    return (float2){w * a[0] + u * b[0] + v * c[0], w * a[1] + u * b[1] + v * c[1]};
}

float3 surface_normal(const struct trace_object *placed, uint32_t triangle, float u, float v)
{
    const struct triangles *t = placed->triangles;
    const uint32_t *index = t->indices + 3 * (size_t)triangle;
    float3 n = scale(vec_from(t->normals + 3 * (size_t)index[0]), 1 - u - v);
    n = mad(mad(n, vec_from(t->normals + 3 * (size_t)index[1]), u), vec_from(t->normals + 3 * (size_t)index[2]), v);
    if (placed->instanced) n = transform_normal(placed->transform, n);
    return dot(n, n) > 0 ? normalize(n) : n;
}

/* Where a closure is evaluated. */
struct site {
    const struct textures *textures;
    const struct texture_place *place;
    float3 n, tangent;
    float cos_o;
};

static inline rgb colour(const struct site *site, const struct scene_colour *value)
{
    return texture_colour(site->textures, value, site->place);
}

static inline float scalar(const struct site *site, const struct scene_scalar *value)
{
    return texture_scalar(site->textures, value, site->place);
}

static inline float share(const struct site *site, const struct scene_scalar *value)
{
    return clampf(scalar(site, value), 0, 1);
}

static enum distribution distribution_of(const struct scene_closure *closure)
{
    static const enum distribution distributions[] = {[CLOSURE_GGX] = DISTRIBUTION_GGX,
                                                      [CLOSURE_MULTI_GGX] = DISTRIBUTION_MULTI_GGX,
                                                      [CLOSURE_BECKMANN] = DISTRIBUTION_BECKMANN,
                                                      [CLOSURE_ASHIKHMIN_SHIRLEY] = DISTRIBUTION_ASHIKHMIN_SHIRLEY};
    return distributions[closure->distribution];
}

/* The tangent turned about n by the closure's rotation; 0 anisotropy needs none. */
static float3 turned_tangent(const struct site *site, const struct scene_closure *closure)
{
    float3 t = mad(site->tangent, site->n, -dot(site->tangent, site->n));
    t = dot(t, t) > 0 ? normalize(t) : frame_about(site->n).t;
    float angle = 2 * PI * scalar(site, &closure->rotation);
    return mad(scale(t, cosf(angle)), cross(site->n, t), sinf(angle));
}

static struct brdf glossy(const struct site *site, const struct scene_closure *closure)
{
    struct glossy result = {.colour = colour(site, &closure->colour),
                            .roughness = share(site, &closure->roughness),
                            .anisotropy = clampf(scalar(site, &closure->anisotropy), -1, 1),
                            .distribution = distribution_of(closure)};
    if (result.anisotropy != 0) result.tangent = turned_tangent(site, closure);
    return brdf_glossy(&result, site->cos_o);
}

static struct brdf principled(const struct site *site, const struct scene_closure *closure)
{
    struct principled result = {.base_colour = colour(site, &closure->colour),
                                .specular_tint = colour(site, &closure->specular_tint),
                                .metallic = share(site, &closure->metallic),
                                .roughness = share(site, &closure->roughness),
                                .ior = scalar(site, &closure->ior),
                                .specular_level = scalar(site, &closure->specular_level),
                                .anisotropy = clampf(scalar(site, &closure->anisotropy), -1, 1),
                                .transmission = share(site, &closure->transmission),
                                .coat_weight = share(site, &closure->coat_weight),
                                .sheen_weight = share(site, &closure->sheen_weight),
                                .distribution = distribution_of(closure)};
    if (result.anisotropy != 0) result.tangent = turned_tangent(site, closure);
    if (result.coat_weight > 0) {
        result.coat_roughness = share(site, &closure->coat_roughness);
        result.coat_ior = scalar(site, &closure->coat_ior);
        result.coat_tint = colour(site, &closure->coat_tint);
    }
    if (result.sheen_weight > 0) {
        result.sheen_roughness = share(site, &closure->sheen_roughness);
        result.sheen_tint = colour(site, &closure->sheen_tint);
    }
    return brdf_principled(&result, site->cos_o, site->place->front);
}

static struct glass glass(const struct site *site, const struct scene_closure *closure)
{
    return (struct glass){.colour = colour(site, &closure->colour),
                          .roughness = share(site, &closure->roughness),
                          .ior = scalar(site, &closure->ior),
                          .distribution = distribution_of(closure)};
}

static struct brdf closure_brdf(const struct site *site, const struct scene_closure *closure)
{
    struct glass inside;
    switch (closure->type) {
    case CLOSURE_DIFFUSE:
        return brdf_diffuse(colour(site, &closure->colour), share(site, &closure->roughness), site->cos_o);
    case CLOSURE_PHONG:
        return brdf_phong(colour(site, &closure->colour), colour(site, &closure->ks),
                          maxf(scalar(site, &closure->exponent), 0));
    case CLOSURE_GLOSSY: return glossy(site, closure);
    case CLOSURE_PRINCIPLED: return principled(site, closure);
    case CLOSURE_SHEEN:
        return brdf_sheen(colour(site, &closure->colour), share(site, &closure->roughness), site->cos_o);
    case CLOSURE_GLASS: return inside = glass(site, closure), brdf_glass(&inside, site->cos_o, site->place->front);
    case CLOSURE_REFRACTION: return inside = glass(site, closure), brdf_refraction(&inside, site->place->front);
    case CLOSURE_TRANSLUCENT: return (struct brdf){.kt = colour(site, &closure->colour)};
    case CLOSURE_TRANSPARENT: return (struct brdf){.through = colour(site, &closure->colour)};
    }
    return (struct brdf){0};
}

void surface_brdf(const struct textures *textures, const struct scene_material *material,
                  const struct texture_place *place, float3 n, float3 wo, float3 tangent, struct brdf *brdf)
{
    struct site site = {textures, place, n, tangent, dot(n, wo)};
    brdf_clear(brdf);
    for (int i = 0; i < material->closure_count; i++) {
        const struct scene_closure *closure = &material->closures[i];
        if (place->front ? !closure->front : !closure->back) continue;
        rgb weight = colour(&site, &closure->weight);
        if (is_black(weight)) continue;
        struct brdf part = closure_brdf(&site, closure);
        brdf_add(brdf, &part, weight);
    }
}

bool surface_is_glossy(const struct scene_material *material)
{
    for (int i = 0; i < material->closure_count; i++)
        switch (material->closures[i].type) {
        case CLOSURE_DIFFUSE:
        case CLOSURE_TRANSLUCENT:
        case CLOSURE_TRANSPARENT: break;
        default: return true;
        }
    return false;
}

bool surface_has_tangent(const struct scene_material *material)
{
    for (int i = 0; i < material->closure_count; i++) {
        const struct scene_scalar *anisotropy = &material->closures[i].anisotropy;
        if (anisotropy->value != 0 || anisotropy->texture != SCENE_NONE) return true;
    }
    return false;
}

/* An index of 1 bends nothing, and glass of it is a pane. */
static bool may_be_one(const struct scene_scalar *ior)
{
    return ior->texture != SCENE_NONE || fabsf(ior->value - 1) < 1e-3f;
}

bool surface_may_pass(const struct scene_material *material)
{
    for (int i = 0; i < material->closure_count; i++) {
        const struct scene_closure *closure = &material->closures[i];
        bool clear = closure->type == CLOSURE_GLASS || closure->type == CLOSURE_REFRACTION ||
                     (closure->type == CLOSURE_PRINCIPLED &&
                      (closure->transmission.texture != SCENE_NONE || closure->transmission.value > 0));
        if (closure->type == CLOSURE_TRANSPARENT || (clear && may_be_one(&closure->ior))) return true;
    }
    return false;
}
