/* SPDX-License-Identifier: Apache-2.0 */
#include "render/emitter.h"

#include <stdlib.h>

#include "render/solid_angle.h"
#include "render/surface.h"
#include "render/transform.h"

/* Within so many radii of the sphere about an emitter of so many triangles each is weighed by what it sends. */
#define NEAR_RADII 4.0f
enum { LEAST_WEIGHED = 32, MOST_WEIGHED = 2048 };
/* The share of samples near an emitter that go by area all the same. */
#define BY_AREA .2f
/* A triangle is sampled by solid angle from where its middle is nearer than its longest edge is long, unless it is seen
 * edge on: under so many sr. */
#define LEAST_ANGLE 1e-5f
/* Nor from its own plane, by this share of that edge: what rounding sees there of the triangle itself fills 2 pi sr. */
#define LEAST_HEIGHT 1e-4f

/* Directions of the slabs, not unit: axes, diagonals of faces, diagonals of the cube. */
static const float3 SLABS[EMITTER_SLABS] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},  {1, 1, 0},  {1, -1, 0},
                                            {1, 0, 1},  {1, 0, -1}, {0, 1, 1},  {0, 1, -1}, {1, 1, 1},
                                            {1, 1, -1}, {1, -1, 1}, {1, -1, -1}};

static const struct scene_material *material_of(const struct scene *scene, const struct scene_object *object,
                                                uint32_t slot)
{
    int index = slot < object->slot_count ? object->materials[slot] : SCENE_NONE;
    const struct scene_material *material = index == SCENE_NONE ? NULL : &scene->materials[index];
    if (!material || (material->emission.texture == SCENE_NONE && max3(vec_from(material->emission.value)) <= 0))
        return NULL;
    return material->emission_front || material->emission_back ? material : NULL;
}

static bool varies(const struct emitter_triangle *t) { return t->material->emission.texture != SCENE_NONE; }

/* The mean radiance over a triangle and the sides that shine, seen by the cosine law. */
static rgb mean_radiance(const struct emitter *e, const struct emitter_triangle *t)
{
    enum { SAMPLES = 32 };
    rgb sum = {0};
    for (int i = 0; i < SAMPLES; i++) {
        float u = fmodf(.7548777f * (float)i + .5f, 1), v = fmodf(.5698403f * (float)i + .5f, 1); /* R2 */
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        struct texture_place place = {.uv = surface_uv(e->placed->triangles, t->index, u, v),
                                      .cosine = sqrtf(((float)i + .5f) / SAMPLES),
                                      .front = t->front && (!t->back || i % 2)};
        sum = mad(sum, surface_emission(&e->textures, t->material, &place), 1.0f / SAMPLES);
    }
    return sum;
}

static struct emitter_triangle place(const struct emitter *e, uint32_t triangle, const struct scene_material *material)
{
    const struct triangles *t = e->placed->triangles;
    const uint32_t *index = t->indices + 3 * (size_t)triangle;
    float3 corner[3];
    for (int k = 0; k < 3; k++)
        corner[k] = transform_point(e->placed->transform, vec_from(t->positions + 3 * (size_t)index[k]));
    struct emitter_triangle result = {.a = corner[0],
                                      .ab = sub(corner[1], corner[0]),
                                      .ac = sub(corner[2], corner[0]),
                                      .index = triangle,
                                      .material = material,
                                      .front = material->emission_front,
                                      .back = material->emission_back};
    if (e->mirrored) { /* the front stays the same side */
        float3 swap = result.ab;
        result.ab = result.ac;
        result.ac = swap;
    }
    float3 across = cross(result.ab, result.ac), bc = sub(result.ac, result.ab);
    result.normal = normalize(across);
    result.area = length(across) / 2;
    result.edge2 = maxf(dot(bc, bc), maxf(dot(result.ab, result.ab), dot(result.ac, result.ac)));
    result.radiance = varies(&result) ? mean_radiance(e, &result) : vec_from(material->emission.value);
    return result;
}

/* An edge with its ends in order; `turn` is +1 where its triangle runs that way, else -1. */
struct edge {
    float3 low, high;
    int turn;
};

static int compare_points(float3 a, float3 b)
{
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    if (a.y != b.y) return a.y < b.y ? -1 : 1;
    return a.z < b.z ? -1 : a.z > b.z;
}

