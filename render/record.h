/* SPDX-License-Identifier: Apache-2.0 */
/* One record, made: gather rays, irradiance with gradients, zone, and on glossy surfaces its EAS or HSH. */
#ifndef RENDER_RECORD_H
#define RENDER_RECORD_H

#include "eas/hsh.h"
#include "eas/occlusion.h"
#include "eas/select.h"
#include "render/gather.h"

/* Look-ups reach this many radii of a zone, so that zones overlap. */
#define RECORD_STRETCH 1.5f

/* A record on its way into the cache. The caller fills the first group and zeroes the rest. */
struct draft {
    struct point point; /* where, seen by whom */
    bool wanted;        /* no record covers the point yet */
    bool glossy;        /* EAS (or HSH) are wanted, too */
    bool lamps;         /* direct light is wanted in it, too */
    bool anywhere;      /* for viewers all around, not for this one */
    int coarseness;     /* 0: the most rays; each step has about a fourth of them */

    bool failed; /* no memory */
    struct zone zone;
    float least; /* radius that the zone may not fall below, m */
    struct irradiance irradiance;
    struct eas *eas; /* the caller frees */
    uint32_t eas_count;
    float *hsh; /* the caller frees */
    int hsh_order;
};

/* One thread's memory for making records; zero-initialise, free once. */
struct record_scratch {
    uint32_t strata, rays; /* room */
    struct gather_sample *all, *surface, *mirrored, *infinite;
    struct gathered *first;       /* of each stratum */
    struct occlusion *occlusions; /* of each stratum */
    int *sides;                   /* into how many parts a side each stratum is split */
    struct sample_tree trees[3];
    struct select_scratch select;
    struct eas *eas;
};
void record_scratch_free(struct record_scratch *scratch);

/* Gathers a record at draft->point: first a ray a stratum, then more where the lobes look, where the light is
 * concentrated and where the zone is large. `pixel`: the width of a pixel there, m. (seed, index) choose the random
 * numbers. `hsh` NULL: EAS are wanted. */
void record_make(const struct model *model, const struct diffuse_cache *bounced, const struct mean_brdf *tables,
                 const struct hsh *hsh, float pixel, uint64_t seed, uint64_t index, struct record_scratch *scratch,
                 struct draft *draft);

#endif
