/* SPDX-License-Identifier: Apache-2.0 */
#include "render/caustics.h"

#include <stdlib.h>
#include <string.h>

#include "render/pane.h"
#include "render/sequence.h"
#include "render/surfaces.h"

/* Points that are looked at, and photons sent from some of them. */
enum { CANDIDATES = 1 << 18, PHOTONS = 1 << 17, SEED_CAUSTICS = 601 };
/* How much fewer points lie on triangles that aren't glossy in their middle, though their material may be: a texture
 * may have it otherwise. */
#define ELSEWHERE .05
/* The estimate reaches so many pixels where a photon is in the median, and up to WIDER times that for ENOUGH photons,
 * less where there are PLENTY, by the median of PROBES places; half of it, and half again, where that still has ENOUGH.
 * COVER rays find whether there is surface all about, COVER_EDGE more how much, if not: the reciprocal of few would be
 * too large in the mean. */
#define REACH_PIXELS 10.0f
#define WIDER 3.0f
enum { HALVES = 3, ENOUGH = 100, PLENTY = 400, COVER = 8, COVER_EDGE = 32, PROBES = 256 };
/* How far beyond the disc a surface that falls off is looked for, as a multiple of the disc's distance. */
#define FARTHEST 2.0f
/* Photons count where normals differ by less than 45 degrees. */
#define NORMAL_COSINE .7f
/* Places that have the same surface about them: their normals, and their distance as a share of the reach. */
#define ALIKE_COSINE .9f
#define ALIKE_DISTANCE .25f

/* A lamp sample at a point on a glossy surface. */
struct candidate {
    struct hit hit;
    float3 origin, wi; /* where rays leave it; to the lamp */
    float distance;
    rgb flux;     /* W that come in there */
    float weight; /* about what of its luminance is sent on */
};

/* All triangles by area, glossy ones before all; none that can't be. */
struct sites {
    double *reach; /* weight of all triangles up to and with each, m2; objects in the scene's order */
    size_t *first; /* triangle of each object in `reach`, and the count at the end */
};

static float area(const struct trace_object *object, uint32_t triangle)
{
    return .5f * length(surfaces_across(object, triangle));
}

/* Whether a material may reflect by lobes. */
static bool may_gloss(const struct scene_material *material)
{
    for (int k = 0; k < material->closure_count; k++) {
        enum closure_type type = material->closures[k].type;
        if (type != CLOSURE_DIFFUSE && type != CLOSURE_TRANSLUCENT && type != CLOSURE_TRANSPARENT) return true;
    }
    return false;
}

/* False: no memory. The caller frees in any case. */
static bool find_sites(const struct model *model, struct sites *sites)
{
    int objects = model->scene->object_count;
    double sum = 0;
    sites->first = calloc((size_t)objects + 1, sizeof *sites->first);
    for (int i = 0; sites->first && i < objects; i++)
        sites->first[i + 1] = sites->first[i] + model->objects[i].triangles->triangle_count;
    sites->reach = sites->first ? malloc((sites->first[objects] + 1) * sizeof *sites->reach) : NULL;
    for (int i = 0; sites->reach && i < objects; i++)
        for (uint32_t k = 0; k < model->objects[i].triangles->triangle_count; k++) {
            struct hit middle = {.object = (uint32_t)i, .triangle = k, .u = 1 / 3.0f, .v = 1 / 3.0f};
            struct point point;
            shade_point(model, (struct ray){.dir = vec3(0, 0, 1)}, &middle, &point);
            bool may = point.material != SCENE_NONE && may_gloss(&model->scene->materials[point.material]);
            double weight = point.brdf.lobe_count ? 1 : may ? ELSEWHERE : 0;
            sites->reach[sites->first[i] + k] = sum += area(&model->objects[i], k) * weight;
        }
    return sites->reach != NULL;
}

/* The point of a triangle that three numbers choose; returns its density, 1/m2. */
static double site(const struct model *model, const struct sites *sites, float u, float2 place, struct hit *hit)
{
    size_t count = sites->first[model->scene->object_count];
    uint32_t object = 0;
    size_t low = surfaces_find(sites->reach, count, u * sites->reach[count - 1]);
    while (sites->first[object + 1] <= low) object++;
    bool fold = place.x + place.y > 1; /* evenly in the triangle: the square's far half is folded back */
    *hit = (struct hit){.object = object,
                        .triangle = (uint32_t)(low - sites->first[object]),
                        .u = fold ? 1 - place.x : place.x,
                        .v = fold ? 1 - place.y : place.y};
    double weight = sites->reach[low] - (low ? sites->reach[low - 1] : 0);
    return weight / (sites->reach[count - 1] * area(&model->objects[object], hit->triangle));
}

