/* SPDX-License-Identifier: Apache-2.0 */
#include "scenes/experiments/gathering.h"

#include <stdlib.h>

enum { SEED_GATHERING = 501 };

bool gathering_make(const struct model *model, const struct diffuse_cache *bounced, float3 p, float3 n, int rays,
                    uint64_t seed, struct gathering *gathering)
{
    struct gather_grid grid = gather_grid(rays);
    struct gathering *g = gathering;
    *g = (struct gathering){
        .p = p, .frame = frame_about(n), .grid = grid, .count = (uint32_t)(grid.rows * grid.columns)};
    g->surface = malloc(g->count * sizeof *g->surface);
    g->mirrored = malloc(g->count * sizeof *g->mirrored);
    if (!g->surface || !g->mirrored) return false;
    float omega = 2 * PI / (float)g->count;
    float3 origin = trace_offset(p, n, model->radius);
#pragma omp parallel for schedule(dynamic, 64)
    for (uint32_t i = 0; i < g->count; i++) {
        struct rng rng = rng_seed(seed, SEED_GATHERING, i);
        float u = rng_float(&rng), v = rng_float(&rng);
        int row = (int)i / grid.columns, column = (int)i % grid.columns;
        float3 dir = to_world(g->frame, gather_direction(grid, row, column, u, v));
        struct gathered light = gather(model, bounced, (struct ray){origin, dir}, &rng, NULL);
        g->surface[i] = (struct gather_sample){dir, light.distance, light.normal, light.surface, omega, vec3(0, 0, 0)};
        g->mirrored[i] =
            (struct gather_sample){dir, light.mirrored_distance, scale(dir, -1), light.mirrored, omega, vec3(0, 0, 0)};
    }
    return true;
}

void gathering_free(struct gathering *gathering)
{
    free(gathering->surface);
    free(gathering->mirrored);
    *gathering = (struct gathering){0};
}

rgb gathering_reflect(const struct gathering *gathering, const struct lobe *lobe, float3 wo)
{
    const float3 n = gathering->frame.n;
    rgb sum = {0};
    for (uint32_t i = 0; i < gathering->count; i++) {
        const struct gather_sample *s = &gathering->surface[i];
        rgb light = add(s->radiance, gathering->mirrored[i].radiance);
        if (!is_black(light)) sum = mad(sum, mul(light, lobe_eval(lobe, n, wo, s->dir)), s->omega * dot(s->dir, n));
    }
    return sum;
}
