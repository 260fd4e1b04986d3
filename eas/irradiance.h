/* SPDX-License-Identifier: Apache-2.0 */
/* Irradiance at a record and how it changes about it: the diffuse half of a record.
 *
 * From gather samples on a polar grid of equal solid angles: rows of z = cos(theta) from the pole down, columns of phi.
 * Gradients: rotation by the vector irradiance; translation by Ward and Heckbert 1992 in the stratified form of
 * Křivánek and Gautron 2009 (2.3.2), which follows edges between strata at the nearer one's distance, so that occlusion
 * is in it.
 */
#ifndef EAS_IRRADIANCE_H
#define EAS_IRRADIANCE_H

#include "eas/sample_tree.h"

/* A stratified polar grid over the hemisphere: sample (row, column) is row * columns + column. */
struct gather_grid {
    int rows, columns;
};

/* `count` strata at least, rounded to a grid whose strata are about as wide as high. */
struct gather_grid gather_grid(int count);

/* The direction of a stratum's point (u, v in [0, 1)) in the local frame, z up: uniform in solid angle. */
float3 gather_direction(struct gather_grid grid, int row, int column, float u, float v);

struct irradiance {
    rgb e;                 /* W/m2 */
    float3 vector[3];      /* R, G, B: integral of L omega, W/m2: the flux through a surface of normal n is vector.n */
    float3 translation[3]; /* R, G, B: gradient by position in the tangent plane, W/m3 */
};

/* From grid.rows x grid.columns samples about `frame`; `samples` holds each ray's whole radiance and the distance to
 * its first hit. */
struct irradiance irradiance_of(const struct gather_sample *samples, struct gather_grid grid, struct frame frame);

/* Extrapolated from a record at (p0, n0) to (p, n); never negative. */
rgb irradiance_at(const struct irradiance *irradiance, float3 p0, float3 n0, float3 p, float3 n);

/* The distance at which the translation gradient alone would halve or double it, m: no zone should be larger. */
float irradiance_reach(const struct irradiance *irradiance);

/* Flattens the translation gradient so that no channel of e changes by more than itself within a zone of `radius` that
 * couldn't be made as small as the reach: beside a contact the gradient is that of a point, not of a pixel. */
void irradiance_limit(struct irradiance *irradiance, float radius);

#endif
