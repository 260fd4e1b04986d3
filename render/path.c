/* SPDX-License-Identifier: Apache-2.0 */
#include "render/path.h"

#include "render/pane.h"

enum { ROULETTE_FROM = 4 }; /* bounces */

/* Where a path goes on from a point: a direction drawn by its BRDF. */
struct bounce {
    float3 origin, n, dir;
    float pdf;
    rgb weight; /* f cos / pdf */
};

static bool bounce_from(const struct point *point, struct rng *rng, struct bounce *bounce)
{
    float u[3] = {rng_float(rng), rng_float(rng), rng_float(rng)};
    bounce->weight = brdf_sample(&point->brdf, point->n, point->wo, u, &bounce->dir, &bounce->pdf);
    bool beyond = dot(point->n, bounce->dir) < 0;
    struct side side = shade_side(point, beyond);
    bounce->origin = side.origin;
    bounce->n = side.n;
    return !is_black(bounce->weight) && dot(side.ng, bounce->dir) > 0;
}

static rgb direct_light(const struct model *model, const struct point *point, struct rng *rng)
{
    if (!lights_any(model->lights)) return (rgb){0};
    float u[3] = {rng_float(rng), rng_float(rng), rng_float(rng)};
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
static rgb reflected(const struct model *model, const struct point *first, struct rng *rng, rgb *direct)
{
    rgb sum = {0}, throughput = {1, 1, 1}, met, rest, passed;
    struct point point = *first, next;
    struct bounce bounce;
    *direct = direct_light(model, first, rng);
    for (int bounces = 0; bounce_from(&point, rng, &bounce); bounces++) {
        throughput = mul(throughput, bounce.weight);
        if (bounces >= ROULETTE_FROM) {
            float survival = minf(max3(throughput), 0.98f);
            if (rng_float(rng) >= survival) break;
            throughput = scale(throughput, 1 / survival);
        }
        bool found = follow(model, &bounce, rng, &next, &met, &rest, &passed);
        if (bounces == 0) *direct = add(*direct, mul(throughput, met));
        else sum = add(sum, mul(throughput, met));
        sum = add(sum, mul(throughput, rest));
        if (!found) break;
        throughput = mul(throughput, passed);
        point = next;
        sum = add(sum, mul(throughput, direct_light(model, &point, rng)));
    }
    return sum;
}

struct radiance path_radiance(const struct model *model, const struct point *first, struct rng *rng)
{
    struct radiance radiance = {.emission = first->emission};
    radiance.indirect = reflected(model, first, rng, &radiance.direct);
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
            rgb direct, indirect = reflected(model, &point, rng, &direct);
            return mul(passed, add(direct, indirect));
        }
        ray.origin = shade_origin(&point, ray.dir);
    }
    return mul(passed, lights_rest(model->lights, ray.dir));
}
