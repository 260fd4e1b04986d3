/* SPDX-License-Identifier: Apache-2.0 */
#include "scenes/experiments/one_record.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eas/hsh.h"
#include "eas/select.h"
#include "render/image.h"
#include "scenes/experiments/gathering.h"

/* Gather rays of the record, as many as the paper's. */
enum { RAYS = 4000, SEED_INCIDENT = 511 };

static const float EXPONENTS[] = {5, 10, 20, 40, 100, 200};
enum { EXPONENT_COUNT = sizeof EXPONENTS / sizeof *EXPONENTS };

/* Most EAS that a selection may have. */
static const int MOST[] = {3,   9,   15,  21,  27,  33,  39,  50,  63,  80,  100,
                           125, 160, 200, 250, 300, 400, 500, 650, 800, 1000};
enum { MOST_COUNT = sizeof MOST / sizeof *MOST, LARGEST = 1000 };

/* Share of the lobe's energy that the highest order loses: less than the renderer's, to show where curves go. */
#define LEAST_LOSS .001
/* By how much harmonics shift samples for their gradients, m; nothing moves here, but they are part of a record. */
#define HSH_STEP .01f

/* The record: what its rays brought, and the trees that EAS are chosen from: on surfaces, in mirrors, at infinity. */
struct shot {
    struct point point;
    struct gathering gathering;
    struct gather_sample *parts[3];
    uint32_t counts[3];
    struct sample_tree trees[3];
};

static void shot_free(struct shot *shot)
{
    gathering_free(&shot->gathering);
    for (int i = 0; i < 3; i++) {
        free(shot->parts[i]);
        sample_tree_free(&shot->trees[i]);
    }
}

static void add_part(struct shot *shot, const struct gather_sample *sample, int part)
{
    if (isinf(sample->distance)) part = 2;
    shot->parts[part][shot->counts[part]++] = *sample;
}

/* False: no memory. */
static bool shoot(const struct model *model, const struct diffuse_cache *bounced, struct shot *shot)
{
    struct gathering *g = &shot->gathering;
    if (!gathering_make(model, bounced, shot->point.p, shot->point.n, RAYS, 0, g)) return false;
    for (int i = 0; i < 3; i++)
        if (!(shot->parts[i] = malloc(2 * (size_t)g->count * sizeof *shot->parts[i]))) return false;
    for (uint32_t i = 0; i < g->count; i++) {
        add_part(shot, &g->surface[i], 0);
        if (!is_black(g->mirrored[i].radiance)) add_part(shot, &g->mirrored[i], 1);
    }
    for (int i = 0; i < 3; i++)
        if (!sample_tree_build(&shot->trees[i], shot->parts[i], shot->counts[i], g->p, g->frame)) return false;
    return true;
}

/* A picture of a function of direction: the hemisphere projected onto its disc, up as in the world. */
struct canvas {
    int side;
    rgb *pixels;
    struct frame frame; /* t to the right as seen from the record, b up */
    const char *folder; /* where pictures go */
};

static bool direction_at(const struct canvas *canvas, int x, int y, float3 *dir)
{
    float side = (float)canvas->side, u = 2 * ((float)x + .5f) / side - 1, v = 1 - 2 * ((float)y + .5f) / side;
    float z2 = 1 - u * u - v * v;
    if (z2 <= 0) return false;
    *dir = to_world(canvas->frame, vec3(u, v, sqrtf(z2)));
    return true;
}

/* What a picture shows: reflected radiance of EAS, of harmonics, or of the samples by their sum. */
struct source {
    const struct shot *shot;
    const struct lobe *lobe;
    const struct mean_brdf *tables;
    const struct eas *eas;
    uint32_t eas_count;
    const struct hsh *hsh;
    const float *harmonics;
    int order;
};

