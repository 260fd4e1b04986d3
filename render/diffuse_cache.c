/* SPDX-License-Identifier: Apache-2.0 */
#include "render/diffuse_cache.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eas/irradiance.h"
#include "render/gather.h"
#include "render/pane.h"
#include "render/path.h"

enum {
    PATHS = 8192,       /* camera paths that say where records are wanted */
    BOUNCES = 4,        /* points of each: what the camera sees and three diffuse bounces on */
    MOST_STEPS = 32,    /* surfaces that each may meet, glass among them */
    DISTANCE_RAYS = 64, /* to size a zone */
    GATHER_SIDE = 16,   /* squared: rays of each record of the finest */
    SOLVE_STEPS = 64,
    CHECK_POINTS = 512,
    CHECK_RAYS = 64
};

/* Zones are half the distance to the nearest surface, and between these many pixels wide, seen from the camera. */
#define ZONE_SHARE .5f
#define LEAST_PIXELS 4.0f
#define MOST_PIXELS 24.0f
/* Look-ups reach 1.5 radii: a point has some three records. */
#define STRETCH 1.5f

/* Streams of random numbers of their own. */
enum { SEED_PATHS = 101, SEED_DISTANCES, SEED_GATHER, SEED_CHECK };

struct place {
    float3 p, origin, n, ng;
    bool used;
};

static float3 random_direction(float3 n, struct rng *rng)
{
    float u[2] = {rng_float(rng), rng_float(rng)};
    return cosine_direction(n, u);
}

/* Where a path goes on from a surface that transmits. */
static float3 scattered(const struct point *point, struct rng *rng)
{
    float u[3] = {rng_float(rng), rng_float(rng), rng_float(rng)}, pdf;
    float3 dir = {0, 0, 0};
    brdf_sample(&point->brdf, point->n, point->wo, u, &dir, &pdf);
    return dir;
}

/* The points of diffuse paths from the camera, seen through glass and panes: where the cache will be asked. */
static struct place *wanted_places(const struct model *model, uint64_t seed)
{
    const struct scene_camera *camera = &model->scene->camera;
    struct place *places = calloc((size_t)PATHS * BOUNCES, sizeof *places);
    if (!places) return NULL;
#pragma omp parallel for schedule(dynamic, 64)
    for (int i = 0; i < PATHS; i++) {
        struct rng rng = rng_seed(seed, SEED_PATHS, (uint64_t)i);
        /* Pixels by the R2 sequence (Roberts 2018). */
        float x = (float)fmod(.5 + .7548776662466927 * (i + 1), 1),
              y = (float)fmod(.5 + .5698402909980532 * (i + 1), 1);
        struct ray ray = camera_ray(camera, x * (float)camera->width, y * (float)camera->height);
        struct hit hit;
        for (int b = 0, step = 0; b < BOUNCES && step < MOST_STEPS; step++) {
            if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) break;
            struct point point;
            rgb weight = {0};
            shade_point(model, ray, &hit, &point);
            if (pane_pass(&point, &rng, &weight)) {
                ray.origin = shade_origin(&point, ray.dir);
                continue;
            }
            bool transmits = brdf_transmits(&point.brdf);
            float3 dir = transmits ? scattered(&point, &rng) : random_direction(point.n, &rng);
            bool beyond = dot(point.n, dir) < 0;
            struct side side = shade_side(&point, beyond);
            rgb albedo = beyond ? point.brdf.kt : point.brdf.kd;
            if (!transmits || !is_black(albedo))
                places[i * BOUNCES + b++] = (struct place){point.p, side.origin, side.n, side.ng, !is_black(albedo)};
            ray = (struct ray){side.origin, dir};
            if (dot(dir, side.ng) <= 0) break;
        }
    }
    return places;
}

static float zone_radius(const struct model *model, const struct place *place, uint64_t seed, uint64_t index)
{
    struct rng rng = rng_seed(seed, SEED_DISTANCES, index);
    struct gather_grid grid = gather_grid(DISTANCE_RAYS);
    struct frame frame = frame_about(place->n);
    float pixel = camera_pixel_width(&model->scene->camera, place->p);
    float nearest = INFINITY;
    for (int i = 0; i < grid.rows * grid.columns; i++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        struct hit hit;
        float3 dir = to_world(frame, gather_direction(grid, i / grid.columns, i % grid.columns, u, v));
        if (dot(dir, place->ng) > 0 && trace_closest(model->trace, place->origin, dir, INFINITY, &hit))
            nearest = minf(nearest, hit.t);
    }
    return clampf(ZONE_SHARE * nearest, LEAST_PIXELS * pixel, MOST_PIXELS * pixel);
}

