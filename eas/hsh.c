/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/hsh.h"

#include <stdlib.h>

#include "eas/ggx.h"

enum { ROWS = 128, AZIMUTHS = 128 };

/* Normals nearer than this are the same: 0.08 degrees. */
#define SAME_COSINE .999999f

#define PAIRS(order) ((order) * ((order) + 1) / 2)

/* The coefficients of f cos for viewers at i/(rows - 1) of 90 degrees from the normal, PAIRS(order) each. */
struct shape {
    struct lobe lobe; /* weight 1, F = 1 */
    int order, rows;
    float *planes;
};

struct hsh {
    struct harmonics *harmonics;
    int count;
    struct shape shapes[];
};

static struct lobe white_lobe(const struct lobe *lobe)
{
    const rgb white = {1, 1, 1};
    enum lobe_type type = lobe->type == LOBE_PHONG ? LOBE_PHONG : LOBE_METAL;
    return (struct lobe){type, white, lobe->exponent, lobe->alpha, 0, white, white};
}

/* Coefficients of f cos for a viewer at theta over the x axis, by midpoints of azimuth. Returns the energy, the
 * integral of (f cos)^2. */
static double project(const struct harmonics *harmonics, const struct lobe *lobe, float theta, int order, float *plane)
{
    const float3 n = {0, 0, 1}, wo = {sinf(theta), 0, cosf(theta)};
    float profile[PAIRS(HARMONICS_ORDER)], azimuths[HARMONICS_ORDER];
    double energy = 0;
    for (int i = 0; i < PAIRS(order); i++) plane[i] = 0;
    for (int i = 0; i < ROWS; i++) {
        float z, level, dz = harmonics_height(i, ROWS, &z, &level);
        for (int m = 0; m < order; m++) azimuths[m] = 0;
        for (int j = 0; j < AZIMUTHS; j++) { /* of the half circle: the other half is the same */
            float phi = PI * ((float)j + .5f) / AZIMUTHS, c = cosf(phi), cosine = 1, before = c;
            float f = lobe_eval(lobe, n, wo, vec3(level * c, level * sinf(phi), z)).x * z;
            energy += f * f * dz * 2 * PI / AZIMUTHS;
            for (int m = 0; m < order; m++) { /* Chebyshev's recurrence for cos(m phi) */
                azimuths[m] += f * cosine * 2 * PI / AZIMUTHS;
                float next = 2 * c * cosine - before;
                before = cosine;
                cosine = next;
            }
        }
        harmonics_profile(harmonics, order, z, level, profile);
        for (int l = 0; l < order; l++)
            for (int m = 0; m <= l; m++) plane[PAIRS(l) + m] += profile[PAIRS(l) + m] * azimuths[m] * dz;
    }
    return energy;
}

static int choose_order(const struct harmonics *harmonics, const struct lobe *lobe, double loss, int most)
{
    float plane[PAIRS(HARMONICS_ORDER)];
    double energy = project(harmonics, lobe, PI / 4, most, plane), held = 0;
    for (int l = 0; l < most; l++) {
        for (int m = 0; m <= l; m++) held += sqr(plane[PAIRS(l) + m]);
        if (held >= (1 - loss) * energy) return l + 1;
    }
    return most;
}

static bool fill_shape(const struct harmonics *harmonics, double loss, int most, struct shape *shape)
{
    shape->order = choose_order(harmonics, &shape->lobe, loss, most);
    shape->rows = 4 * shape->order + 1; /* steps of a quarter of the narrowest ripple */
    shape->planes = malloc((size_t)(shape->rows * PAIRS(shape->order)) * sizeof *shape->planes);
    for (int i = 0; shape->planes && i < shape->rows; i++) {
        float theta = minf(PI / 2 * (float)i / (float)(shape->rows - 1), PI / 2 - 1e-3f);
        project(harmonics, &shape->lobe, theta, shape->order, shape->planes + i * PAIRS(shape->order));
    }
    return shape->planes;
}

/* How far two white lobes are apart: 0 where they are the same shape. */
static float distance(const struct lobe *a, const struct lobe *b)
{
    if (a->type != b->type) return INFINITY;
    return a->type == LOBE_PHONG ? fabsf(logf((a->exponent + 1) / (b->exponent + 1)))
                                 : fabsf(logf(a->alpha / b->alpha));
}

static const struct shape *nearest(const struct hsh *hsh, const struct lobe *lobe)
{
    struct lobe white = white_lobe(lobe);
    const struct shape *best = &hsh->shapes[0];
    for (int i = 1; i < hsh->count; i++)
        if (distance(&hsh->shapes[i].lobe, &white) < distance(&best->lobe, &white)) best = &hsh->shapes[i];
    return best;
}

struct hsh *hsh_build(const struct lobe *lobes, int count, double loss, int most)
{
    struct hsh *hsh = calloc(1, sizeof *hsh + (size_t)count * sizeof hsh->shapes[0]);
    if (!hsh) return NULL;
    bool good = (hsh->harmonics = harmonics_build()) != NULL;
    for (int i = 0; good && i < count; i++) {
        struct lobe white = white_lobe(&lobes[i]);
        if (hsh->count && distance(&nearest(hsh, &white)->lobe, &white) == 0) continue;
        struct shape *shape = &hsh->shapes[hsh->count++];
        shape->lobe = white;
        good = fill_shape(hsh->harmonics, loss, most, shape);
    }
    if (good) return hsh;
    hsh_free(hsh);
    return NULL;
}

