/* SPDX-License-Identifier: Apache-2.0 */
/* The image loop: a picture of a model by one of the methods. */
#ifndef RENDER_RENDER_H
#define RENDER_RENDER_H

#include "render/cached.h"
#include "render/film.h"
#include "render/model.h"
#include "render/progress.h"

enum render_method {
    RENDER_PATH,   /* path tracing */
    RENDER_GATHER, /* traced rays that end at the diffuse cache */
    RENDER_HYBRID, /* irradiance cache + traced specular rays */
    RENDER_EAS,    /* irradiance cache + EAS cache */
    RENDER_HSH,    /* irradiance cache + HSH cache */
    RENDER_AUTO    /* eas; with an error to reach, path, gather or hybrid where few samples reach it (accuracy.h) */
};

struct render_options {
    enum render_method method;
    int spp; /* primary rays a pixel, at least 1; by the caches in the mean (adaptive.h); the most with an error */
    double error; /* estimated CV(RMSE) to end at; 0: none */
    double noise; /* CV(RMSE) of one sample a pixel, where accuracy.h has found it out; else 0 */
    uint64_t seed;
    bool lamps_in_records; /* records hold direct light, too */
    bool over_surfaces;    /* records all over the scene, for any camera */
};

/* What --stats reports of the caches; all 0 for path. */
struct render_stats {
    uint64_t records;        /* of both kinds */
    uint64_t glossy_records; /* those that hold EAS or HSH */
    double eas_per_record;   /* mean over the glossy records */
    double bytes_per_record; /* the same: zone, irradiance and EAS or HSH; without the index */
    uint64_t cache_bytes;    /* records, their EAS or HSH, index and diffuse cache */
    uint64_t diffuse_records;
    double error;      /* estimated CV(RMSE), where one was to be reached */
    int spp;           /* primary rays a pixel that were sent */
    double diffuse_cv; /* CV(RMSE) of the diffuse cache's irradiance, measured by path tracing at some of its users */
};

/* The caches that the method needs. */
struct fill_options render_fill(const struct render_options *options);

/* Samples to be added to a picture. */
struct render_pass {
    int spp;              /* a pixel, in the mean */
    const float *weights; /* times this in each pixel, by chance the power of two above or below; NULL: 1 */
    uint64_t seed;
    int stride; /* at one pixel of so many in each row */
};

/* Renders samples into a film that is there; `cached` NULL: by path tracing, in all pixels alike. */
void render_samples(const struct model *model, const struct cached *cached, const struct render_pass *pass,
                    struct progress *progress, struct film *film);

/* Two independent pictures of spp samples a pixel, for the noise between them, by random numbers of the seed that
 * `stream` and the next number choose; the caller frees both in any case. False: no memory. */
bool render_halves(const struct model *model, const struct cached *cached, int spp, uint64_t seed, int stream,
                   int stride, struct progress *progress, struct film halves[static 2]);

/* Renders into film (allocated here; the caller frees) from caches that render_fill asked for, or by path tracing where
 * fill is NULL. Deterministic for any number of threads. */
bool render(const struct model *model, const struct render_options *options, const struct fill *fill,
            struct progress *progress, struct film *film, struct render_stats *stats, char error[static SCENE_ERROR]);

#endif