/* How often each lobe that reflects is drawn; returns the sum. */
static float lobe_weights(const struct brdf *brdf, float cos_o, float weights[static BRDF_LOBES])
{
    float sum = 0;
    for (int i = 0; i < brdf->lobe_count; i++) {
        const struct lobe *lobe = &brdf->lobes[i];
        sum += weights[i] = lobe_transmits(lobe) ? 0 : luminance(lobe_albedo(lobe, maxf(cos_o, 0)));
    }
    return sum;
}

/* f of the lobes that reflect. */
static rgb reflected(const struct point *point, float3 wi)
{
    rgb f = {0};
    for (int i = 0; i < point->brdf.lobe_count; i++)
        if (!lobe_transmits(&point->brdf.lobes[i]))
            f = add(f, lobe_eval(&point->brdf.lobes[i], point->n, point->wo, wi));
    return f;
}

/* The pdf of a direction drawn by lobes with these weights. */
static float reflected_pdf(const struct point *point, const float weights[static BRDF_LOBES], float sum, float3 wi)
{
    float pdf = 0;
    for (int i = 0; i < point->brdf.lobe_count; i++)
        if (weights[i] > 0) pdf += weights[i] / sum * lobe_pdf(&point->brdf.lobes[i], point->n, point->wo, wi);
    return pdf;
}

static void look(const struct model *model, const struct sites *sites, uint32_t i, uint64_t seed, struct candidate *c)
{
    struct picture_sequence spread = {i, (uint32_t)rng_mix(seed + SEED_CAUSTICS), 0};
    float2 place = sequence_next(&spread), on_light = sequence_next(&spread), choices = sequence_next(&spread);
    float u[3] = {choices.y, on_light.x, on_light.y}, weights[BRDF_LOBES];
    struct point point;
    struct light_sample light;
    *c = (struct candidate){.weight = 0};
    double density = site(model, sites, choices.x, place, &c->hit) / 2; /* on one of two sides */
    shade_point(model, (struct ray){.dir = vec3(0, 0, 1)}, &c->hit, &point);
    float3 front = point.front ? point.ng : scale(point.ng, -1);
    shade_point(model, (struct ray){.dir = scale(front, i % 2 ? 1 : -1)}, &c->hit, &point);
    if (!point.brdf.lobe_count || !lights_sample(model->lights, point.origin, point.n, u, &light)) return;
    float cosine = dot(light.wi, point.n);
    if (cosine <= 0 || dot(light.wi, point.ng) <= 0) return;
    c->origin = point.origin;
    c->wi = light.wi;
    c->distance = light.distance;
    c->flux = scale(light.weight, (float)(cosine / (density * CANDIDATES)));
    c->weight = luminance(c->flux) * lobe_weights(&point.brdf, cosine, weights);
}

/* Follows a ray to the first surface that isn't passed. False where there is none. */
static bool arrive(const struct model *model, struct ray ray, struct rng *rng, struct point *point, rgb *weight)
{
    struct hit hit;
    while (trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) {
        shade_point(model, ray, &hit, point);
        if (!pane_pass(point, rng, weight)) return true;
        ray.origin = shade_origin(point, ray.dir);
    }
    return false;
}

