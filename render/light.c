/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light.h"

#include <stdio.h>
#include <stdlib.h>

#include "render/emitter.h"
#include "render/environment.h"
#include "render/lamp.h"

/* Lights are numbered: lamps first, then emitters, then the environment where it has a strong part. */
struct lights {
    const struct scene *scene;
    const struct trace_object *objects;
    struct lamp *lamps;
    struct emitter *emitters;
    int lamp_count, emitter_count, count;
    int *emitter_of;   /* index of each object's emitter, or -1 */
    float *cumulative; /* chances by power, [count + 1]; NULL up to WEIGHED lights */
    struct environment environment;
};

static bool build_emitters(struct lights *lights, const struct textures *textures, float radius)
{
    const struct scene *scene = lights->scene;
    for (int i = 0; i < scene->object_count; i++) {
        struct emitter *emitter = &lights->emitters[lights->emitter_count];
        lights->emitter_of[i] = -1;
        if (!emitter_build(scene, textures, &scene->objects[i], &lights->objects[i], radius, emitter)) return false;
        if (emitter->strength > 0) lights->emitter_of[i] = lights->emitter_count++;
        else emitter_free(emitter);
    }
    return true;
}

/* Lights so many that weighing them at each point would cost more than it saves: chances by power. */
static bool build_chances(struct lights *lights, float radius)
{
    float *c = lights->cumulative = malloc(((size_t)lights->count + 1) * sizeof *c);
    if (!c) return false;
    double sum = 0;
    for (int i = 0; i < lights->count; i++) {
        int emitter = i - lights->lamp_count;
        c[i] = (float)sum;
        if (emitter < 0) sum += lamp_power(&lights->lamps[i], radius);
        else if (emitter < lights->emitter_count)
            sum += PI * lights->emitters[emitter].strength *
                   (lights->emitters[emitter].front + lights->emitters[emitter].back);
        else sum += lights->environment.strong_flux * PI * radius * radius;
    }
    for (int i = 0; i < lights->count; i++) c[i] /= (float)sum;
    c[lights->count] = 1;
    return true;
}

static bool build(struct lights *lights, const struct textures *textures, float radius)
{
    const struct scene *scene = lights->scene;
    lights->lamps = malloc(((size_t)scene->light_count + 1) * sizeof *lights->lamps);
    lights->emitters = calloc((size_t)scene->object_count + 1, sizeof *lights->emitters);
    lights->emitter_of = malloc(((size_t)scene->object_count + 1) * sizeof *lights->emitter_of);
    if (!lights->lamps || !lights->emitters || !lights->emitter_of) return false;
    for (int i = 0; i < scene->light_count; i++)
        lights->lamp_count += lamp_make(&scene->lights[i], &lights->lamps[lights->lamp_count]);
    if (!build_emitters(lights, textures, radius)) return false;
    if (!environment_build(&scene->world, textures, &lights->environment)) return false;
    lights->count = lights->lamp_count + lights->emitter_count + (lights->environment.strong_flux > 0);
    return lights->count <= LIGHTS_WEIGHED || build_chances(lights, radius);
}

struct lights *lights_build(const struct scene *scene, const struct textures *textures,
                            const struct trace_object *objects, float radius, char error[static SCENE_ERROR])
{
    struct lights *lights = calloc(1, sizeof *lights);
    if (lights) {
        lights->scene = scene;
        lights->objects = objects;
    }
    if (!lights || !build(lights, textures, radius)) {
        snprintf(error, SCENE_ERROR, "not enough memory for the lights");
        lights_free(lights);
        return NULL;
    }
    return lights;
}

void lights_free(struct lights *lights)
{
    if (!lights) return;
    for (int i = 0; lights->emitters && i < lights->emitter_count; i++) emitter_free(&lights->emitters[i]);
    environment_free(&lights->environment);
    free(lights->lamps);
    free(lights->emitters);
    free(lights->emitter_of);
    free(lights->cumulative);
    free(lights);
}

bool lights_environment(const struct lights *lights) { return lights->environment.strong_flux > 0; }

