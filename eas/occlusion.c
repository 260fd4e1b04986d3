/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/occlusion.h"

#include <string.h>

/* A surface that passes this much nearer or farther, as a factor on the distance, leads to the other one. */
#define GAP 1.1f

/* How far the plane of a sample is along another direction from the record; INFINITY where it isn't met. */
static float plane_along(const struct gather_sample *sample, float3 dir)
{
    float slope = dot(dir, sample->normal);
    return slope < 0 ? sample->distance * dot(sample->dir, sample->normal) / slope : INFINITY;
}

/* Whether `near` hides what lies about `far`: its surface would be in front of far if it went on, so it ends; and far's
 * goes on behind it. Where two walls meet in a corner each would pass behind the other; on a box each in front. */
static bool hides(const struct gather_sample *near, const struct gather_sample *far)
{
    if (!(far->distance > near->distance)) return false;
    bool ends = GAP * plane_along(near, far->dir) < far->distance;
    return ends && (isinf(far->distance) || plane_along(far, near->dir) > GAP * near->distance);
}

/* An edge of the given length between two strata, `across` from a to b. */
static void add_edge(const struct gather_sample *a, const struct gather_sample *b, float3 across, float length,
                     struct occlusion *of_a, struct occlusion *of_b)
{
    bool first = hides(a, b);
    if (!first && !hides(b, a)) return;
    float near = maxf(first ? a->distance : b->distance, 1e-12f);
    struct occlusion *far = first ? of_b : of_a;
    float3 edge = scale(across, first ? length : -length);
    far->length = add(far->length, edge);
    far->nearness = mad(far->nearness, edge, 1 / near);
    far->hider = maxf(far->hider, near);
}

void occlusion_of(const struct gather_sample *samples, struct gather_grid grid, struct frame frame,
                  struct occlusion *occlusions)
{
    float d_phi = 2 * PI / (float)grid.columns;
    memset(occlusions, 0, (size_t)grid.rows * (size_t)grid.columns * sizeof *occlusions);
    for (int j = 0; j < grid.rows; j++) {
        float above = acosf(1 - (float)j / (float)grid.rows), below = acosf(1 - (float)(j + 1) / (float)grid.rows);
        for (int k = 0; k < grid.columns; k++) {
            int i = j * grid.columns + k, next = j * grid.columns + (k + 1) % grid.columns;
            float phi = (float)(k + 1) * d_phi, middle = phi - .5f * d_phi;
            float3 across = to_world(frame, vec3(-sinf(phi), cosf(phi), 0));
            add_edge(&samples[i], &samples[next], across, below - above, &occlusions[i], &occlusions[next]);
            if (j + 1 == grid.rows) continue;
            next = i + grid.columns;
            across = to_world(frame, vec3(cosf(below) * cosf(middle), cosf(below) * sinf(middle), -sinf(below)));
            add_edge(&samples[i], &samples[next], across, sinf(below) * d_phi, &occlusions[i], &occlusions[next]);
        }
    }
}
