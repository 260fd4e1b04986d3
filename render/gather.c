/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather.h"

#include <stdlib.h>

#include "render/direct.h"
#include "render/pane.h"

/* Rays in a chain: glass leads light far within itself. Russian roulette begins after the first continuation. */
enum { MAX_DEPTH = 256 };
#define MOST_SURVIVE .98f

/* Shadow rays where the first ray of a chain ends, under an environment that lights from many sides. Lamp samples among
 * which they choose: a square grid, CANDIDATES a side on glossy surfaces, 1 elsewhere, one more for SKY_RAYS. */
enum { SKY_RAYS = 4, CANDIDATES = 3, MOST_CANDIDATES = (CANDIDATES + 1) * (CANDIDATES + 1) };

/* What stays the same along a chain of rays, and where its light goes. */
struct chain {
    const struct model *model;
    const struct diffuse_cache *cache;
    struct rng *rng;
    struct gather_terms *terms;
    struct gathered *out;
    rgb *lamps;    /* what the first ray meets of lamps, or NULL */
    float largest; /* luminance of the largest part of out->mirrored so far: it decides the distance */
    float power;   /* 2 x the mean curvature of the first hit, 1/m: how it shortens what is seen behind it */
    bool clear;    /* the ray has been refracted only so far: what it meets is seen where it is */
};

static void follow(struct chain *chain, struct ray ray, float3 n, float pdf, rgb throughput, int depth, float before);

/* A lobe as wide as the mean of it over a cap of `omega` sr, by the planar limit: n' = n/(1 + n omega/4pi). */
static struct lobe widened(const struct lobe *lobe, float omega)
{
    struct lobe wide = *lobe;
    wide.exponent /= 1 + wide.exponent * omega * (1 / (4 * PI));
    wide.alpha_x = sqrtf(sqr(wide.alpha_x) + omega * (1 / (2 * PI)));
    wide.alpha_y = sqrtf(sqr(wide.alpha_y) + omega * (1 / (2 * PI)));
    return wide;
}

/* Unshadowed light of one lamp sample at a point. */
struct lamp_light {
    rgb diffuse, specular;
    float3 wi;
    float distance, reach; /* as light_sample's */
};

/* One of `count` lamp samples on a side of the surface: its lobes averaged, where that is wanted and they are resolved,
 * over the part of the lamps that it stands for, or with the MIS weight against sampling each; near: direct_near on
 * this side. False where none arrives. */
static bool candidate(const struct light_weights *weights, const struct point *point, const struct side *side,
                      bool averages, bool near, int count, const float u[static 3], struct lamp_light *out)
{
    const struct brdf *brdf = &point->brdf;
    struct light_sample light;
    if (!lights_sample_weighed(weights, u, &light)) return false;
    float cosine = dot(light.wi, side->n);
    if (cosine <= 0 || dot(light.wi, side->ng) <= 0) return false;
    rgb diffuse = dot(light.wi, point->n) > 0 ? brdf->kd : brdf->kt;
    *out = (struct lamp_light){
        .diffuse = scale(mul(light.weight, diffuse), cosine / PI * direct_weight(near, &light, cosine)),
        .wi = light.wi,
        .distance = light.distance,
        .reach = light.reach};
    for (int i = 0; i < brdf->lobe_count; i++) {
        struct lobe lobe = brdf->lobes[i];
        float weight = cosine;
        if (light.pdf > 0 && averages && direct_resolves(&lobe)) lobe = widened(&lobe, 1 / ((float)count * light.pdf));
        else if (light.pdf > 0) weight *= mis_weight(light.pdf, lobe_pdf(&lobe, point->n, point->wo, light.wi));
        out->specular = mad(out->specular, mul(light.weight, lobe_eval(&lobe, point->n, point->wo, light.wi)), weight);
    }
    return true;
}

/* Light of the lamps at a point by `rays` shadow rays, 1 or SKY_RAYS. They go to lamp samples chosen by the light that
 * each would reflect, and stand for all of them (resampling, Talbot et al. 2005): a highlight then has noise in its
 * shadows alone. Returns how many arrive. */