/* Records at the wanted places, in rounds: those not covered yet are sized in parallel and inserted in their order. */
static bool place_records(const struct model *model, struct place *places, int paths, uint64_t seed,
                          struct cache *zones, uint32_t **origins)
{
    enum { ROUND = 256 };
    float radii[ROUND];
    uint32_t capacity = 0;
    for (int first = 0; first < paths * BOUNCES; first += ROUND) {
        int count = paths * BOUNCES - first < ROUND ? paths * BOUNCES - first : ROUND;
#pragma omp parallel for schedule(dynamic, 8)
        for (int i = 0; i < count; i++) {
            struct place *place = &places[first + i];
            place->used = place->used && !cache_covers(zones, place->p, place->n);
            if (place->used) radii[i] = zone_radius(model, place, seed, (uint64_t)(first + i));
        }
        for (int i = 0; i < count; i++) {
            struct place *place = &places[first + i];
            if (!place->used || cache_covers(zones, place->p, place->n)) continue;
            if (zones->count == capacity) {
                capacity = capacity ? 2 * capacity : 1024;
                uint32_t *grown = realloc(*origins, capacity * sizeof *grown);
                if (!grown) return false;
                *origins = grown;
            }
            (*origins)[zones->count] = (uint32_t)(first + i);
            if (!cache_insert(zones, (struct zone){place->p, place->n, radii[i]}, radii[i] * .25f)) return false;
        }
    }
    return cache_reindex(zones);
}

/* What a record receives: a constant and a share of other records. */
struct row {
    rgb constant;
    struct gather_terms terms;
};

/* By side x side rays. */
static void gather_row(const struct model *model, const struct diffuse_cache *cache, const struct place *place,
                       int side, uint64_t seed, uint64_t index, struct row *row)
{
    struct rng rng = rng_seed(seed, SEED_GATHER, index);
    float weight = PI / (float)(side * side);
    for (int i = 0; i < side * side; i++) {
        /* Stratified, cosine-weighted. */
        float u[2] = {((float)(i / side) + rng_float(&rng)) / (float)side,
                      ((float)(i % side) + rng_float(&rng)) / (float)side};
        float3 dir = cosine_direction(place->n, u);
        if (dot(dir, place->ng) <= 0) continue;
        uint32_t first = row->terms.count;
        struct gathered light = gather(model, cache, (struct ray){place->origin, dir}, &rng, &row->terms);
        row->constant = mad(row->constant, gathered_diffuse(&light, cache), weight);
        for (uint32_t k = first; k < row->terms.count; k++)
            row->terms.terms[k].coefficient = scale(row->terms.terms[k].coefficient, weight);
    }
    struct side above = {place->origin, place->n, place->ng};
    row->constant = add(row->constant, caustics_irradiance(model, &cache->caustics, place->p, above, NULL, &rng));
}

/* e = constant + terms e, by Jacobi's iteration: each step is one more bounce. */
static bool solve(const struct row *rows, uint32_t count, rgb *e)
{
    rgb *next = malloc(count * sizeof *next);
    if (!next) return false;
    for (uint32_t i = 0; i < count; i++) e[i] = rows[i].constant;
    double change = 1, size = 1;
    for (int step = 0; step < SOLVE_STEPS && change > 1e-4 * size; step++) {
#pragma omp parallel for schedule(static)
        for (uint32_t i = 0; i < count; i++) {
            rgb sum = rows[i].constant;
            for (uint32_t k = 0; k < rows[i].terms.count; k++)
                sum = add(sum, mul(rows[i].terms.terms[k].coefficient, e[rows[i].terms.terms[k].record]));
            next[i] = sum;
        }
        change = size = 0;
        for (uint32_t i = 0; i < count; i++) {
            change += fabsf(luminance(next[i]) - luminance(e[i]));
            size += luminance(next[i]);
        }
        memcpy(e, next, count * sizeof *next);
    }
    free(next);
    return true;
}

