/* SPDX-License-Identifier: Apache-2.0 */
#include "render/cached.h"

#include <stdlib.h>

#include "render/gather.h"
#include "render/primary.h"
#include "render/sequence.h"

/* Samples of a pixel that are grouped together: a power of two, for the sequence. */
enum { SEED_PIXEL = 401, BATCH = 64 };

/* Rays a camera ray. Shadow rays: to lamps; under an environment alone, which comes from all sides. By each lobe that
 * is traced, and by diffuse parts that have no record. Powers of two, for the sequence, but the sky's. */
enum { SHADOW_RAYS = 8, SKY_RAYS = 12, LOBE_RAYS = 4 };

/* Points where caches are checked, and lamp samples there. */
enum { CHECK_POINTS = 2048, CHECK_RAYS = 4, SEED_CHECK = 402 };
#define MOST_LONELY .8 /* sum of the squares of weights, 1 where there is one record */

/* Points that share a look-up: the same object and material, normals within 3.6 degrees and this share of the narrowest
 * lobe's width. A highlight turns by twice the normal's angle: with normals spread evenly over 2w/8 the light at their
 * mean is within 2 % of theirs, and within 8 % over twice that. */
#define GROUP_ANGLE .063f
#define GROUP_LOBE (1.0f / 8)

bool cached_prepare(const struct model *model, const struct fill *fill, struct cached *cached)
{
    *cached = (struct cached){.model = model, .fill = fill};
    return direct_prepare(model, fill->tables, fill->options.lamps, &cached->direct);
}

void cached_free(struct cached *cached) { direct_free(&cached->direct); }

/* Points of a pixel that are alike; sums until it is looked up. */
struct group {
    struct point point; /* the first; p, origin, n, wo and kd become sums */
    float3 origins[BATCH];
    int count;
    float cosine; /* the farthest normals that join */
    bool averages, near; /* direct_averages and direct_near at the first */
};

/* Of the angle that normals of a group stand apart from their mean. */
static float group_cosine(const struct brdf *brdf)
{
    float angle = GROUP_ANGLE;
    for (int i = 0; i < brdf->lobe_count; i++) angle = minf(angle, GROUP_LOBE * lobe_width(&brdf->lobes[i]));
    return cosf(angle);
}

/* The group that the point joins. */
static struct group *group_of(const struct direct *direct, struct group groups[BATCH], int *group_count,
                              const struct point *point)
{
    for (int i = 0; i < *group_count; i++) {
        struct group *g = &groups[i];
        if (g->point.object != point->object || g->point.material != point->material ||
            dot(g->point.n, point->n) < g->cosine * (float)g->count)
            continue;
        g->point.p = add(g->point.p, point->p);
        g->point.origin = add(g->point.origin, point->origin);
        g->point.n = add(g->point.n, point->n);
        g->point.wo = add(g->point.wo, point->wo);
        g->point.brdf.kd = add(g->point.brdf.kd, point->brdf.kd);
        g->origins[g->count++] = point->origin;
        return g;
    }
    struct group *g = &groups[(*group_count)++];
    *g = (struct group){.point = *point,
                        .origins = {point->origin},
                        .count = 1,
                        .cosine = group_cosine(&point->brdf),
                        .averages = direct_averages(direct, point),
                        .near = !direct->points_only && !direct->sky && direct_near(direct->model, point)};
    return g;
}

static struct point group_mean(const struct group *group)
{
    struct point point = group->point;
    float share = 1 / (float)group->count;
    point.p = scale(point.p, share);
    point.origin = scale(point.origin, share);
    point.n = normalize(point.n);
    point.wo = normalize(point.wo);
    point.brdf.kd = scale(point.brdf.kd, share);
    return point;
}

/* A colour of its own for each record, for the AOV that shows the zones. */
static rgb record_colour(uint32_t record)
{
    uint64_t h = rng_mix(record + 1);
    return vec3(.2f + .8f * (float)(h & 255) / 255, .2f + .8f * (float)(h >> 8 & 255) / 255,
                .2f + .8f * (float)(h >> 16 & 255) / 255);
}

/* Light that bounced, and that of lamps where records hold it. */
static struct gathered traced(const struct cached *cached, struct ray ray, struct rng *rng)
{
    const struct diffuse_cache *bounced = &cached->fill->bounced;
    return cached->fill->options.lamps ? gather_all(cached->model, bounced, ray, rng)
                                       : gather(cached->model, bounced, ray, rng, NULL);
}

/* Light of one lobe by a traced ray, u two numbers in [0, 1). *lamps, where it isn't NULL, grows by what lamps send
 * directly, with the MIS weight against direct_sample. */