int lights_cells(const struct lights *lights, int most, struct environment_cell *cells, float3 *places)
{
    return lights->count == 1 ? environment_cells(&lights->environment, most, cells, places) : 0;
}

/* Of a ball at distance d, or of a disc of this radius that is turned from p by `cosine`, whichever is less. */
static float solid_angle(float radius, float d, float cosine)
{
    float ball = d > radius ? 1 - sqrtf(1 - sqr(radius / d)) : 1;
    return 2 * PI * minf(ball, .5f * sqr(radius / d) * cosine);
}

bool lights_any_points(const struct lights *lights)
{
    for (int i = 0; i < lights->lamp_count; i++)
        if (lamp_is_point(&lights->lamps[i])) return true;
    return false;
}

float lights_widest(const struct lights *lights, float3 p)
{
    float widest = 0;
    for (int i = 0; i < lights->lamp_count; i++) {
        const struct lamp *lamp = &lights->lamps[i];
        float3 to = sub(lamp->centre, p);
        float d = maxf(length(to), 1e-15f);
        if (lamp->type == LIGHT_AREA)
            widest = maxf(widest, solid_angle(lamp->radius, d, fabsf(dot(to, lamp->axis)) / d));
    }
    for (int i = 0; i < lights->emitter_count; i++) {
        const struct emitter *e = &lights->emitters[i];
        float3 to = sub(e->centre, p);
        float d = maxf(length(to), 1e-15f);
        widest = maxf(widest, solid_angle(e->radius, d, e->flat ? fabsf(dot(to, e->normal)) / d : INFINITY));
    }
    return widest;
}

bool lights_any(const struct lights *lights) { return lights->count > 0; }

static float irradiance(const struct lights *lights, int light, float3 p, float3 n)
{
    int emitter = light - lights->lamp_count;
    if (emitter < 0) return lamp_irradiance(&lights->lamps[light], p, n);
    if (emitter < lights->emitter_count) return emitter_irradiance(&lights->emitters[emitter], p, n);
    return lights->environment.strong_flux;
}

/* The chance with which choose takes a light. */
static float chance(const struct lights *lights, int light, float3 p, float3 n)
{
    if (lights->cumulative) return lights->cumulative[light + 1] - lights->cumulative[light];
    if (lights->count == 1) return 1;
    float sum = 0, own = irradiance(lights, light, p, n);
    for (int i = 0; i < lights->count; i++) sum += i == light ? own : irradiance(lights, i, p, n);
    return own > 0 ? own / sum : 0;
}

/* Chooses a light and makes u uniform again; -1 where none can light p. */
static int choose(const struct light_weights *w, float *u, float *chance_of)
{
    const struct lights *lights = w->lights;
    if (lights->count == 1) {
        *chance_of = 1;
        return 0;
    }
    if (lights->cumulative) {
        int low = 0, high = lights->count;
        while (high - low > 1) {
            int middle = (low + high) / 2;
            if (lights->cumulative[middle] <= *u) low = middle;
            else high = middle;
        }
        *chance_of = lights->cumulative[low + 1] - lights->cumulative[low];
        *u = clampf((*u - lights->cumulative[low]) / *chance_of, 0, 0x1.fffffep-1f);
        return *chance_of > 0 ? low : -1;
    }
    const float *weights = w->each;
    if (!(w->sum > 0)) return -1;
    float x = *u * w->sum;
    int light = -1;
    for (int i = 0; i < lights->count; i++) {
        if (weights[i] <= 0) continue;
        light = i; /* rounding may carry x past the last one */
        if (x < weights[i]) break;
        x -= weights[i];
    }
    *chance_of = weights[light] / w->sum;
    *u = clampf(x / weights[light], 0, 0x1.fffffep-1f);
    return light;
}

void lights_weigh(const struct lights *lights, float3 p, float3 n, struct light_weights *weights)
{
    weights->lights = lights;
    weights->p = p;
    weights->n = n;
    weights->sum = 0;
    if (lights->cumulative || lights->count == 1) return;
    for (int i = 0; i < lights->count; i++) weights->sum += weights->each[i] = irradiance(lights, i, p, n);
}