static int lamp_light(const struct model *model, const struct point *point, bool beyond, bool averages, bool near,
                      int rays, struct rng *rng, struct lamp_light out[SKY_RAYS])
{
    struct side from = shade_side(point, beyond);
    struct light_weights weights;
    struct lamp_light lights[MOST_CANDIDATES];
    float values[MOST_CANDIDATES], u0 = rng_float(rng), sum = 0, passed = 0;
    int side = (point->brdf.lobe_count ? CANDIDATES : 1) + (rays > 1), count = side * side, last = -1, arrived = 0;
    lights_weigh(model->lights, from.origin, from.n, &weights);
    for (int i = 0; i < count; i++) {
        float u1 = rng_float(rng), u2 = rng_float(rng), turn = u0 + (float)i / (float)count;
        float u[3] = {turn < 1 ? turn : turn - 1, ((float)(i / side) + u1) / (float)side,
                      ((float)(i % side) + u2) / (float)side};
        bool any = candidate(&weights, point, &from, averages, near && !beyond, count, u, &lights[i]);
        values[i] = any ? luminance(add(lights[i].diffuse, lights[i].specular)) : 0;
        if (values[i] > 0) last = i;
        sum += values[i];
    }
    float step = sum / (float)rays, start = rng_float(rng);
    for (int k = 0, i = 0; last >= 0 && k < rays; k++) {
        while (i < last && passed + values[i] <= ((float)k + start) * step) passed += values[i++];
        rgb through = pane_transmittance(model, from.origin, lights[i].wi, lights[i].reach);
        if (is_black(through)) continue;
        through = scale(through, step / (values[i] * (float)count));
        out[arrived] = lights[i];
        out[arrived].diffuse = mul(lights[i].diffuse, through);
        out[arrived++].specular = mul(lights[i].specular, through);
    }
    return arrived;
}

/* Distance to the image of what lies `beyond` behind the first hit, itself `before` away. A convex mirror's image is
 * nearer, 1/s = 1/s' + 2/R (the mean of its two foci); a concave one's is farther, to ten times here: the real image in
 * front of it is none that a point nearby sees there. */
static float image_distance(const struct chain *chain, float before, float beyond)
{
    return isinf(beyond) && chain->power == 0 ? INFINITY : before + 1 / maxf(1 / beyond + chain->power, .1f / beyond);
}

/* Adds light that left the first hit: its surface's own at depth 0 with `own`, else mirrored, first sent from
 * `distance`. */
static void add_light(struct chain *chain, rgb light, bool own, float distance)
{
    if (own) {
        chain->out->surface = add(chain->out->surface, light);
        return;
    }
    chain->out->mirrored = add(chain->out->mirrored, light);
    if (luminance(light) > chain->largest) {
        chain->largest = luminance(light);
        chain->out->mirrored_distance = distance;
    }
}

/* The same for lamps that the ray met: those of the first ray are told apart. */
static void add_lamps(struct chain *chain, rgb light, int depth, float distance)
{
    if (is_black(light)) return;
    if (depth == 0 && chain->lamps) *chain->lamps = add(*chain->lamps, light);
    else add_light(chain, light, depth == 0, distance);
    if (depth == 1 && !chain->clear) chain->out->caustic = add(chain->out->caustic, light);
}

static void add_term(struct gather_terms *terms, uint32_t record, rgb coefficient)
{
    if (terms->count == terms->capacity) {
        uint32_t capacity = terms->capacity ? terms->capacity * 2 : 1024;
        struct gather_term *grown = realloc(terms->terms, capacity * sizeof *grown);
        if (!grown) {
            terms->failed = true;
            return;
        }
        terms->terms = grown;
        terms->capacity = capacity;
    }
    terms->terms[terms->count++] = (struct gather_term){record, coefficient};
}

/* Bounced light that a diffuse part of `point`, `length_` away from the ray's origin, sends back: that of the viewer's
 * side or the one beyond. */