void hsh_free(struct hsh *hsh)
{
    if (!hsh) return;
    for (int i = 0; i < hsh->count; i++) free(hsh->shapes[i].planes);
    harmonics_free(hsh->harmonics);
    free(hsh);
}

int hsh_order(const struct hsh *hsh, const struct lobe *lobe) { return nearest(hsh, lobe)->order; }

/* out += values s */
static void add_scaled(int count, const float *restrict values, float s, float *restrict out)
{
    for (int i = 0; i < count; i++) out[i] += values[i] * s;
}

void hsh_add(const struct hsh *hsh, const struct gather_sample *samples, uint32_t count, float3 n, float step,
             int order, float *record)
{
    struct frame frame = frame_about(n);
    const float3 shifts[5] = {{0, 0, 0}, frame.t, scale(frame.t, -1), frame.b, scale(frame.b, -1)};
    const float shares[5] = {1, .5f / step, -.5f / step, .5f / step, -.5f / step};
    float values[HARMONICS_ORDER * HARMONICS_ORDER];
    int size = order * order;
    for (uint32_t i = 0; i < count; i++) {
        const struct gather_sample *s = &samples[i];
        if (is_black(s->radiance)) continue;
        bool infinite = isinf(s->distance);
        struct eas eas = eas_make(vec3(0, 0, 0), scale(s->dir, infinite ? 1 : s->distance), s->normal, s->radiance,
                                  s->omega, infinite);
        for (int k = 0; k < (infinite ? 1 : 5); k++) {
            struct cap cap = eas_translate(&eas, scale(shifts[k], step));
            rgb power = scale(s->radiance, cap.omega * shares[k]);
            float *planes = record + (k + 1) / 2 * 3 * size;
            harmonics_at(hsh->harmonics, order, to_local(frame, cap.axis), values);
            add_scaled(size, values, power.x, planes);
            add_scaled(size, values, power.y, planes + size);
            add_scaled(size, values, power.z, planes + 2 * size);
        }
    }
}

/* Fresnel's factor, averaged over the lobe. */
static rgb mean_fresnel(const struct lobe *lobe, float mu)
{
    if (lobe->type == LOBE_PHONG) return vec3(1, 1, 1);
    if (lobe->type == LOBE_METAL) return ggx_fresnel(lobe, mu);
    return lerp3(lobe->f0, vec3(1, 1, 1), ggx_fresnel_share(sqrtf(lobe->alpha), mu, lobe->ior));
}

struct hsh_view hsh_view(const struct hsh *hsh, const struct lobe *lobe, float3 n, float3 wo)
{
    const struct shape *shape = nearest(hsh, lobe);
    float mu = clampf(dot(n, wo), 0, 1), at = acosf(mu) / (PI / 2) * (float)(shape->rows - 1);
    int size = PAIRS(shape->order), row = at < (float)(shape->rows - 2) ? (int)at : shape->rows - 2;
    const float *below = shape->planes + row * size, *above = below + size;
    float blend = at - (float)row;
    struct hsh_view view = {.order = shape->order, .n = n, .wo = wo};
    view.factor = mul(lobe->weight, mean_fresnel(lobe, mu));
    for (int i = 0; i < size; i++) view.plane[i] = (1 - blend) * below[i] + blend * above[i];
    return view;
}

/* The coefficients of f cos for a viewer at azimuth (x, y), any length. */
static void turn_plane(const struct hsh_view *view, float x, float y, float *out)
{
    float level = sqrtf(x * x + y * y);
    for (int l = 0; l < view->order; l++)
        for (int m = 0; m <= l; m++) {
            if (m) out[l * l + l + m] = 0;
            out[l * l + m] = view->plane[PAIRS(l) + m];
        }
    if (level > 0) harmonics_turn(view->order, x / level, y / level, out, out);
}

/* The coefficients of f cos in the frame of a record. */
static void in_frame(const struct hsh *hsh, const struct hsh_view *view, struct frame frame, float *out)
{
    float cosine = dot(view->n, frame.n);
    if (cosine > SAME_COSINE) {
        turn_plane(view, dot(view->wo, frame.t), dot(view->wo, frame.b), out);
        return;
    }
    /* x: where the normal leans to; y the axis that it is tilted about */
    float3 x = normalize(mad(view->n, frame.n, -cosine)), y = cross(frame.n, x), x_there = cross(y, view->n);
    turn_plane(view, dot(view->wo, x_there), dot(view->wo, y), out);
    harmonics_tilt(hsh->harmonics, view->order, acosf(cosine), out, out);
    harmonics_turn(view->order, dot(x, frame.t), dot(x, frame.b), out, out);
}

static float dot_product(int count, const float *a, const float *b)
{
    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

rgb hsh_reflect(const struct hsh *hsh, const struct hsh_view *view, const float *record, int order, float3 n,
                float3 shift)
{
    struct frame frame = frame_about(n);
    float f[HARMONICS_ORDER * HARMONICS_ORDER], moved[3] = {1, dot(shift, frame.t), dot(shift, frame.b)};
    float sums[3] = {0};
    int common = order < view->order ? order : view->order;
    in_frame(hsh, view, frame, f);
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++)
            sums[c] += moved[k] * dot_product(common * common, f, record + (3 * k + c) * order * order);
    return mul(view->factor, vec3(sums[0], sums[1], sums[2]));
}