static rgb reflected(const struct source *source, float3 wo)
{
    const struct point *point = &source->shot->point;
    if (source->eas) {
        struct mean_lobe lobe = mean_lobe(source->tables, source->lobe, point->n, wo);
        return eas_reflect(source->eas, source->eas_count, &lobe, point->p);
    }
    if (source->harmonics) {
        struct hsh_view view = hsh_view(source->hsh, source->lobe, point->n, wo);
        return hsh_reflect(source->hsh, &view, source->harmonics, source->order, point->n, vec3(0, 0, 0));
    }
    return gathering_reflect(&source->shot->gathering, source->lobe, wo);
}

static void draw_reflected(const struct canvas *canvas, const struct source *source)
{
#pragma omp parallel for schedule(dynamic)
    for (int y = 0; y < canvas->side; y++)
        for (int x = 0; x < canvas->side; x++) {
            float3 wo;
            rgb *pixel = &canvas->pixels[y * canvas->side + x];
            *pixel = direction_at(canvas, x, y, &wo) ? reflected(source, wo) : vec3(0, 0, 0);
        }
}

/* What the record sees: several rays a pixel, for each asks the lamps but once. */
static void draw_incident(const struct canvas *canvas, const struct model *model, const struct diffuse_cache *bounced,
                          const struct point *point)
{
    enum { RAYS_A_PIXEL = 16 };
#pragma omp parallel for schedule(dynamic)
    for (int y = 0; y < canvas->side; y++)
        for (int x = 0; x < canvas->side; x++) {
            rgb *pixel = &canvas->pixels[y * canvas->side + x];
            struct ray ray = {.origin = point->origin};
            struct rng rng = rng_seed(0, SEED_INCIDENT, (uint64_t)(y * canvas->side + x));
            *pixel = vec3(0, 0, 0);
            for (int i = 0; i < RAYS_A_PIXEL && direction_at(canvas, x, y, &ray.dir); i++) {
                struct gathered light = gather(model, bounced, ray, &rng, NULL);
                *pixel = mad(*pixel, add(light.surface, light.mirrored), 1.0f / RAYS_A_PIXEL);
            }
        }
}

static bool write_picture(const struct canvas *canvas, const char *name, char error[static SCENE_ERROR])
{
    struct image image;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s.exr", canvas->folder, name);
    if (!image_alloc(&image, canvas->side, canvas->side, 3)) {
        snprintf(error, SCENE_ERROR, "out of memory");
        return false;
    }
    memcpy(image.pixels, canvas->pixels, (size_t)(canvas->side * canvas->side) * sizeof *canvas->pixels);
    for (int c = 0; c < 3; c++) snprintf(image.channels[c], IMAGE_CHANNEL, "ViewLayer.Combined.%c", "RGB"[c]);
    bool good = image_write(path, &image, false, NULL, 0, error);
    image_free(&image);
    return good;
}

/* Draws a source, writes its picture and prints its row. */
static bool show(const struct canvas *canvas, const struct source *source, const char *method, uint32_t count,
                 size_t bytes, char error[static SCENE_ERROR])
{
    char name[64];
    snprintf(name, sizeof name, "%s_%g_%u", method, source->lobe->exponent, count);
    draw_reflected(canvas, source);
    printf("%g,%s,%u,%zu,%s.exr\n", source->lobe->exponent, method, count, bytes, name);
    return write_picture(canvas, name, error);
}

static bool sample_picture(const struct canvas *canvas, const struct shot *shot, const struct lobe *lobe,
                           char error[static SCENE_ERROR])
{
    return show(canvas, &(struct source){.shot = shot, .lobe = lobe}, "reference", shot->gathering.count, 0, error);
}

