/* SPDX-License-Identifier: Apache-2.0 */
#include "render/lamp.h"

#include "render/transform.h"

static bool make_area(const struct scene_light *light, struct lamp *lamp)
{
    lamp->u = scale(transform_column(light->transform, 0), light->size[0] / 2);
    lamp->v = scale(transform_column(light->transform, 1), light->size[1] / 2);
    float u = length(lamp->u), v = length(lamp->v);
    bool ellipse = light->shape == LIGHT_ELLIPSE;
    lamp->area = (ellipse ? PI : 4) * u * v;
    lamp->radius = ellipse ? maxf(u, v) : sqrtf(u * u + v * v);
    lamp->tan_spread = INFINITY;
    lamp->spread_norm = 0;
    float half = light->spread / 2;
    if (half < PI / 2 - 1e-4f) {
        /* Cycles' grid before the lamp hides tan(a)/tan(half) of it at angle a, and the power is kept: the norm is 1
         * over twice the integral of cos(a) sin(a) (tan(half) - tan(a)). */
        lamp->tan_spread = tanf(half);
        lamp->spread_norm = half > 0.05f ? 1 / (lamp->tan_spread - half) : 3 / (half * half * half);
    }
    if (!(lamp->area > 0) || !(half > 0)) return false;
    lamp->radiance = scale(lamp->radiance, 1 / (PI * lamp->area));
    return true;
}

bool lamp_make(const struct scene_light *light, struct lamp *lamp)
{
    *lamp = (struct lamp){.type = light->type,
                          .shape = light->shape,
                          .radiance = vec_from(light->power),
                          .centre = transform_column(light->transform, 3),
                          .radius = light->radius,
                          .seen = light->seen,
                          .shadowless = light->shadowless};
    if (!(max3(lamp->radiance) > 0)) return false;
    lamp->axis = scale(normalize(transform_column(light->transform, 2)), light->type == LIGHT_SUN ? 1 : -1);
    if (light->type == LIGHT_AREA) return make_area(light, lamp);
    if (light->type == LIGHT_SUN) {
        float half = light->angle / 2;
        lamp->cone = 2 * sqr(sinf(half / 2));
        if (light->angle > 0) lamp->radiance = scale(lamp->radiance, 1 / (PI * sqr(sinf(half))));
        return true;
    }
    if (light->type == LIGHT_SPOT) {
        lamp->cos_cone = cosf(light->angle / 2);
        lamp->soft = 1 / maxf((1 - lamp->cos_cone) * light->blend, 1e-7f);
    }
    lamp->radiance = scale(lamp->radiance, 1 / (4 * PI * (light->radius > 0 ? PI * sqr(light->radius) : 1)));
    return true;
}

/* The share that leaves a spot along dir. */
static inline float spot_share(const struct lamp *lamp, float3 dir)
{
    float x = clampf((dot(lamp->axis, dir) - lamp->cos_cone) * lamp->soft, 0, 1);
    return x * x * (3 - 2 * x);
}

/* The share under a spread that leaves at cosine c from the axis. */
static inline float spread_share(const struct lamp *lamp, float c)
{
    if (lamp->tan_spread == INFINITY) return 1;
    return maxf((lamp->tan_spread - sqrtf(maxf(1 - c * c, 0)) / c) * lamp->spread_norm, 0);
}

/* An upper bound of the cosine at the surface toward a sphere of radius r whose centre lies at `to`. */
static inline float cosine_bound(float3 to, float distance, float r, float3 n)
{
    return distance > r ? clampf((dot(n, to) + r) / distance, 0, 1) : 1;
}

/* Point or spot: intensity over the squared distance; area: radiance, area and its own cosine, bounded. */
float lamp_irradiance(const struct lamp *lamp, float3 p, float3 n)
{
    float light = luminance(lamp->radiance), r = lamp->radius;
    if (lamp->type == LIGHT_SUN) {
        float half_sine = sqrtf(lamp->cone * (2 - lamp->cone));
        float flux = lamp->cone > 0 ? light * PI * sqr(half_sine) : light;
        return flux * clampf(dot(n, lamp->axis) + half_sine, 0, 1);
    }
    float3 to = sub(lamp->centre, p);
    float d = length(to), bound = cosine_bound(to, d, r, n);
    if (lamp->type == LIGHT_AREA) {
        float height = -dot(to, lamp->axis), aside = sqrtf(maxf(d * d - height * height, 0)) - r;
        if (height <= 0 || aside > height * lamp->tan_spread) return 0;
        float own = height / maxf(height, d - r);
        return light * lamp->area * own * bound / (d * d + r * r);
    }
    if (lamp->type == LIGHT_SPOT && d > r) {
        float sine = r / d, cosine = sqrtf(1 - sine * sine), c = -dot(to, lamp->axis) / d;
        float s = sqrtf(maxf(1 - c * c, 0)), nearest = c >= cosine ? 1 : c * cosine + s * sine;
        if (nearest < lamp->cos_cone) return 0;
    }
    return light * (r > 0 ? PI * r * r : 1) * bound / maxf(d * d, maxf(r * r, 1e-30f));
}