static void bounced(struct chain *chain, const struct point *point, bool beyond, float length_, rgb throughput,
                    int depth, bool own, float before)
{
    rgb coefficient = mul(throughput, scale(beyond ? point->brdf.kt : point->brdf.kd, 1 / PI));
    if (is_black(coefficient)) return;
    struct side side = shade_side(point, beyond);
    struct cache_match matches[CACHE_MATCHES];
    const struct cache *zones = &chain->cache->zones;
    int count = cache_find(zones, point->p, side.n, matches), best = 0;
    for (int i = 1; i < count; i++)
        if (matches[i].weight > matches[best].weight) best = i;
    if (count && length_ >= zones->zones[matches[best].record].radius) {
        if (chain->terms) { /* one of the matches, chosen by weight, stands for all: the system stays sparse */
            float u = rng_float(chain->rng);
            int pick = 0;
            while (pick < count - 1 && (u -= matches[pick].weight) >= 0) pick++;
            add_term(chain->terms, matches[pick].record, coefficient);
            return;
        }
        add_light(chain, mul(coefficient, diffuse_cache_mean(chain->cache, matches, count)), own, before);
        return;
    }
    rgb through = scale(coefficient, PI); /* cosine-weighted: f cos / pdf = albedo */
    float survive = depth < 2 ? 1 : minf(max3(through), MOST_SURVIVE);
    if (rng_float(chain->rng) >= survive) return;
    float u[2] = {rng_float(chain->rng), rng_float(chain->rng)};
    float3 dir = cosine_direction(side.n, u);
    if (dot(dir, side.ng) <= 0) return;
    struct gathered inner = {.distance = 0};
    struct chain next = *chain;
    next.out = &inner; /* all that comes by the bounce is this surface's */
    follow(&next, (struct ray){side.origin, dir}, side.n, 0, scale(through, 1 / survive), depth + 1, 0);
    add_light(chain, add(inner.surface, inner.mirrored), own, before);
}

/* Direct light of one lamp sample a side, and the specular continuation. */
static void lit(struct chain *chain, const struct point *point, rgb throughput, int depth, bool own, float before)
{
    const struct brdf *brdf = &point->brdf;
    float weights[BRDF_LOBES] = {0}, total = 0, cos_o = maxf(dot(point->n, point->wo), 0);
    for (int i = 0; i < brdf->lobe_count; i++)
        total += weights[i] = max3(mul(throughput, lobe_albedo(&brdf->lobes[i], cos_o)));
    float survive = depth == 0 ? 1 : minf(total, MOST_SURVIVE);

    struct lamp_light lamps[SKY_RAYS];
    bool near = direct_near(chain->model, point), averages = !near;
    int shadow_rays = depth == 0 && lights_environment(chain->model->lights) ? SKY_RAYS : 1;
    for (int beyond = 0; beyond <= brdf_spreads(brdf); beyond++) {
        int count = lamp_light(chain->model, point, beyond, averages, near, shadow_rays, chain->rng, lamps);
        for (int i = 0; i < count; i++) {
            rgb specular = mul(throughput, lamps[i].specular);
            add_light(chain, mul(throughput, lamps[i].diffuse), own, before);
            if (depth == 0 && !beyond) chain->out->caustic = add(chain->out->caustic, specular);
            add_light(chain, specular, false,
                      depth == 0 ? image_distance(chain, before, lamps[i].distance) : before);
        }
    }
    if (near) {
        float u[2] = {rng_float(chain->rng), rng_float(chain->rng)};
        add_light(chain, mul(throughput, direct_met(chain->model, point, u)), own, before);
    }
    if (total <= 0 || rng_float(chain->rng) >= survive) return;
    float pick = rng_float(chain->rng) * total;
    int k = 0;
    while (k < brdf->lobe_count - 1 && pick >= weights[k]) pick -= weights[k++];
    const struct lobe *lobe = &brdf->lobes[k];
    float v[2] = {rng_float(chain->rng), rng_float(chain->rng)}, pdf;
    float3 wi;
    rgb weight = lobe_sample(lobe, point->n, point->wo, v, &wi, &pdf);
    struct side side = shade_side(point, lobe_transmits(lobe));
    if (is_black(weight) || dot(wi, side.ng) <= 0) return;
    chain->clear = lobe_transmits(lobe) && (depth == 0 || chain->clear);
    follow(chain, (struct ray){side.origin, wi}, side.n, averages && direct_resolves(lobe) ? 0 : pdf,
           scale(mul(throughput, weight), total / (weights[k] * survive)), depth + 1, before);
}