/* Sends a candidate's light on, `share` of it. False where it comes down on nothing diffuse. */
static bool send(const struct model *model, const struct candidate *c, float share, struct rng *rng,
                 struct photon *photon)
{
    struct point from, seen, to;
    float weights[BRDF_LOBES], u[2], pdf;
    float3 dir;
    rgb flux = mul(scale(c->flux, share), pane_transmittance(model, c->origin, c->wi, c->distance));
    shade_point(model, (struct ray){c->origin, scale(c->wi, -1)}, &c->hit, &from);
    float sum = lobe_weights(&from.brdf, dot(from.n, from.wo), weights), pick = rng_float(rng) * sum;
    if (is_black(flux) || !(sum > 0)) return false;
    int k = 0;
    while (k < from.brdf.lobe_count - 1 && (pick >= weights[k] || weights[k] == 0)) pick -= weights[k++];
    u[0] = rng_float(rng);
    u[1] = rng_float(rng);
    if (is_black(lobe_sample(&from.brdf.lobes[k], from.n, from.wo, u, &dir, &pdf)) || dot(dir, from.ng) <= 0 ||
        !arrive(model, (struct ray){from.origin, dir}, rng, &to, &flux))
        return false;
    /* The reflectance is that which a ray from the diffuse surface would find: it may depend on the viewer. */
    shade_point(model, (struct ray){to.origin, scale(dir, -1)}, &c->hit, &seen);
    float density = reflected_pdf(&from, weights, sum, dir);
    *photon = (struct photon){
        to.p, to.n, scale(mul(reflected(&seen, c->wi), flux), maxf(dot(dir, seen.n), 0) / density)};
    return !is_black(photon->flux) && !(is_black(to.brdf.kd) && is_black(to.brdf.kt));
}

static uint32_t bucket_of(const struct caustics *caustics, int x, int y, int z)
{
    uint64_t key = (uint64_t)(uint32_t)x * 0x9e3779b97f4a7c15u ^ (uint64_t)(uint32_t)y * 0xc2b2ae3d27d4eb4fu ^
                   (uint64_t)(uint32_t)z * 0x165667b19e3779f9u;
    return (uint32_t)(rng_mix(key) % caustics->bucket_count);
}

/* Cells are as wide as the estimate: eight of them at most have all that it needs. */
static int cell_of(const struct caustics *caustics, float x)
{
    return (int)floorf(clampf(x / (2 * caustics->reach), -1e9f, 1e9f));
}

