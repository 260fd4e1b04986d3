/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/irradiance.h"

/* m: nearer than this is no distance to divide by. */
#define LEAST_DISTANCE 1e-12f

struct gather_grid gather_grid(int count)
{
    /* Columns 4 times the rows: at the middle of the hemisphere (z = 1/2) a stratum's sides are then 1.15/rows
     * and 1.36/rows rad. */
    int rows = (int)ceilf(sqrtf((float)count / 4) - 1e-4f);
    rows = rows < 2 ? 2 : rows;
    return (struct gather_grid){rows, 4 * rows};
}

float3 gather_direction(struct gather_grid grid, int row, int column, float u, float v)
{
    float z = 1 - ((float)row + u) / (float)grid.rows, phi = 2 * PI * ((float)column + v) / (float)grid.columns;
    float sine = sqrtf(maxf(1 - z * z, 0));
    return vec3(sine * cosf(phi), sine * sinf(phi), z);
}

/* v += axis * (a channel of c) for each channel */
static void add_outer(float3 v[3], float3 axis, rgb c, float s)
{
    v[0] = mad(v[0], axis, c.x * s);
    v[1] = mad(v[1], axis, c.y * s);
    v[2] = mad(v[2], axis, c.z * s);
}

struct irradiance irradiance_of(const struct gather_sample *samples, struct gather_grid grid, struct frame frame)
{
    struct irradiance out = {0};
    float d_phi = 2 * PI / (float)grid.columns;
    for (int j = 0; j < grid.rows; j++) {
        /* The row's borders: theta- nearer the pole, theta+ below. */
        float z_above = 1 - (float)j / (float)grid.rows, z_below = 1 - (float)(j + 1) / (float)grid.rows;
        float sin_above = sqrtf(1 - z_above * z_above), sin_below = sqrtf(1 - z_below * z_below);
        for (int k = 0; k < grid.columns; k++) {
            const struct gather_sample *s = &samples[j * grid.columns + k];
            float cosine = maxf(dot(s->dir, frame.n), 0);
            out.e = mad(out.e, s->radiance, s->omega * cosine);
            add_outer(out.vector, s->dir, s->radiance, s->omega);

            /* Across the border to the row above: it moves along the column's middle direction. */
            if (j > 0) {
                const struct gather_sample *above = s - grid.columns;
                float phi = ((float)k + .5f) * d_phi, r = minf(s->distance, above->distance);
                float3 u = to_world(frame, vec3(cosf(phi), sinf(phi), 0));
                if (isfinite(r))
                    add_outer(out.translation, u, sub(s->radiance, above->radiance),
                              d_phi * sin_above * z_above * z_above / maxf(r, LEAST_DISTANCE));
            }
            /* Across the border to the column before: it moves at right angles to the border's direction. */
            const struct gather_sample *before = k > 0 ? s - 1 : s + grid.columns - 1;
            float phi = (float)k * d_phi, r = minf(s->distance, before->distance);
            float3 v = to_world(frame, vec3(-sinf(phi), cosf(phi), 0));
            if (isfinite(r))
                add_outer(out.translation, v, sub(s->radiance, before->radiance),
                          (sin_below - sin_above) / maxf(r, LEAST_DISTANCE));
        }
    }
    return out;
}

rgb irradiance_at(const struct irradiance *irradiance, float3 p0, float3 n0, float3 p, float3 n)
{
    float3 shift = sub(p, p0), turn = sub(n, n0);
    rgb e = irradiance->e;
    e.x += dot(irradiance->translation[0], shift) + dot(irradiance->vector[0], turn);
    e.y += dot(irradiance->translation[1], shift) + dot(irradiance->vector[1], turn);
    e.z += dot(irradiance->translation[2], shift) + dot(irradiance->vector[2], turn);
    return vec3(maxf(e.x, 0), maxf(e.y, 0), maxf(e.z, 0));
}

float irradiance_reach(const struct irradiance *irradiance)
{
    float3 slope = add(add(scale(irradiance->translation[0], .2126f), scale(irradiance->translation[1], .7152f)),
                       scale(irradiance->translation[2], .0722f));
    return dot(slope, slope) > 0 ? luminance(irradiance->e) / length(slope) : INFINITY;
}

void irradiance_limit(struct irradiance *irradiance, float radius)
{
    const float e[3] = {irradiance->e.x, irradiance->e.y, irradiance->e.z};
    for (int i = 0; i < 3; i++) {
        float change = length(irradiance->translation[i]) * radius;
        if (change > e[i]) irradiance->translation[i] = scale(irradiance->translation[i], e[i] / change);
    }
}