static rgb traced_lobe(const struct cached *cached, const struct point *point, const struct lobe *lobe, float2 u,
                       rgb *lamps, struct rng *rng)
{
    float v[2] = {u.x, u.y}, pdf;
    float3 wi;
    rgb weight = lobe_sample(lobe, point->n, point->wo, v, &wi, &pdf), lamp;
    struct side side = shade_side(point, lobe_transmits(lobe));
    if (is_black(weight) || dot(wi, side.ng) <= 0) return vec3(0, 0, 0);
    struct ray ray = {side.origin, wi};
    struct gathered light =
        lamps ? gather_specular(cached->model, &cached->fill->bounced, ray, side.n, pdf, rng, &lamp)
              : traced(cached, ray, rng);
    if (lamps) *lamps = add(*lamps, mul(weight, lamp));
    return mul(weight, add(light.surface, light.mirrored));
}

/* Bounced light of a diffuse part by a traced ray, photons apart; u: two numbers in [0, 1). */
static rgb traced_diffuse(const struct cached *cached, struct side side, rgb albedo, float2 u, struct rng *rng)
{
    if (is_black(albedo)) return albedo;
    float v[2] = {u.x, u.y};
    float3 dir = cosine_direction(side.n, v);
    if (dot(dir, side.ng) <= 0) return vec3(0, 0, 0);
    struct gathered light = traced(cached, (struct ray){side.origin, dir}, rng);
    return mul(albedo, gathered_diffuse(&light, &cached->fill->bounced));
}

/* What photons bring to a diffuse part. */
static rgb caustic(const struct cached *cached, float3 p, struct side side, rgb albedo, struct caustics_memory *places,
                   struct rng *rng)
{
    const struct caustics *caustics = &cached->fill->bounced.caustics;
    if (is_black(albedo)) return albedo;
    return scale(mul(albedo, caustics_irradiance(cached->model, caustics, p, side, places, rng)), 1 / PI);
}

/* Where the cache has nothing: the light by a ray, u two numbers in [0, 1), for the diffuse part and each lobe. */
static rgb traced_indirect(const struct cached *cached, const struct point *point, float2 u, struct rng *rng)
{
    rgb sum = traced_diffuse(cached, shade_side(point, false), point->brdf.kd, u, rng);
    for (int i = 0; i < point->brdf.lobe_count; i++)
        sum = add(sum, traced_lobe(cached, point, &point->brdf.lobes[i], u, NULL, rng));
    return sum;
}

/* One lobe at a point, as the records of a cache see it. */
union lobe_view {
    struct mean_lobe mean;
    struct hsh_view hsh;
};

static void view_lobe(const struct fill *fill, const struct lobe *lobe, const struct point *point,
                      union lobe_view *view)
{
    if (fill->hsh) view->hsh = hsh_view(fill->hsh, lobe, point->n, point->wo);
    else view->mean = mean_lobe(fill->tables, lobe, point->n, point->wo);
}

static rgb reflect_record(const struct fill *fill, const struct record *record, const struct zone *zone,
                          const union lobe_view *view, float3 p)
{
    const struct record_cache *cache = &fill->glossy;
    if (!fill->hsh) return eas_reflect(cache->eas + record->first_eas, record->eas_count, &view->mean, p);
    return hsh_reflect(fill->hsh, &view->hsh, cache->hsh + record->first_hsh, record->hsh_order, zone->n,
                       sub(p, zone->p));
}

/* Bounced light that a point sends back by one record: of the diffuse part, and of the lobes where `glossy`. */
static rgb record_light(const struct fill *fill, const struct record_cache *cache, const struct cache_match *match,
                        bool glossy, const union lobe_view *views, const struct point *point)
{
    const struct zone *zone = &cache->zones.zones[match->record];
    const struct record *record = &cache->records[match->record];
    rgb e = irradiance_at(&record->irradiance, zone->p, zone->n, point->p, point->n);
    rgb light = mul(point->brdf.kd, scale(e, 1 / PI));
    for (int k = 0; glossy && k < point->brdf.lobe_count; k++)
        light = add(light, reflect_record(fill, record, zone, &views[k], point->p));
    return light;
}