static int compare_edges(const void *a, const void *b)
{
    const struct edge *e = a, *f = b;
    int order = compare_points(e->low, f->low);
    return order ? order : compare_points(e->high, f->high);
}

/* Whether each edge is shared by two triangles that run along it in opposite directions. False where memory runs out,
 * too. */
static bool is_closed(const struct triangles *t)
{
    size_t count = 3 * (size_t)t->triangle_count;
    struct edge *edges = malloc(count * sizeof *edges);
    if (!edges) return false;
    for (uint32_t i = 0; i < t->triangle_count; i++) {
        const uint32_t *index = t->indices + 3 * (size_t)i;
        for (int k = 0; k < 3; k++) {
            float3 from = vec_from(t->positions + 3 * (size_t)index[k]);
            float3 to = vec_from(t->positions + 3 * (size_t)index[(k + 1) % 3]);
            bool forward = compare_points(from, to) < 0;
            edges[3 * (size_t)i + (size_t)k] = forward ? (struct edge){from, to, 1} : (struct edge){to, from, -1};
        }
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    bool closed = true;
    for (size_t i = 0; closed && i < count; i += 2)
        closed =
            i + 1 < count && compare_edges(&edges[i], &edges[i + 1]) == 0 && edges[i].turn + edges[i + 1].turn == 0;
    free(edges);
    return closed;
}

/* The sphere about the box of all corners, the common direction if there is one, and the chances. */
static void summarise(struct emitter *e)
{
    float3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    double sum = 0;
    e->normal = e->triangles[0].normal;
    e->flat = true;
    e->height = INFINITY;
    for (int slab = 0; slab < EMITTER_SLABS; slab++) {
        e->low[slab] = INFINITY;
        e->high[slab] = -INFINITY;
    }
    for (uint32_t i = 0; i < e->count; i++) {
        const struct emitter_triangle *t = &e->triangles[i];
        float3 corner[3] = {t->a, add(t->a, t->ab), add(t->a, t->ac)};
        for (int k = 0; k < 3; k++) {
            low = vec3(minf(low.x, corner[k].x), minf(low.y, corner[k].y), minf(low.z, corner[k].z));
            high = vec3(maxf(high.x, corner[k].x), maxf(high.y, corner[k].y), maxf(high.z, corner[k].z));
            e->height = minf(e->height, dot(e->normal, corner[k]));
            for (int slab = 0; slab < EMITTER_SLABS; slab++) {
                float along = dot(SLABS[slab], corner[k]);
                e->low[slab] = minf(e->low[slab], along);
                e->high[slab] = maxf(e->high[slab], along);
            }
        }
        e->flat = e->flat && dot(t->normal, e->normal) > 0.9999f;
        e->front = e->front || t->front;
        e->back = e->back || t->back;
        e->cumulative[i] = sum;
        sum += (double)t->area * luminance(t->radiance);
    }
    e->cumulative[e->count] = sum;
    for (uint32_t i = 0; i <= e->count && sum > 0; i++) e->cumulative[i] /= sum;
    e->strength = (float)sum;
    e->centre = scale(add(low, high), 0.5f);
    e->radius = length(sub(high, low)) / 2;
    e->height -= 1e-4f * e->radius; /* nearly coplanar corners */
}

bool emitter_build(const struct scene *scene, const struct textures *textures, const struct scene_object *object,
                   const struct trace_object *placed, float scene_radius, struct emitter *emitter)
{
    struct emitter *e = emitter;
    const struct triangles *t = placed->triangles;
    *e = (struct emitter){
        .textures = *textures, .placed = placed, .mirrored = transform_determinant(placed->transform) < 0,
        .scene_radius = scene_radius};
    uint32_t count = 0;
    for (uint32_t i = 0; i < t->triangle_count; i++) count += material_of(scene, object, t->slots[i]) != NULL;
    if (count == 0) return true;
    e->triangles = malloc(count * sizeof *e->triangles);
    e->cumulative = malloc((count + (size_t)1) * sizeof *e->cumulative);
    e->own = malloc(t->triangle_count * sizeof *e->own);
    if (!e->triangles || !e->cumulative || !e->own) {
        emitter_free(e);
        return false;
    }
    for (uint32_t i = 0; i < t->triangle_count; i++) {
        const struct scene_material *material = material_of(scene, object, t->slots[i]);
        e->own[i] = material ? e->count : UINT32_MAX;
        if (material) e->triangles[e->count++] = place(e, i, material);
    }
    summarise(e);
    e->closed = count == t->triangle_count && is_closed(t);
    return true;
}

void emitter_free(struct emitter *emitter)
{
    free(emitter->triangles);
    free(emitter->cumulative);
    free(emitter->own);
    *emitter = (struct emitter){0};
}

float emitter_irradiance(const struct emitter *emitter, float3 p, float3 n)
{
    const struct emitter *e = emitter;
    float3 to = sub(e->centre, p);
    float d = length(to), r = e->radius, own = 1;
    float bound = d > r ? clampf((dot(n, to) + r) / d, 0, 1) : 1;
    if (e->flat) {
        float height = dot(e->normal, p) - e->height;
        if (height <= 0 && !e->back) return 0;
        own = maxf(fabsf(height), 1e-3f * r) / maxf(fabsf(height), maxf(d - r, 1e-3f * r));
    }
    return e->strength * own * bound / maxf(d * d + r * r, 1e-20f);
}

/* Whether p is inside the slabs about the emitter. */
static bool in_slabs(const struct emitter *e, float3 p)
{
    for (int i = 0; i < EMITTER_SLABS; i++) {
        float along = dot(p, SLABS[i]);
        if (along <= e->low[i] || along >= e->high[i]) return false;
    }
    return true;
}

/* Whether triangles are weighed anew at p: there are many, not too many to do so, and p sees them large and unlike.
 */
static bool is_near(const struct emitter *e, float3 p)
{
    float3 to = sub(e->centre, p);
    return e->count >= LEAST_WEIGHED && e->count <= MOST_WEIGHED &&
           dot(to, to) < sqr(NEAR_RADII * e->radius);
}

/* About the light at p of a triangle, 0 only where none arrives: by its middle's distance, no less than the triangle is
 * wide. `inside` the slabs, backs of a closed emitter may be seen. */
static float weight(const struct emitter *e, const struct emitter_triangle *t, float3 p, bool inside)
{
    float3 to = sub(mad(mad(t->a, t->ab, 1 / 3.0f), t->ac, 1 / 3.0f), p);
    float height = -dot(to, t->normal);
    if (height > 0 ? !t->front : height == 0 || !t->back || (e->closed && !inside)) return 0;
    float d2 = maxf(dot(to, to), 2 * t->area);
    return luminance(t->radiance) * t->area * fabsf(height) / (d2 * sqrtf(d2));
}

/* The chance of a triangle by its share of the light that all send. */
static float area_chance(const struct emitter *e, const struct emitter_triangle *t)
{
    return t->area * luminance(t->radiance) / e->strength;
}

static float weight_sum(const struct emitter *e, float3 p, bool inside)
{
    float sum = 0;
    for (uint32_t i = 0; i < e->count; i++) sum += weight(e, &e->triangles[i], p, inside);
    return sum;
}

/* The chance of a triangle of this weight: the weights are guesses, so a share goes by area alone. */
static float near_chance(const struct emitter *e, const struct emitter_triangle *t, float own, float sum)
{
    return BY_AREA * area_chance(e, t) + (1 - BY_AREA) * (sum > 0 ? own / sum : 0);
}

/* The solid angle of a triangle that is sampled by it from p; else 0. */
static float wide_angle(const struct emitter_triangle *t, float3 p)
{
    float3 a = sub(t->a, p), middle = mad(mad(a, t->ab, 1 / 3.0f), t->ac, 1 / 3.0f);
    if (dot(middle, middle) > t->edge2 || sqr(dot(a, t->normal)) < sqr(LEAST_HEIGHT) * t->edge2) return 0;
    float omega = solid_angle(&(struct seen_triangle){a, t->ab, t->ac});
    return omega > LEAST_ANGLE ? omega : 0;
}

float emitter_pdf(const struct emitter *emitter, float3 p, uint32_t triangle, float distance, float cosine)
{
    const struct emitter *e = emitter;
    if (e->own[triangle] == UINT32_MAX) return 0;
    const struct emitter_triangle *t = &e->triangles[e->own[triangle]];
    float chance = area_chance(e, t), omega = wide_angle(t, p);
    if (is_near(e, p)) {
        bool inside = in_slabs(e, p);
        chance = near_chance(e, t, weight(e, t, p, inside), weight_sum(e, p, inside));
    }
    if (omega > 0) return chance / omega;
    return cosine > 0 ? chance * sqr(distance) / (t->area * cosine) : 0;
}

static uint32_t choose_by_area(const struct emitter *e, float u)
{
    uint32_t low = 0, high = e->count;
    while (high - low > 1) {
        uint32_t middle = (low + high) / 2;
        if (e->cumulative[middle] <= u) low = middle;
        else high = middle;
    }
    return low;
}

static uint32_t choose_by_weight(const struct emitter *e, float3 p, bool inside, float left)
{
    uint32_t last = 0;
    for (uint32_t i = 0; i < e->count && left >= 0; i++) {
        float w = weight(e, &e->triangles[i], p, inside);
        if (w <= 0) continue;
        left -= w;
        last = i;
    }
    return last;
}

/* The triangle that u chooses, and with which chance. */
static const struct emitter_triangle *choose(const struct emitter *e, float3 p, float u, float *chance)
{
    const struct emitter_triangle *t;
    if (!is_near(e, p)) {
        t = &e->triangles[choose_by_area(e, u)];
        *chance = area_chance(e, t);
        return t;
    }
    bool inside = in_slabs(e, p);
    float sum = weight_sum(e, p, inside);
    if (u < BY_AREA) t = &e->triangles[choose_by_area(e, u / BY_AREA)];
    else t = &e->triangles[choose_by_weight(e, p, inside, (u - BY_AREA) / (1 - BY_AREA) * sum)];
    *chance = near_chance(e, t, weight(e, t, p, inside), sum);
    return t;
}

/* Heitz, "A Low-Distortion Map Between Triangle and Square", 2019: strata of u stay compact. */
static float2 place_by_area(const float u[static 2])
{
    return u[1] > u[0] ? (float2){u[0] / 2, u[1] - u[0] / 2} : (float2){u[0] - u[1] / 2, u[1] / 2};
}

/* What a triangle sends along wo from the corner a + x ab + y ac, as shade_point finds it. */
static rgb radiance_at(const struct emitter *e, const struct emitter_triangle *t, float x, float y, float3 wo,
                       bool front)
{
    float u = e->mirrored ? y : x, v = e->mirrored ? x : y;
    struct texture_place place = {.uv = surface_uv(e->placed->triangles, t->index, u, v),
                                  .cosine = fabsf(dot(surface_normal(e->placed, t->index, u, v), wo)),
                                  .front = front};
    return surface_emission(&e->textures, t->material, &place);
}

bool emitter_sample(const struct emitter *emitter, float3 p, const float u[static 3], float3 *wi, float *distance,
                    rgb *radiance, float *pdf)
{
    const struct emitter *e = emitter;
    float chance;
    const struct emitter_triangle *t = choose(e, p, u[0], &chance);
    float omega = wide_angle(t, p);
    const struct seen_triangle seen = {sub(t->a, p), t->ab, t->ac};
    float2 at = omega > 0 ? solid_angle_place(&seen, omega, u + 1) : place_by_area(u + 1);
    float3 q = mad(mad(t->a, t->ab, at.x), t->ac, at.y);
    float3 ng = t->normal, to = sub(q, p);
    float side = dot(to, ng);
    if (side < 0 ? !t->front : side == 0 || !t->back) return false;
    /* From outside a closed emitter its nearer fronts hide all its backs: no shadow ray needed to know. */
    if (side > 0 && e->closed && !in_slabs(e, p)) return false;
    to = sub(trace_offset(q, side > 0 ? scale(ng, -1) : ng, e->scene_radius), p);
    float d2 = dot(to, to);
    if (!(d2 > 0)) return false;
    *distance = sqrtf(d2);
    *wi = scale(to, 1 / *distance);
    *radiance = varies(t) ? radiance_at(e, t, at.x, at.y, scale(*wi, -1), side < 0) : t->radiance;
    *pdf = omega > 0 ? chance / omega : chance * d2 / (t->area * fabsf(dot(*wi, ng)));
    return true;
}
