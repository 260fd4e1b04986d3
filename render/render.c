/* SPDX-License-Identifier: Apache-2.0 */
#include "render/render.h"

#include <omp.h>
#include <stdio.h>

#include "render/direct.h"
#include "render/fill.h"
#include "render/gather.h"
#include "render/path.h"
#include "render/sequence.h"

enum { SEED_PATH = 301, SEED_CACHE, MOST_GROUPS = 16, PATH_SPP = 64, CACHE_SPP = 16 };

/* Samples of a pixel that share a look-up: the same object and material, normals within 3.6 degrees. */
#define GROUP_COSINE .998f

struct frame_job {
    const struct model *model;
    const struct render_options *options;
    const struct fill *fill; /* NULL for path */
    struct direct direct;    /* unused by path */
    int spp;
};

/* Whether the point's lobes are taken from EAS; if not, they are traced. */
static bool caches_lobes(const struct frame_job *job, const struct point *point)
{
    return job->options->method == RENDER_EAS && point->brdf.lobe_count > 0 && direct_resolves(&point->brdf);
}

static void add_surface(struct pixel *pixel, const struct point *point, float t)
{
    pixel->albedo = add(pixel->albedo, point->brdf.kd);
    for (int i = 0; i < point->brdf.lobe_count; i++)
        pixel->albedo = add(pixel->albedo, point->brdf.lobes[i].weight);
    pixel->normal = add(pixel->normal, point->n);
    pixel->depth += t;
    pixel->hits += 1;
    pixel->emission = add(pixel->emission, point->emission);
}

/* One camera ray of sample i: false where it sees the background, which is then added. */
static bool camera_sample(const struct frame_job *job, int x, int y, float2 jitter, struct pixel *pixel, struct point *point)
{
    struct ray ray = camera_ray(&job->model->scene->camera, (float)x + jitter.x, (float)y + jitter.y);
    struct hit hit;
    float pdf;
    pixel->samples += 1;
    if (!trace_closest(job->model->trace, ray.origin, ray.dir, INFINITY, &hit)) {
        const struct lights *lights = job->model->lights;
        rgb sky = add(lights_strong(lights, ray.origin, ray.dir, ray.dir, &pdf), lights_rest(lights, ray.dir));
        pixel->emission = add(pixel->emission, sky);
        return false;
    }
    shade_point(job->model, ray, &hit, point);
    add_surface(pixel, point, hit.t);
    return true;
}

static void path_pixel(const struct frame_job *job, int x, int y, struct pixel *pixel)
{
    uint64_t index = (uint64_t)(y * job->model->scene->camera.width + x);
    for (int i = 0; i < job->spp; i++) {
        struct rng rng = rng_seed(job->options->seed ^ (uint64_t)SEED_PATH << 32, index, (uint64_t)i);
        float2 jitter = {rng_float(&rng), rng_float(&rng)};
        struct point point;
        if (!camera_sample(job, x, y, jitter, pixel, &point))
            continue;
        struct radiance radiance = path_radiance(job->model, &point, &rng);
        pixel->direct = add(pixel->direct, radiance.direct);
        pixel->indirect = add(pixel->indirect, radiance.indirect);
    }
}

/* Points of a pixel that are alike; sums until it is looked up. */
struct group {
    struct point point; /* the first; p, origin, n, wo and kd become sums */
    float count;
    struct direct_share share;
};

/* The group that the point joins. */
static struct group *group_of(struct group groups[MOST_GROUPS], int *group_count, const struct point *point)
{
    for (int i = 0; i < *group_count; i++) {
        struct group *g = &groups[i];
        bool alike = g->point.object == point->object && g->point.material == point->material &&
                     dot(g->point.n, point->n) >= GROUP_COSINE * g->count;
        if (!alike && i < MOST_GROUPS - 1)
            continue;
        g->point.p = add(g->point.p, point->p);
        g->point.origin = add(g->point.origin, point->origin);
        g->point.n = add(g->point.n, point->n);
        g->point.wo = add(g->point.wo, point->wo);
        g->point.brdf.kd = add(g->point.brdf.kd, point->brdf.kd);
        g->count += 1;
        return g;
    }
    struct group *g = &groups[(*group_count)++];
    *g = (struct group){.point = *point, .count = 1};
    return g;
}