/* `pdf` 0: lamps count 0; INFINITY: in full. n: the normal where the ray starts. before: the length of the chain so
 * far; at depth 1, or once it is no longer clear, the place of what is seen is settled. */
static void follow(struct chain *chain, struct ray ray, float3 n, float pdf, rgb throughput, int depth, float before)
{
    const struct model *model = chain->model;
    const float3 start = ray.origin;
    const bool own = depth == 0, clear = chain->clear && depth > 0;
    float travelled = 0, came = before;
    rgb nearer = {0};
    if (depth >= MAX_DEPTH) return;
    for (;;) { /* straight through panes */
        struct hit hit;
        bool found = trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit);
        float length_ = found ? hit.t += travelled : INFINITY;
        if (own) before = length_;
        else if (clear) before = came + length_;
        else if (depth == 1) before = image_distance(chain, came, length_);
        rgb lamps = {0};
        float lamp_distance = INFINITY;
        if (pdf > 0) {
            rgb met = lights_radiance_lamps(model->lights, start, n, ray.dir, length_, pdf, &lamp_distance);
            lamps = sub(met, nearer);
            nearer = met;
        }
        if (own && pdf == INFINITY && !is_black(lamps)) { /* these lamps aren't where the ray ends */
            add_light(chain, mul(throughput, lamps), false, lamp_distance);
            lamps = vec3(0, 0, 0);
        }
        if (!found) {
            if (own) chain->out->distance = INFINITY;
            if (pdf > 0) {
                float strong_pdf;
                rgb strong = lights_strong(model->lights, start, n, ray.dir, &strong_pdf);
                lamps = mad(lamps, strong, mis_weight(pdf, strong_pdf));
            }
            add_lamps(chain, mul(throughput, lamps), depth, before);
            add_light(chain, mul(throughput, lights_rest(model->lights, ray.dir)), own, before);
            return;
        }
        struct point point;
        shade_point(model, ray, &hit, &point);
        if (pdf > 0 && !is_black(point.emission))
            lamps = mad(lamps, point.emission,
                        mis_weight(pdf, lights_pdf_hit(model->lights, start, n, ray.dir, &hit, point.ng)));
        add_lamps(chain, mul(throughput, lamps), depth, before);
        if (pane_pass(&point, chain->rng, &throughput)) {
            ray.origin = shade_origin(&point, ray.dir);
            travelled = hit.t;
            continue;
        }
        if (own) {
            float steepest;
            chain->power = point.brdf.lobe_count ? 2 * shade_curvature(model, &point, &steepest) : 0;
            chain->out->distance = hit.t;
            chain->out->normal = point.ng;
        }
        lit(chain, &point, throughput, depth, own, before);
        bounced(chain, &point, false, hit.t, throughput, depth, own, before);
        bounced(chain, &point, true, hit.t, throughput, depth, own, before);
        return;
    }
}

struct gathered gather(const struct model *model, const struct diffuse_cache *cache, struct ray ray, struct rng *rng,
                       struct gather_terms *terms)
{
    struct gathered out = {.mirrored_distance = INFINITY};
    struct chain chain = {model, cache, rng, terms, &out, NULL, 0, 0, false};
    follow(&chain, ray, ray.dir, 0, vec3(1, 1, 1), 0, 0);
    return out;
}

struct gathered gather_all(const struct model *model, const struct diffuse_cache *cache, struct ray ray,
                           struct rng *rng)
{
    struct gathered out = {.mirrored_distance = INFINITY};
    struct chain chain = {model, cache, rng, NULL, &out, NULL, 0, 0, false};
    follow(&chain, ray, ray.dir, INFINITY, vec3(1, 1, 1), 0, 0);
    return out;
}

struct gathered gather_specular(const struct model *model, const struct diffuse_cache *cache, struct ray ray, float3 n,
                                float pdf, struct rng *rng, rgb *lamps)
{
    struct gathered out = {.mirrored_distance = INFINITY};
    struct chain chain = {model, cache, rng, NULL, &out, lamps, 0, 0, false};
    *lamps = vec3(0, 0, 0);
    follow(&chain, ray, n, pdf, vec3(1, 1, 1), 0, 0);
    return out;
}