bool diffuse_cache_build(const struct model *model, int coarseness, uint64_t seed, struct progress *progress,
                         struct diffuse_cache *cache, char error[static SCENE_ERROR])
{
    int paths = coarseness ? PATHS / 4 : PATHS, side = coarseness ? GATHER_SIDE / 2 : GATHER_SIDE;
    *cache = (struct diffuse_cache){.zones = cache_empty(STRETCH)};
    uint32_t *origins = NULL;
    struct row *rows = NULL;
    rgb *e = NULL;
    bool ok = false;
    struct place *places = wanted_places(model, seed);
    if (!places || !place_records(model, places, paths, seed, &cache->zones, &origins) ||
        !caustics_build(model, seed, &cache->caustics))
        goto done;
    uint32_t count = cache->zones.count, finished = 0;
    rows = calloc(count + 1, sizeof *rows);
    e = malloc((count + 1) * sizeof *e);
    if (!rows || !e) goto done;
#pragma omp parallel for schedule(dynamic, 8)
    for (uint32_t i = 0; i < count; i++) {
        gather_row(model, cache, &places[origins[i]], side, seed, i, &rows[i]);
        uint32_t so_far;
#pragma omp atomic capture
        so_far = ++finished;
        progress_show(progress, (double)so_far / count);
    }
    ok = true;
    for (uint32_t i = 0; i < count; i++) ok = ok && !rows[i].terms.failed;
    ok = ok && solve(rows, count, e);
done:
    for (uint32_t i = 0; rows && i < cache->zones.count; i++) free(rows[i].terms.terms);
    free(rows);
    free(origins);
    free(places);
    if (ok) {
        cache->e = e;
    } else {
        free(e);
        diffuse_cache_free(cache);
        snprintf(error, SCENE_ERROR, "diffuse cache: out of memory");
    }
    return ok;
}

void diffuse_cache_free(struct diffuse_cache *cache)
{
    cache_free(&cache->zones);
    caustics_free(&cache->caustics);
    free(cache->e);
    *cache = (struct diffuse_cache){0};
}

rgb diffuse_cache_mean(const struct diffuse_cache *cache, const struct cache_match *matches, int count)
{
    rgb e = {0};
    for (int i = 0; i < count; i++) e = mad(e, cache->e[matches[i].record], matches[i].weight);
    return e;
}

double diffuse_cache_error(const struct model *model, const struct diffuse_cache *cache, uint64_t seed)
{
    struct place *places = wanted_places(model, seed + SEED_CHECK);
    if (!places) return 0;
    double squares = 0, sum = 0;
    int count = 0;
    /* The second points of paths: where gather rays end. */
#pragma omp parallel for schedule(dynamic, 4) reduction(+ : squares, sum, count)
    for (int i = 0; i < CHECK_POINTS; i++) {
        const struct place *place = &places[i * (PATHS / CHECK_POINTS) * BOUNCES + 1];
        struct cache_match matches[CACHE_MATCHES];
        int found = place->used ? cache_find(&cache->zones, place->p, place->n, matches) : 0;
        if (!found) continue;
        rgb halves[2] = {{0}}, e = diffuse_cache_mean(cache, matches, found);
        struct rng rng = rng_seed(seed, SEED_CHECK, (uint64_t)i);
        for (int k = 0; k < 2 * CHECK_RAYS; k++) {
            struct ray ray = {place->origin, random_direction(place->n, &rng)};
            if (dot(ray.dir, place->ng) > 0)
                halves[k & 1] = mad(halves[k & 1], path_incident(model, ray, &rng), PI / CHECK_RAYS);
        }
        rgb a = sub(e, halves[0]), b = sub(e, halves[1]);
        squares += (double)a.x * b.x + (double)a.y * b.y + (double)a.z * b.z;
        sum += .5 * ((double)halves[0].x + halves[1].x + halves[0].y + halves[1].y + halves[0].z + halves[1].z);
        count++;
    }
    free(places);
    return sum > 0 ? sqrt(fmax(squares / (3 * count), 0)) / (sum / (3 * count)) : 0;
}

size_t diffuse_cache_bytes(const struct diffuse_cache *cache)
{
    return cache_bytes(&cache->zones) + caustics_bytes(&cache->caustics) + cache->zones.count * sizeof *cache->e;
}