static struct point group_mean(const struct group *group)
{
    struct point point = group->point;
    float share = 1 / group->count;
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

/* Light of the lobes by one traced ray each, u two numbers in [0, 1). `lamps`: what lamps send directly counts, with the MIS weight against
 * direct_sample. */
static rgb traced_lobes(const struct frame_job *job, const struct point *point, float2 u, bool lamps, struct rng *rng)
{
    rgb sum = {0};
    for (int i = 0; i < point->brdf.lobe_count; i++) {
        float v[2] = {u.x, u.y}, pdf;
        float3 wi;
        rgb weight = lobe_sample(&point->brdf.lobes[i], point->n, point->wo, v, &wi, &pdf);
        if (is_black(weight) || dot(wi, point->ng) <= 0)
            continue;
        struct ray ray = {point->origin, wi};
        if (lamps) {
            sum = add(sum, mul(weight, gather_specular(job->model, &job->fill->bounced, ray, point->n, pdf, rng)));
        } else {
            struct gathered light = gather(job->model, &job->fill->bounced, ray, rng, NULL);
            sum = add(sum, mul(weight, add(light.surface, light.mirrored)));
        }
    }
    return sum;
}

/* Where the cache has nothing: the light of one diffuse and one specular ray. */
static rgb traced_indirect(const struct frame_job *job, const struct point *point, struct rng *rng)
{
    rgb sum = {0};
    if (!is_black(point->brdf.kd)) {
        float r = sqrtf(rng_float(rng)), phi = 2 * PI * rng_float(rng);
        float3 dir = to_world(frame_about(point->n), vec3(r * cosf(phi), r * sinf(phi), sqrtf(maxf(1 - r * r, 0))));
        if (dot(dir, point->ng) > 0) {
            struct gathered light = gather(job->model, &job->fill->bounced, (struct ray){point->origin, dir}, rng, NULL);
            sum = mul(point->brdf.kd, add(light.surface, light.mirrored));
        }
    }
    return add(sum, traced_lobes(job, point, (float2){rng_float(rng), rng_float(rng)}, false, rng));
}

/* Bounced light at the mean of a group, from the cache. */
static void look_up(const struct frame_job *job, const struct group *group, struct pixel *pixel, struct rng *rng)
{
    struct point point = group_mean(group);
    bool eas = caches_lobes(job, &point);
    if (!eas && is_black(point.brdf.kd))
        return;
    const struct record_cache *cache = eas ? &job->fill->glossy : &job->fill->diffuse;
    struct cache_match matches[CACHE_MATCHES];
    int count = cache_find(&cache->zones, point.p, point.n, matches), best = 0;
    if (!count) {
        if (!eas)
            point.brdf.lobe_count = 0; /* traced already */
        int rays = (int)group->count;
        for (int i = 0; i < rays; i++)
            pixel->indirect = add(pixel->indirect, traced_indirect(job, &point, rng));
        return;
    }
    rgb e = {0}, specular = {0};
    struct mean_lobe lobes[2];
    for (int k = 0; eas && k < point.brdf.lobe_count; k++)
        lobes[k] = mean_lobe(job->fill->tables, &point.brdf.lobes[k], point.n, point.wo);
    for (int i = 0; i < count; i++) {
        const struct zone *zone = &cache->zones.zones[matches[i].record];
        const struct record *record = &cache->records[matches[i].record];
        e = mad(e, irradiance_at(&record->irradiance, zone->p, zone->n, point.p, point.n), matches[i].weight);
        for (int k = 0; eas && k < point.brdf.lobe_count; k++)
            specular = mad(specular, eas_reflect(cache->eas + record->first_eas, record->eas_count, &lobes[k], point.p),
                           matches[i].weight);
        pixel->eas_count += (float)record->eas_count;
        if (matches[i].weight > matches[best].weight)
            best = i;
    }
    rgb indirect = add(specular, mul(point.brdf.kd, scale(e, 1 / PI)));
    pixel->indirect = mad(pixel->indirect, indirect, group->count);
    pixel->records = mad(pixel->records, record_colour(matches[best].record), group->count * matches[best].weight);
}

static void cache_pixel(const struct frame_job *job, int x, int y, struct pixel *pixel)
{
    uint64_t index = (uint64_t)(y * job->model->scene->camera.width + x);
    struct rng rng = rng_seed(job->options->seed ^ (uint64_t)SEED_CACHE << 32, index, 0);
    struct sequence place = sequence_draw(&rng, job->spp), lamp = sequence_draw(&rng, job->spp),
                    lobe = sequence_draw(&rng, job->spp);
    float turn = rng_float(&rng);
    struct group groups[MOST_GROUPS];
    int group_count = 0;
    for (int i = 0; i < job->spp; i++) {
        float2 jitter = sequence_point(place, i), on_lamp = sequence_point(lamp, i);
        /* Lamps (and their triangles) in turn: each then has a run of the sequence, which is spread well in itself. */
        float u[3] = {((float)i + turn) / (float)job->spp, on_lamp.x, on_lamp.y};
        struct point point;
        if (!camera_sample(job, x, y, jitter, pixel, &point))
            continue;
        struct group *group = group_of(groups, &group_count, &point);
        pixel->direct = add(pixel->direct, direct_sample(&job->direct, &point, u, &group->share));
        if (!caches_lobes(job, &point)) {
            bool lamps = !direct_resolves(&point.brdf);
            pixel->indirect = add(pixel->indirect, traced_lobes(job, &point, sequence_point(lobe, i), lamps, &rng));
        }
    }
    for (int i = 0; i < group_count; i++) {
        look_up(job, &groups[i], pixel, &rng);
        struct point point = group_mean(&groups[i]);
        pixel->direct = mad(pixel->direct, direct_light(&job->direct, &point, &groups[i].share), groups[i].count);
    }
}

static void render_pixels(const struct frame_job *job, struct progress *progress, struct film *film)
{
    int finished = 0;
#pragma omp parallel for schedule(dynamic, 1)
    for (int y = 0; y < film->height; y++) {
        for (int x = 0; x < film->width; x++) {
            struct pixel *pixel = &film->pixels[y * film->width + x];
            if (job->fill)
                cache_pixel(job, x, y, pixel);
            else
                path_pixel(job, x, y, pixel);
        }
        int so_far;
#pragma omp atomic capture
        so_far = ++finished;
        if (omp_get_thread_num() == 0)
            progress_show(progress, (double)so_far / film->height);
    }
}

static void report(const struct model *model, const struct fill *fill, uint64_t seed, struct render_stats *stats)
{
    stats->records = fill->diffuse.zones.count + fill->glossy.zones.count;
    stats->glossy_records = fill->glossy.zones.count;
    stats->eas_per_record = stats->glossy_records ? (double)fill->glossy.eas_count / (double)stats->glossy_records : 0;
    stats->cache_bytes = fill_bytes(fill);
    stats->diffuse_records = fill->bounced.zones.count;
    stats->diffuse_cv = diffuse_cache_error(model, &fill->bounced, seed);
}

bool render(const struct model *model, const struct render_options *options, struct progress *progress,
            struct film *film, struct render_stats *stats, char error[static SCENE_ERROR])
{
    bool cached = options->method != RENDER_PATH;
    struct frame_job job = {model, options, NULL, {0}, options->spp ? options->spp : cached ? CACHE_SPP : PATH_SPP};
    struct fill fill;
    *stats = (struct render_stats){0};
    if (!film_alloc(film, model->scene->camera.width, model->scene->camera.height, cached)) {
        snprintf(error, SCENE_ERROR, "picture: out of memory");
        return false;
    }
    if (cached) {
        if (!fill_build(model, options->method == RENDER_EAS, options->seed, progress, &fill, error)) {
            film_free(film);
            return false;
        }
        job.fill = &fill;
        if (!direct_prepare(model, fill.tables, job.spp, &job.direct)) {
            fill_free(&fill);
            film_free(film);
            snprintf(error, SCENE_ERROR, "lamps: out of memory");
            return false;
        }
    }
    progress_begin(progress, "pixels", trace_rays(model->trace));
    render_pixels(&job, progress, film);
    progress_end(progress, trace_rays(model->trace));
    if (cached) {
        report(model, &fill, options->seed, stats);
        direct_free(&job.direct);
        fill_free(&fill);
    }
    return true;
}