/* Bounced light at a group's mean, from the cache; lobes that it can't resolve are left out. */
static void look_up(const struct cached *cached, const struct group *group, struct caustics_memory *places,
                    struct pixel *pixel, struct rng *rng)
{
    struct point point = group_mean(group);
    float samples = (float)group->count;
    bool glossy = fill_has_glossy(cached->fill) && point.brdf.lobe_count > 0;
    if (!glossy && is_black(point.brdf.kd)) return;
    const struct record_cache *cache = glossy ? &cached->fill->glossy : &cached->fill->diffuse;
    struct cache_match matches[CACHE_MATCHES];
    int count = cache_find(&cache->zones, point.p, point.n, matches), best = 0;
    rgb by_photons = caustic(cached, point.p, shade_side(&point, false), point.brdf.kd, places, rng);
    pixel->indirect = mad(pixel->indirect, by_photons, samples);
    if (!count) {
        const int rays = group->count * LOBE_RAYS;
        struct sequence sequence = sequence_draw(rng, rays);
        if (!glossy) point.brdf.lobe_count = 0; /* traced already */
        for (int i = 0; i < rays; i++) {
            point.origin = group->origins[i / LOBE_RAYS]; /* on a curved surface the mean lies beneath it */
            rgb light = traced_indirect(cached, &point, sequence_point(sequence, i), rng);
            pixel->indirect = mad(pixel->indirect, light, 1.0f / LOBE_RAYS);
        }
        return;
    }
    rgb indirect = {0};
    union lobe_view views[BRDF_LOBES];
    for (int k = 0; glossy && k < point.brdf.lobe_count; k++)
        view_lobe(cached->fill, &point.brdf.lobes[k], &point, &views[k]);
    for (int i = 0; i < count; i++) {
        rgb light = record_light(cached->fill, cache, &matches[i], glossy, views, &point);
        indirect = mad(indirect, light, matches[i].weight);
        pixel->eas_count += (float)cache->records[matches[i].record].eas_count;
        if (matches[i].weight > matches[best].weight) best = i;
    }
    indirect = vec3(maxf(indirect.x, 0), maxf(indirect.y, 0), maxf(indirect.z, 0)); /* HSH ring */
    pixel->indirect = mad(pixel->indirect, indirect, samples);
    pixel->records = mad(pixel->records, record_colour(matches[best].record), samples * matches[best].weight);
}

/* Samples first .. first + count of a pixel. */
static void add_batch(const struct cached *cached, int x, int y, int first, int count, uint64_t seed,
                      struct shadow_memory *memory, struct pixel *pixel)
{
    uint64_t index = (uint64_t)(y * cached->model->scene->camera.width + x);
    struct rng rng = rng_seed(seed ^ (uint64_t)SEED_PIXEL << 32, index, (uint64_t)first);
    const int lamps_count = count * SHADOW_RAYS;
    struct sequence place = sequence_draw(&rng, count), lamp = sequence_draw(&rng, lamps_count),
                    lobe = sequence_draw(&rng, count * LOBE_RAYS);
    bool blurred = camera_has_lens(&cached->model->scene->camera);
    struct sequence lens = {0};
    if (blurred) lens = sequence_draw(&rng, count);
    float turn = rng_float(&rng);
    struct group groups[BATCH];
    struct caustics_memory places = {.count = 0};
    int group_count = 0;
    for (int i = 0; i < count; i++) {
        float2 jitter = sequence_point(place, i), on_lens = {0, 0};
        if (blurred) on_lens = sequence_point(lens, i);
        struct point point;
        if (!primary(cached->model, (float)x + jitter.x, (float)y + jitter.y, on_lens, &rng, pixel, &point)) continue;
        /* The group has the lobes that are resolved. */
        int lobes = point.brdf.lobe_count, resolved = direct_sort(&point.brdf);
        point.brdf.lobe_count = resolved;
        const struct group *group = group_of(&cached->direct, groups, &group_count, &point);
        point.brdf.lobe_count = lobes;
        int averaged = group->averages ? resolved : 0,
            recorded = fill_has_glossy(cached->fill) ? resolved : 0;
        struct light_weights weights;
        lights_weigh(cached->model->lights, point.origin, point.n, &weights);
        for (int k = i * SHADOW_RAYS; k < (i + 1) * SHADOW_RAYS; k++) {
            float2 on_lamp = sequence_point(lamp, k);
            /* Lamps (and their triangles) in turn: each then has a run of the sequence, which is spread well in itself.
             */
            float u[3] = {((float)k + turn) / (float)lamps_count, on_lamp.x, on_lamp.y};
            rgb light = direct_sample(&cached->direct, &point, &weights, u, averaged, group->near);
            if (group->near) {
                float v[2] = {rng_float(&rng), rng_float(&rng)};
                light = add(light, direct_met(cached->model, &point, v));
            }
            pixel->direct = mad(pixel->direct, light, 1.0f / SHADOW_RAYS);
        }
        rgb lamps = {0}, bounced = {0};
        for (int k = averaged < recorded ? averaged : recorded; k < lobes; k++) {
            bool lamps_too = k >= averaged && !cached->direct.points_only;
            for (int j = i * LOBE_RAYS; j < (i + 1) * LOBE_RAYS; j++) {
                rgb light = traced_lobe(cached, &point, &point.brdf.lobes[k], sequence_point(lobe, j),
                                        lamps_too ? &lamps : NULL, &rng);
                if (k >= recorded) bounced = add(bounced, light);
            }
        }
        pixel->direct = mad(pixel->direct, lamps, 1.0f / LOBE_RAYS);
        pixel->indirect = mad(pixel->indirect, bounced, 1.0f / LOBE_RAYS);
        if (is_black(point.brdf.kt)) continue;
        struct side beyond = shade_side(&point, true);
        float2 u = {rng_float(&rng), rng_float(&rng)};
        rgb diffuse = traced_diffuse(cached, beyond, point.brdf.kt, u, &rng),
            by_photons = caustic(cached, point.p, beyond, point.brdf.kt, &places, &rng);
        pixel->indirect = add(pixel->indirect, add(diffuse, by_photons));
    }
    for (int i = 0; i < group_count; i++) {
        struct point point = group_mean(&groups[i]);
        float samples = (float)groups[i].count;
        int rays = cached->direct.sky ? SKY_RAYS : SHADOW_RAYS;
        look_up(cached, &groups[i], &places, pixel, &rng);
        rgb light = direct_light(&cached->direct, &point, groups[i].averages, groups[i].origins, groups[i].count,
                                 rays * groups[i].count, memory, &rng);
        pixel->direct = mad(pixel->direct, light, samples);
    }
}