static uint32_t bucket_at(const struct caustics *caustics, float3 p)
{
    return bucket_of(caustics, cell_of(caustics, p.x), cell_of(caustics, p.y), cell_of(caustics, p.z));
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

bool caustics_index(struct caustics *caustics)
{
    free(caustics->buckets);
    caustics->bucket_count = caustics->count + 1;
    caustics->buckets = calloc((size_t)caustics->bucket_count + 2, sizeof *caustics->buckets);
    struct photon *sorted = malloc((caustics->count + 1) * sizeof *sorted);
    bool ok = caustics->buckets && sorted;
    if (ok) {
        uint32_t *start = caustics->buckets + 1; /* of each bucket, one ahead while they are filled */
        for (uint32_t i = 0; i < caustics->count; i++) start[bucket_at(caustics, caustics->photons[i].p) + 1]++;
        for (uint32_t i = 0; i < caustics->bucket_count; i++) start[i + 1] += start[i];
        for (uint32_t i = 0; i < caustics->count; i++)
            sorted[start[bucket_at(caustics, caustics->photons[i].p)]++] = caustics->photons[i];
        free(caustics->photons);
        caustics->photons = sorted;
    } else {
        free(sorted);
    }
    return ok;
}

/* Sums over photons within reach, reach/2, reach/4. */
struct estimate {
    rgb flux[HALVES];
    int count[HALVES];
};

static void add_bucket(const struct caustics *caustics, uint32_t bucket, float3 p, float3 n, struct estimate *estimate)
{
    float reach2 = sqr(caustics->reach);
    for (uint32_t i = caustics->buckets[bucket]; i < caustics->buckets[bucket + 1]; i++) {
        const struct photon *photon = &caustics->photons[i];
        float3 d = sub(photon->p, p);
        float d2 = dot(d, d);
        if (d2 >= reach2 || dot(photon->n, n) < NORMAL_COSINE) continue;
        for (int k = 0; k < HALVES && d2 * (float)(1 << 2 * k) < reach2; k++) {
            estimate->flux[k] = add(estimate->flux[k], photon->flux);
            estimate->count[k]++;
        }
    }
}

static struct estimate estimate_at(const struct caustics *caustics, float3 p, float3 n)
{
    struct estimate estimate = {0};
    uint32_t seen[8];
    int seen_count = 0, low[3] = {cell_of(caustics, p.x - caustics->reach), cell_of(caustics, p.y - caustics->reach),
                                  cell_of(caustics, p.z - caustics->reach)};
    for (int i = 0; i < 8; i++) {
        uint32_t bucket = bucket_of(caustics, low[0] + (i & 1), low[1] + (i >> 1 & 1), low[2] + (i >> 2));
        bool again = false;
        for (int j = 0; j < seen_count; j++) again |= seen[j] == bucket;
        if (again) continue;
        seen[seen_count++] = bucket;
        add_bucket(caustics, bucket, p, n, &estimate);
    }
    return estimate;
}

/* Chooses the reach, and sorts the photons for it. False: no memory. */
static bool arrange(const struct model *model, struct caustics *caustics)
{
    uint32_t step = caustics->count / PROBES + 1, probes = 0;
    if (!caustics->count) return true;
    float *values = malloc(caustics->count * sizeof *values);
    if (!values) return false;
    for (uint32_t i = 0; i < caustics->count; i++)
        values[i] = camera_pixel_width(&model->scene->camera, caustics->photons[i].p);
    qsort(values, caustics->count, sizeof *values, compare_floats);
    caustics->reach = REACH_PIXELS * values[caustics->count / 2];
    bool ok = caustics_index(caustics);
    for (uint32_t i = 0; ok && i < caustics->count; i += step)
        values[probes++] = (float)estimate_at(caustics, caustics->photons[i].p, caustics->photons[i].n).count[0];
    if (ok) {
        qsort(values, probes, sizeof *values, compare_floats);
        float median = values[probes / 2], wider = 1;
        if (median < ENOUGH) wider = minf(sqrtf(ENOUGH / median), WIDER);
        if (median > PLENTY) wider = sqrtf(PLENTY / median);
        caustics->reach *= wider;
        ok = wider == 1 || caustics_index(caustics);
    }
    free(values);
    return ok;
}

/* Sends PHOTONS of equal luminance from candidates chosen by their weights, systematically. */
static bool send_all(const struct model *model, struct candidate *candidates, uint64_t seed, struct caustics *caustics)
{
    double sum = 0, passed = 0;
    for (uint32_t i = 0; i < CANDIDATES; i++) sum += candidates[i].weight;
    if (!(sum > 0)) return true;
    uint32_t *source = malloc(PHOTONS * sizeof *source), next = 0;
    caustics->photons = malloc(PHOTONS * sizeof *caustics->photons);
    bool *arrived = malloc(PHOTONS * sizeof *arrived);
    bool ok = source && caustics->photons && arrived;
    for (uint32_t i = 0; ok && i < CANDIDATES; i++) {
        passed += candidates[i].weight;
        while (next < PHOTONS && (next + .5) * sum < passed * PHOTONS) source[next++] = i;
    }
#pragma omp parallel for schedule(dynamic, 256)
    for (uint32_t i = 0; i < (ok ? next : 0); i++) {
        struct rng rng = rng_seed(seed, SEED_CAUSTICS + 1, i);
        const struct candidate *c = &candidates[source[i]];
        float share = (float)(sum / (c->weight * PHOTONS));
        arrived[i] = send(model, c, share, &rng, &caustics->photons[i]);
    }
    for (uint32_t i = 0; i < (ok ? next : 0); i++)
        if (arrived[i]) caustics->photons[caustics->count++] = caustics->photons[i];
    free(arrived);
    free(source);
    return ok && arrange(model, caustics);
}

bool caustics_build(const struct model *model, uint64_t seed, struct caustics *caustics)
{
    struct sites sites = {0};
    *caustics = (struct caustics){0};
    if (!lights_any(model->lights) || !model->triangle_count) return true;
    struct candidate *candidates = malloc(CANDIDATES * sizeof *candidates);
    bool ok = candidates && find_sites(model, &sites);
    bool any = ok && sites.reach[sites.first[model->scene->object_count] - 1] > 0;
#pragma omp parallel for schedule(dynamic, 1024)
    for (uint32_t i = 0; i < (any ? CANDIDATES : 0); i++) look(model, &sites, i, seed, &candidates[i]);
    ok = ok && (!any || send_all(model, candidates, seed, caustics));
    free(candidates);
    free(sites.reach);
    free(sites.first);
    if (!ok) caustics_free(caustics);
    return ok;
}

void caustics_free(struct caustics *caustics)
{
    free(caustics->photons);
    free(caustics->buckets);
    *caustics = (struct caustics){0};
}

/* How many of `rays` that fan out from `height` above p, to places spread over a disc about it, meet surface that faces
 * as p's does, not far beyond the disc. *area: of what they meet within the radius, as a share of the disc: the solid
 * angle of a place turned into area there. */
static int covered(const struct model *model, float3 p, struct side side, float radius, float height, int rays,
                   struct rng *rng, float *area)
{
    struct frame frame = frame_about(side.ng);
    float turn = rng_float(rng), u = rng_float(rng);
    float3 above = mad(side.origin, side.ng, height);
    int found = 0;
    *area = 0;
    for (int i = 0; i < rays; i++) {
        float r = radius * sqrtf(((float)i + u) / (float)rays), phi = 2 * PI * (turn + .618034f * (float)i);
        float3 to = sub(mad(mad(p, frame.t, r * cosf(phi)), frame.b, r * sinf(phi)), above);
        float distance = length(to);
        struct ray ray = {above, scale(to, 1 / distance)};
        struct hit hit;
        if (!trace_closest(model->trace, ray.origin, ray.dir, FARTHEST * distance, &hit)) continue;
        float3 n = normalize(surfaces_across(&model->objects[hit.object], hit.triangle));
        float cosine = -dot(n, ray.dir);
        if (fabsf(cosine) < 1e-3f || dot(n, side.ng) * (cosine > 0 ? 1 : -1) < NORMAL_COSINE) continue;
        found++;
        float3 d = sub(mad(above, ray.dir, hit.t), p);
        if (dot(d, d) < sqr(1.0001f * radius))
            *area += sqr(hit.t / distance) * -dot(side.ng, ray.dir) / fabsf(cosine) / (float)rays;
    }
    return found;
}

/* The area of surface within the radius that photons may lie on, as a share of the disc. On smooth surfaces, however
 * curved, it is the disc's, as on a ball (Archimedes): what counts is where they end. */
static float coverage(const struct model *model, float3 p, struct side side, float radius, struct rng *rng)
{
    struct hit hit;
    float area, height = radius;
    float3 start = mad(side.origin, side.ng, .1f * radius); /* a mean of places on a curved surface lies below it */
    if (trace_closest(model->trace, start, side.ng, 2 * radius, &hit)) height = .1f * radius + .5f * hit.t;
    if (covered(model, p, side, radius, height, COVER, rng, &area) == COVER) return 1;
    covered(model, p, side, radius, height, COVER_EDGE, rng, &area);
    return maxf(area, 1.0f / COVER_EDGE);
}

/* coverage, of a place near by if it is remembered. */
static float coverage_near(const struct model *model, float3 p, struct side side, float radius,
                           struct caustics_memory *memory, struct rng *rng)
{
    for (int i = 0; memory && i < memory->count; i++) {
        float3 d = sub(p, memory->places[i].p);
        if (memory->places[i].radius == radius && dot(memory->places[i].ng, side.ng) > ALIKE_COSINE &&
            dot(d, d) < sqr(ALIKE_DISTANCE * radius))
            return memory->places[i].coverage;
    }
    float found = coverage(model, p, side, radius, rng);
    if (memory && memory->count < CAUSTICS_PLACES) {
        memory->places[memory->count].p = p;
        memory->places[memory->count].ng = side.ng;
        memory->places[memory->count].radius = radius;
        memory->places[memory->count++].coverage = found;
    }
    return found;
}

rgb caustics_irradiance(const struct model *model, const struct caustics *caustics, float3 p, struct side side,
                        struct caustics_memory *memory, struct rng *rng)
{
    int k = 0;
    if (!caustics->count) return (rgb){0};
    struct estimate estimate = estimate_at(caustics, p, side.n);
    while (k + 1 < HALVES && estimate.count[k + 1] >= ENOUGH) k++;
    if (!estimate.count[k]) return (rgb){0};
    float radius = caustics->reach / (float)(1 << k);
    return scale(estimate.flux[k], 1 / (PI * sqr(radius) * coverage_near(model, p, side, radius, memory, rng)));
}

size_t caustics_bytes(const struct caustics *caustics)
{
    return caustics->count * sizeof *caustics->photons + caustics->bucket_count * sizeof *caustics->buckets;
}
