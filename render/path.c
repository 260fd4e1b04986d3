/* SPDX-License-Identifier: Apache-2.0 */
#include "render/path.h"

#include "render/pane.h"

/* Bounces; dimensions of a picture's sequence that a path takes in pairs: what comes later hardly shows. */
enum { ROULETTE_FROM = 4, SPREAD_PAIRS = 16 };

/* Where a path's random numbers come from. */
struct source {
    struct rng *rng;
    struct picture_sequence *spread; /* or NULL */
};

/* Three numbers in [0, 1), the last two well spread together. */
static void draw(struct source *source, float u[static 3])
{
    if (source->spread && source->spread->drawn < SPREAD_PAIRS) {
        float2 pair = sequence_next(source->spread);
        u[0] = sequence_next(source->spread).x;
        u[1] = pair.x;
        u[2] = pair.y;
        return;
    }
    for (int i = 0; i < 3; i++) u[i] = rng_float(source->rng);
}

/* Where a path goes on from a point: a direction drawn by its BRDF. */
struct bounce {
    float3 origin, n, dir;
    float pdf;
    rgb weight; /* f cos / pdf */
};

static bool bounce_from(const struct point *point, struct source *source, struct bounce *bounce)
{
    float u[3];
    draw(source, u);
    bounce->weight = brdf_sample(&point->brdf, point->n, point->wo, u, &bounce->dir, &bounce->pdf);
    bool beyond = dot(point->n, bounce->dir) < 0;
    struct side side = shade_side(point, beyond);
    bounce->origin = side.origin;
    bounce->n = side.n;
    return !is_black(bounce->weight) && dot(side.ng, bounce->dir) > 0;
}

static rgb direct_light(const struct model *model, const struct point *point, struct source *source)
{
    if (!lights_any(model->lights)) return (rgb){0};
    float u[3];
    draw(source, u);
    return shade_direct(model, point, u, true);
}

/* Follows a bounce to the next point that it does not pass straight. *met: what it meets of lights that lights_sample
 * knows, weighed against it; *rest: the rest of the environment; *passed: what comes through from the next point. False
 * where the ray escapes. */
static bool follow(const struct model *model, const struct bounce *b, struct rng *rng, struct point *next, rgb *met,
                   rgb *rest, rgb *passed)
{
    struct hit hit;
    struct ray ray = {b->origin, b->dir};
    float travelled = 0;
    rgb nearer = {0};
    *met = *rest = (rgb){0};
    *passed = vec3(1, 1, 1);
    for (;;) {
        bool found = trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit);
        hit.t += travelled;
        /* Seen from where the bounce began, as lights_sample did; those before the last pane are counted. */
        rgb lamps =
            lights_radiance_lamps(model->lights, b->origin, b->n, b->dir, found ? hit.t : INFINITY, b->pdf, NULL);
        *met = add(*met, mul(*passed, sub(lamps, nearer)));
        nearer = lamps;
        if (!found) break;
        shade_point(model, ray, &hit, next);
        if (!is_black(next->emission)) {
            float pdf = lights_pdf_hit(model->lights, b->origin, b->n, b->dir, &hit, next->ng);
            *met = mad(*met, mul(*passed, next->emission), mis_weight(b->pdf, pdf));
        }
        if (!pane_pass(next, rng, passed)) return true;
        ray.origin = shade_origin(next, ray.dir);
        travelled = hit.t;
    }
    float pdf;
    rgb strong = lights_strong(model->lights, b->origin, b->n, b->dir, &pdf);
    if (!is_black(strong)) *met = mad(*met, mul(*passed, strong), mis_weight(b->pdf, pdf));
    *rest = mul(*passed, lights_rest(model->lights, b->dir));
    return false;
}

/* What a point sends toward wo: in *direct by its direct light, the return value all else but its emission. */
static rgb reflected(const struct model *model, const struct point *first, struct source *source, rgb *direct)
{
    rgb sum = {0}, throughput = {1, 1, 1}, met, rest, passed;
    struct point points[2];
    const struct point *point = first;
    struct bounce bounce;
    *direct = direct_light(model, first, source);
    for (int bounces = 0; bounce_from(point, source, &bounce); bounces++) {
        struct point *next = &points[bounces & 1];
        throughput = mul(throughput, bounce.weight);
        if (bounces >= ROULETTE_FROM) {
            float survival = minf(max3(throughput), 0.98f);
            if (rng_float(source->rng) >= survival) break;
            throughput = scale(throughput, 1 / survival);
        }
        bool found = follow(model, &bounce, source->rng, next, &met, &rest, &passed);
        if (bounces == 0) *direct = add(*direct, mul(throughput, met));
        else sum = add(sum, mul(throughput, met));
        sum = add(sum, mul(throughput, rest));
        if (!found) break;
        throughput = mul(throughput, passed);
        point = next;
        sum = add(sum, mul(throughput, direct_light(model, point, source)));
    }
    return sum;
}

struct radiance path_radiance(const struct model *model, const struct point *first, struct picture_sequence *spread,
                              struct rng *rng)
{
    struct radiance radiance = {.emission = first->emission};
    struct source source = {rng, spread};
    radiance.indirect = reflected(model, first, &source, &radiance.direct);
    return radiance;
}

rgb path_incident(const struct model *model, struct ray ray, struct rng *rng)
{
    struct hit hit;
    struct point point;
    rgb passed = {1, 1, 1};
    while (trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) {
        shade_point(model, ray, &hit, &point);
        if (!pane_pass(&point, rng, &passed)) {
            struct source source = {rng, NULL};
            rgb direct, indirect = reflected(model, &point, &source, &direct);
            return mul(passed, add(direct, indirect));
        }
        ray.origin = shade_origin(&point, ray.dir);
    }
    return mul(passed, lights_rest(model->lights, ray.dir));
}
