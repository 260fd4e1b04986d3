/* SPDX-License-Identifier: Apache-2.0 */
/* The baseline: radiance caching with hemispherical harmonics (HSH) in place of EAS. J. Křivánek, P. Gautron,
 * S. Pattanaik, K. Bouatouch 2005, "Radiance caching for efficient global illumination computation".
 *
 * A record of order N holds 9 N^2 floats in the frame about its normal: the coefficients of incident radiance in red,
 * green and blue, then their derivatives by position along the frame's t, then along its b. Reflected radiance is the
 * dot product with the coefficients of f cos(theta_i) for the viewer.
 *
 *     struct hsh *hsh = hsh_build(&lobe, 1, HSH_LOSS, HSH_ORDER);
 *     int order = hsh_order(hsh, &lobe);
 *     float *record = calloc(hsh_floats(order), sizeof *record);
 *     hsh_add(hsh, samples, count, n, step, order, record);
 *     struct hsh_view view = hsh_view(hsh, &lobe, n, wo);
 *     rgb radiance = hsh_reflect(hsh, &view, record, order, n, vec3(0, 0, 0));
 *
 * Published, and here:
 * - BRDF: coefficients over a parabolic map of viewers; here over the viewer's elevation, then turned about the normal,
 *   which is the same for isotropic lobes. GGX has F = 1 in the table; Fresnel's mean over the lobe is a factor.
 * - Order: by the energy of f cos that is lost.
 * - Rotation between curved normals: of the BRDF into the record's frame (harmonics_tilt), which gives the same dot
 *   product as that of the radiance into the point's, for a third of the work. Light from below the record's horizon
 *   is missing.
 * - Translation: the gradient by shifted samples (Křivánek et al. 2005): what sends a sample stays where it is, and its
 *   direction and solid angle change as those of an EAS do (eas_translate); visibility doesn't.
 */
#ifndef EAS_HSH_H
#define EAS_HSH_H

#include "eas/harmonics.h"
#include "eas/sample_tree.h"

/* The renderer's choice: the order that loses at most this share of the energy of f cos for a viewer 45 degrees from
 * the normal, but no higher one than HSH_ORDER. Phong's n = 10, 40, 100, 200 ask for 6, 10, 16, 23. */
#define HSH_LOSS .01
enum { HSH_ORDER = 30 };

struct hsh; /* the tables; read-only after building: any thread may use them */

/* Tables for the shapes (type and width) of `count` lobes, each of the least order that loses no more than
 * `loss`, or else of order `most` (<= HARMONICS_ORDER). Some 0.1 s a shape. NULL: no memory. */
struct hsh *hsh_build(const struct lobe *lobes, int count, double loss, int most);
void hsh_free(struct hsh *hsh);

/* The order that a lobe asks for: that of the nearest shape in the tables, which must hold one of its type. */
int hsh_order(const struct hsh *hsh, const struct lobe *lobe);

/* Floats of a record. */
static inline uint32_t hsh_floats(int order) { return 9 * (uint32_t)(order * order); }

/* Adds samples to a record with normal n. step: how far the gradient looks, m: the reach of the record's zone. Much
 * less makes it noisy. */
void hsh_add(const struct hsh *hsh, const struct gather_sample *samples, uint32_t count, float3 n, float step,
             int order, float *record);

/* One lobe seen by one viewer at a point with normal n: what stays the same over the loop over records. */
struct hsh_view {
    int order;
    float3 n, wo;
    rgb factor;                                               /* the lobe's weight; GGX: and mean Fresnel */
    float plane[HARMONICS_ORDER * (HARMONICS_ORDER + 1) / 2]; /* for a viewer over the x axis: no sines */
};

/* The lobe's shape is the nearest in the tables. */
struct hsh_view hsh_view(const struct hsh *hsh, const struct lobe *lobe, float3 n, float3 wo);

/* Radiance reflected toward the viewer at a point moved by `shift` (m, world) from a record with normal n. A record of
 * lower order than the lobe's, or of higher, serves with the lower. Where it rings it may be negative. */
rgb hsh_reflect(const struct hsh *hsh, const struct hsh_view *view, const float *record, int order, float3 n,
                float3 shift);

#endif