/* EAS chosen at the record alone, for all directions alike but that half of them lie about the camera's. */
static bool eas_pictures(const struct canvas *canvas, const struct shot *shot, const struct mean_brdf *tables,
                         const struct lobe *lobe, char error[static SCENE_ERROR])
{
    struct eas eas[LARGEST];
    struct source source = {.shot = shot, .lobe = lobe, .tables = tables, .eas = eas};
    struct select_place place = {.origin = shot->point.p, .frame = shot->gathering.frame, .wo = shot->point.wo};
    struct select_scratch scratch = {0};
    bool good = true;
    uint32_t last = 0;
    for (int i = 0; good && i < MOST_COUNT; i++) {
        struct select_options options = SELECT_DEFAULTS;
        options.tau = 0;
        options.directions = SELECT_DIRECTIONS;
        options.most = MOST[i];
        uint32_t count = select_eas(shot->trees, 3, tables, lobe, 1, &place, &options, &scratch, eas);
        if (count == UINT32_MAX) {
            snprintf(error, SCENE_ERROR, "selection: out of memory");
            good = false;
        } else if (count != last) {
            source.eas_count = last = count;
            good = show(canvas, &source, "eas", count, count * sizeof *eas, error);
        }
    }
    select_free(&scratch);
    return good;
}

/* Harmonics of growing order, to that at which the lobe is whole. */
static bool hsh_pictures(const struct canvas *canvas, const struct shot *shot, const struct lobe *lobe,
                         char error[static SCENE_ERROR])
{
    struct hsh *hsh = hsh_build(lobe, 1, LEAST_LOSS, HARMONICS_ORDER);
    float *record = malloc(hsh_floats(HARMONICS_ORDER) * sizeof *record);
    bool good = hsh && record;
    if (!good) snprintf(error, SCENE_ERROR, "harmonics: out of memory");
    int most = good ? hsh_order(hsh, lobe) : 0;
    for (int order = 2; good && order <= most; order += order < 12 || most - order == 1 ? 1 : 2) {
        struct source source = {.shot = shot, .lobe = lobe, .hsh = hsh, .harmonics = record, .order = order};
        memset(record, 0, hsh_floats(order) * sizeof *record);
        for (int i = 0; i < 3; i++)
            hsh_add(hsh, shot->parts[i], shot->counts[i], shot->point.n, HSH_STEP, order, record);
        good = show(canvas, &source, "hsh", (uint32_t)order, hsh_floats(order) * sizeof *record, error);
    }
    free(record);
    hsh_free(hsh);
    return good;
}

static bool find_point(const struct model *model, int x, int y, struct point *point, char error[static SCENE_ERROR])
{
    const struct scene_camera *camera = &model->scene->camera;
    struct ray ray = camera_ray(camera, (float)x + .5f, (float)y + .5f);
    struct hit hit;
    if (!trace_closest(model->trace, ray.origin, ray.dir, INFINITY, &hit)) {
        snprintf(error, SCENE_ERROR, "pixel %d,%d: found the background, expected a surface", x, y);
        return false;
    }
    shade_point(model, ray, &hit, point);
    return true;
}

bool one_record(const struct model *model, const struct diffuse_cache *bounced, int x, int y, int side, const char *out,
                char error[static SCENE_ERROR])
{
    struct shot shot = {0};
    if (!find_point(model, x, y, &shot.point, error)) return false;
    const float3 n = shot.point.n, right = cross(n, fabsf(n.z) < .9f ? vec3(0, 0, 1) : vec3(0, 1, 0));
    struct frame frame = {normalize(right), normalize(cross(right, n)), n};
    struct canvas canvas = {side, malloc((size_t)(side * side) * sizeof *canvas.pixels), frame, out};
    struct mean_brdf *tables = mean_brdf_build();
    bool good = tables && canvas.pixels && shoot(model, bounced, &shot);
    if (!good) snprintf(error, SCENE_ERROR, "out of memory");
    if (good) {
        draw_incident(&canvas, model, bounced, &shot.point);
        good = write_picture(&canvas, "incident", error);
        printf("exponent,method,count,bytes,picture\n");
    }
    for (int i = 0; good && i < EXPONENT_COUNT; i++) {
        struct lobe lobe = brdf_phong(vec3(0, 0, 0), vec3(1, 1, 1), EXPONENTS[i]).lobes[0];
        good = sample_picture(&canvas, &shot, &lobe, error) && eas_pictures(&canvas, &shot, tables, &lobe, error) &&
               hsh_pictures(&canvas, &shot, &lobe, error);
    }
    free(canvas.pixels);
    mean_brdf_free(tables);
    shot_free(&shot);
    return good;
}