float lamp_power(const struct lamp *lamp, float radius)
{
    float light = luminance(lamp->radiance);
    if (lamp->type == LIGHT_SUN)
        return light * (lamp->cone > 0 ? PI * lamp->cone * (2 - lamp->cone) : 1) * PI * radius * radius;
    if (lamp->type == LIGHT_AREA) return light * PI * lamp->area;
    return light * 4 * PI * (lamp->radius > 0 ? PI * sqr(lamp->radius) : 1);
}

/* A direction in the cone of 1 - cos `cone` about the axis, uniformly; *height is 1 - cos of its own angle. */
static inline float3 cone_direction(float3 axis, float cone, const float u[static 2], float *height)
{
    float h = *height = u[0] * cone, r = sqrtf(h * (2 - h)), phi = 2 * PI * u[1];
    return to_world(frame_about(axis), vec3(r * cosf(phi), r * sinf(phi), 1 - h));
}

/* 1 - cos of the half angle that a sphere subtends; sine2 is (r/d)^2. */
static inline float sphere_cone(float sine2) { return sine2 / (1 + sqrtf(maxf(1 - sine2, 0))); }

static bool sample_sphere(const struct lamp *lamp, float3 p, float3 n, const float u[static 2], struct lamp_sample *s)
{
    float3 to = sub(lamp->centre, p);
    float d2 = dot(to, to), d = sqrtf(d2), r2 = sqr(lamp->radius);
    s->radiance = lamp->radiance;
    if (d2 <= r2) { /* inside: all around */
        s->wi = cosine_direction(n, u);
        s->pdf = dot(n, s->wi) / PI;
        float along = dot(s->wi, to);
        s->distance = along + sqrtf(maxf(r2 - d2 + along * along, 0));
        return s->pdf > 0;
    }
    float height, cone = sphere_cone(r2 / d2);
    s->wi = cone_direction(scale(to, 1 / d), cone, u, &height);
    s->pdf = 1 / (2 * PI * cone);
    s->distance = d * (1 - height) - sqrtf(maxf(r2 - d2 * height * (2 - height), 0));
    if (lamp->type == LIGHT_SPOT) s->radiance = scale(s->radiance, spot_share(lamp, scale(s->wi, -1)));
    return max3(s->radiance) > 0;
}

/* The disc that faces p, or the point. */
static bool sample_disc(const struct lamp *lamp, float3 p, const float u[static 2], struct lamp_sample *s)
{
    float3 to = sub(lamp->centre, p), axis = normalize(to);
    float r = lamp->radius * sqrtf(u[0]), phi = 2 * PI * u[1];
    if (r > 0) to = add(to, to_world(frame_about(axis), vec3(r * cosf(phi), r * sinf(phi), 0)));
    float d2 = dot(to, to);
    s->distance = sqrtf(d2);
    if (!(s->distance > 0)) return false;
    s->wi = scale(to, 1 / s->distance);
    s->radiance = lamp->radiance;
    if (lamp->type == LIGHT_SPOT) s->radiance = scale(s->radiance, spot_share(lamp, scale(s->wi, -1)));
    if (lamp->radius > 0) s->pdf = d2 / (PI * sqr(lamp->radius) * dot(axis, s->wi));
    else s->radiance = scale(s->radiance, 1 / d2);
    return max3(s->radiance) > 0;
}

static bool sample_area(const struct lamp *lamp, float3 p, const float u[static 2], struct lamp_sample *s)
{
    float a = 2 * u[0] - 1, b = 2 * u[1] - 1;
    if (lamp->shape == LIGHT_ELLIPSE) {
        float r = sqrtf(u[0]), phi = 2 * PI * u[1];
        a = r * cosf(phi);
        b = r * sinf(phi);
    }
    float3 to = add(sub(lamp->centre, p), mad(scale(lamp->u, a), lamp->v, b));
    float d2 = dot(to, to);
    s->distance = sqrtf(d2);
    s->wi = normalize(to);
    float c = -dot(s->wi, lamp->axis);
    if (c <= 0) return false;
    s->pdf = d2 / (lamp->area * c);
    s->radiance = scale(lamp->radiance, spread_share(lamp, c));
    return max3(s->radiance) > 0;
}

