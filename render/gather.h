/* SPDX-License-Identifier: Apache-2.0 */
/* Radiance along rays that end at the diffuse cache.
 *
 * At a ray's hit: direct light of one lamp sample; bounced light of the diffuse part from the diffuse cache; the
 * specular part continued as a ray. Where the cache has no record, or its zones are wider than the ray is long (the
 * record's own neighbourhood, where an interpolated value would show), one more diffuse bounce is traced instead.
 * No light is counted twice and none is lost (eas/README.md has the table): a gather ray that hits a lamp counts 0, for
 * its sender samples lamps itself; a specular ray counts it with its MIS weight.
 */
#ifndef RENDER_GATHER_H
#define RENDER_GATHER_H

#include "render/diffuse_cache.h"
#include "render/rng.h"
#include "render/shade.h"

/* What one gather ray brought: light of the surface it hit, and light that this surface reflects specularly, which
 * has its place behind it, at the distance of its virtual image. */
struct gathered {
    float distance;          /* to the hit; INFINITY: it escaped */
    float mirrored_distance; /* to the hit and on to what it mirrors */
    float3 normal;           /* geometric, at the hit, on the ray's side */
    rgb surface, mirrored;   /* W/m2/sr */
    rgb caustic; /* part of mirrored: lamps' light that the hit reflects. Photons hold it for diffuse receivers */
};

/* All of it that a diffuse surface receives by the ray: not what photons bring it, where there are any. */
static inline rgb gathered_diffuse(const struct gathered *light, const struct diffuse_cache *cache)
{
    rgb all = add(light->surface, light->mirrored);
    return cache->caustics.count ? sub(all, light->caustic) : all;
}

/* Follows a ray from a surface point. `terms` NULL: the cache is complete. */
struct gathered gather(const struct model *model, const struct diffuse_cache *cache, struct ray ray, struct rng *rng,
                       struct gather_terms *terms);

/* The same with the lamps and the whole environment that the ray meets: nobody else samples them. Lamps that are no
 * meshes are apart from what the ray hits, as what is mirrored. */
struct gathered gather_all(const struct model *model, const struct diffuse_cache *cache, struct ray ray,
                           struct rng *rng);

/* The same for a ray that was sampled by a lobe at (ray.origin, n) with `pdf`: lamps that it meets count with their MIS
 * weight against lights_sample, those at its end in *lamps. */
struct gathered gather_specular(const struct model *model, const struct diffuse_cache *cache, struct ray ray, float3 n,
                                float pdf, struct rng *rng, rgb *lamps);

#endif