bool lights_sample(const struct lights *lights, float3 p, float3 n, const float u[static 3],
                   struct light_sample *sample)
{
    struct light_weights weights;
    lights_weigh(lights, p, n, &weights);
    return lights_sample_weighed(&weights, u, sample);
}

bool lights_sample_weighed(const struct light_weights *weights, const float u[static 3], struct light_sample *sample)
{
    const struct lights *lights = weights->lights;
    const float3 p = weights->p, n = weights->n;
    float v[3] = {u[0], u[1], u[2]}, chance_of = 0;
    int light = lights->count > 0 ? choose(weights, v, &chance_of) : -1;
    if (light < 0) return false;
    struct lamp_sample s;
    int emitter = light - lights->lamp_count;
    if (emitter < 0) {
        if (!lamp_sample(&lights->lamps[light], p, n, v + 1, &s)) return false;
    } else if (emitter < lights->emitter_count) {
        if (!emitter_sample(&lights->emitters[emitter], p, v, &s.wi, &s.distance, &s.radiance, &s.pdf)) return false;
    } else {
        s.wi = environment_sample(&lights->environment, v + 1, &s.pdf, &s.radiance);
        s.distance = INFINITY;
        if (!(s.pdf > 0) || is_black(s.radiance)) return false;
    }
    float pdf = s.pdf * chance_of;
    *sample = (struct light_sample){.wi = s.wi,
                                    .distance = s.distance,
                                    .weight = scale(s.radiance, 1 / (s.pdf > 0 ? pdf : chance_of)),
                                    .pdf = pdf,
                                    .reach = emitter < 0 && lights->lamps[light].shadowless ? 0 : s.distance};
    return true;
}

float lights_pdf_hit(const struct lights *lights, float3 p, float3 n, float3 dir, const struct hit *hit, float3 ng)
{
    int emitter = lights->emitter_of[hit->object];
    if (emitter < 0) return 0;
    float pdf = emitter_pdf(&lights->emitters[emitter], p, hit->triangle, hit->t, fabsf(dot(dir, ng)));
    return pdf > 0 ? chance(lights, lights->lamp_count + emitter, p, n) * pdf : 0;
}

rgb lights_radiance_lamps(const struct lights *lights, float3 p, float3 n, float3 dir, float tmax, float pdf,
                          float *distance)
{
    rgb sum = {0}, radiance;
    float pdf_lamp, largest = 0;
    for (int i = 0; i < lights->lamp_count; i++) {
        float t = lights->lamps[i].shadowless ? INFINITY : tmax;
        if (!lamp_meet(&lights->lamps[i], p, n, dir, &t, &radiance, &pdf_lamp)) continue;
        sum = mad(sum, radiance, pdf == INFINITY ? 1 : mis_weight(pdf, pdf_lamp * chance(lights, i, p, n)));
        if (distance && luminance(radiance) > largest) {
            largest = luminance(radiance);
            *distance = t;
        }
    }
    return sum;
}

rgb lights_seen(const struct lights *lights, float3 eye, float3 dir, float tmax)
{
    rgb sum = {0}, radiance;
    for (int i = 0; i < lights->lamp_count; i++) {
        float t = tmax, pdf;
        if (lights->lamps[i].seen && lamp_meet(&lights->lamps[i], eye, dir, dir, &t, &radiance, &pdf))
            sum = add(sum, radiance);
    }
    return sum;
}

rgb lights_strong(const struct lights *lights, float3 p, float3 n, float3 dir, float *pdf)
{
    rgb radiance = environment_strong(&lights->environment, dir);
    *pdf =
        is_black(radiance) ? 0 : environment_pdf(&lights->environment, dir) * chance(lights, lights->count - 1, p, n);
    return radiance;
}

rgb lights_rest(const struct lights *lights, float3 dir) { return environment_rest(&lights->environment, dir); }