bool lamp_sample(const struct lamp *lamp, float3 p, float3 n, const float u[static 2], struct lamp_sample *sample)
{
    *sample = (struct lamp_sample){0};
    if (lamp->type == LIGHT_AREA) return sample_area(lamp, p, u, sample);
    if (lamp->type != LIGHT_SUN)
        return lamp->shape == LIGHT_SPHERE && lamp->radius > 0 ? sample_sphere(lamp, p, n, u, sample)
                                                               : sample_disc(lamp, p, u, sample);
    float height;
    sample->wi = lamp->cone > 0 ? cone_direction(lamp->axis, lamp->cone, u, &height) : lamp->axis;
    sample->pdf = lamp->cone > 0 ? 1 / (2 * PI * lamp->cone) : 0;
    sample->distance = INFINITY;
    sample->radiance = lamp->radiance;
    return true;
}

static bool meet_sphere(const struct lamp *lamp, float3 p, float3 n, float3 dir, float *tmax, float *pdf)
{
    float3 to = sub(lamp->centre, p);
    float d2 = dot(to, to), r2 = sqr(lamp->radius), along = dot(to, dir);
    float3 aside = mad(to, dir, -along); /* its square would lose a small sphere's radius as d2 - along^2 */
    float under = r2 - dot(aside, aside);
    if (under < 0) return false;
    bool outside = d2 > r2;
    float t = outside ? along - sqrtf(under) : along + sqrtf(under);
    *pdf = outside ? 1 / (2 * PI * sphere_cone(r2 / d2)) : maxf(dot(n, dir), 0) / PI;
    if (!(t > 0 && t < *tmax)) return false;
    *tmax = t;
    return true;
}

static bool meet_disc(const struct lamp *lamp, float3 p, float3 dir, float *tmax, float *pdf)
{
    float3 to = sub(lamp->centre, p);
    float d = length(to), along = dot(to, dir), c = along / d;
    if (along <= 0) return false;
    float t = d / c;
    float3 aside = sub(scale(dir, t), to);
    *pdf = t * t / (PI * sqr(lamp->radius) * c);
    if (dot(aside, aside) > sqr(lamp->radius) || t >= *tmax) return false;
    *tmax = t;
    return true;
}

static bool meet_area(const struct lamp *lamp, float3 p, float3 dir, float *tmax, rgb *radiance, float *pdf)
{
    float c = -dot(dir, lamp->axis);
    if (c <= 0) return false;
    float3 to = sub(lamp->centre, p);
    float t = -dot(to, lamp->axis) / c;
    float3 at = sub(scale(dir, t), to);
    float a = dot(at, lamp->u) / dot(lamp->u, lamp->u), b = dot(at, lamp->v) / dot(lamp->v, lamp->v);
    bool inside = lamp->shape == LIGHT_ELLIPSE ? a * a + b * b <= 1 : fabsf(a) <= 1 && fabsf(b) <= 1;
    if (t <= 0 || t >= *tmax || !inside) return false;
    *tmax = t;
    *pdf = t * t / (lamp->area * c);
    *radiance = scale(lamp->radiance, spread_share(lamp, c));
    return true;
}

bool lamp_is_point(const struct lamp *lamp)
{
    return lamp->type == LIGHT_SUN ? !(lamp->cone > 0) : lamp->type != LIGHT_AREA && !(lamp->radius > 0);
}

bool lamp_meet(const struct lamp *lamp, float3 p, float3 n, float3 dir, float *t, rgb *radiance, float *pdf)
{
    if (lamp->type == LIGHT_AREA) return meet_area(lamp, p, dir, t, radiance, pdf);
    *radiance = lamp->radiance;
    if (lamp->type == LIGHT_SUN) {
        float3 aside = sub(dir, lamp->axis); /* its square is 2 (1 - cos), without the cosine's rounding */
        *pdf = 1 / (2 * PI * lamp->cone);
        return lamp->cone > 0 && *t == INFINITY && dot(aside, aside) <= 2 * lamp->cone;
    }
    if (!(lamp->radius > 0)) return false;
    bool sphere = lamp->shape == LIGHT_SPHERE;
    if (!(sphere ? meet_sphere(lamp, p, n, dir, t, pdf) : meet_disc(lamp, p, dir, t, pdf))) return false;
    float3 to = sub(lamp->centre, p);
    if (lamp->type == LIGHT_SPOT && (!sphere || dot(to, to) > sqr(lamp->radius)))
        *radiance = scale(lamp->radiance, spot_share(lamp, scale(dir, -1)));
    return true;
}