void cached_pixel(const struct cached *cached, int x, int y, int spp, uint64_t seed, struct shadow_memory *memory,
                  struct pixel *pixel)
{
    for (int first = 0; first < spp; first += BATCH)
        add_batch(cached, x, y, first, spp - first < BATCH ? spp - first : BATCH, seed, memory, pixel);
}

/* A point of the picture where records are compared. */
struct check {
    double square; /* expected square of the error of their mean */
    rgb light;     /* in all, but emission */
    bool used;
};

static struct check check_point(const struct cached *cached, uint64_t seed, uint64_t i)
{
    const struct scene_camera *camera = &cached->model->scene->camera;
    const struct fill *fill = cached->fill;
    struct rng rng = rng_seed(seed ^ (uint64_t)SEED_CHECK << 32, i, 0);
    /* Pixels by the R2 sequence (Roberts 2018). */
    float x = (float)fmod(.5 + .7548776662466927 * (double)(i + 1), 1),
          y = (float)fmod(.5 + .5698402909980532 * (double)(i + 1), 1);
    struct pixel pixel = {.samples = 0};
    struct point point;
    struct check check = {.used = false};
    if (!primary(cached->model, x * (float)camera->width, y * (float)camera->height, (float2){.5f, .5f}, &rng, &pixel,
                 &point) ||
        !is_black(pixel.emission))
        return check;
    for (int k = 0; k < CHECK_RAYS; k++) {
        float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)};
        check.light = mad(check.light, shade_direct(cached->model, &point, u, true), 1.0f / CHECK_RAYS);
    }
    point.brdf.lobe_count = direct_sort(&point.brdf);
    bool glossy = fill_has_glossy(fill) && point.brdf.lobe_count > 0;
    const struct record_cache *cache = glossy ? &fill->glossy : &fill->diffuse;
    struct cache_match matches[CACHE_MATCHES];
    union lobe_view views[BRDF_LOBES];
    rgb each[CACHE_MATCHES], mean = {0};
    int count = cache_find(&cache->zones, point.p, point.n, matches);
    double spread = 0, squares = 0; /* of the records about their mean; of the weights */
    for (int k = 0; glossy && k < point.brdf.lobe_count; k++) view_lobe(fill, &point.brdf.lobes[k], &point, &views[k]);
    for (int k = 0; k < count; k++) {
        each[k] = record_light(fill, cache, &matches[k], glossy, views, &point);
        mean = mad(mean, each[k], matches[k].weight);
        squares += sqr(matches[k].weight);
    }
    for (int k = 0; k < count; k++) {
        rgb d = sub(each[k], mean);
        spread += matches[k].weight * dot(d, d) / 3;
    }
    check.light = add(check.light, mean);
    check.used = squares < MOST_LONELY; /* one alone doesn't say */
    if (check.used) check.square = spread * squares / (1 - squares);
    return check;
}

bool cached_error(const struct cached *cached, uint64_t seed, double *error)
{
    struct check *checks = malloc(CHECK_POINTS * sizeof *checks);
    double squares = 0, sum = 0;
    int count = 0;
    if (!checks) return false;
#pragma omp parallel for schedule(dynamic, 16)
    for (int i = 0; i < CHECK_POINTS; i++) checks[i] = check_point(cached, seed, (uint64_t)i);
    for (int i = 0; i < CHECK_POINTS; i++) {
        if (!checks[i].used) continue;
        squares += checks[i].square;
        sum += ((double)checks[i].light.x + checks[i].light.y + checks[i].light.z) / 3;
        count++;
    }
    free(checks);
    *error = sum > 0 ? sqrt(squares / count) / (sum / count) : 0;
    return true;
}
