/* SPDX-License-Identifier: Apache-2.0 */
#include "render/adaptive.h"

#include <math.h>
#include <stdlib.h>

enum { SEED_HALF = 801 };

/* The pilot: samples a pixel of each half, at one pixel of so many in a row; pixels to each side whose noise decides.
 */
enum { HALF = 2, STRIDE = 4, REACH = 4 };
/* The part of the samples that is spread evenly, lest something rare is missed. */
#define EVEN .3f
/* Of the variance: half where it falls as one over the samples; where they are well spread it falls faster. */
#define EXPONENT .4f

/* Mean square difference of the halves over the pixels about (x, y); those that see emitters don't count. */
static float square_about(const struct film halves[2], int x, int y)
{
    const int width = halves->width, height = halves->height;
    float sum = 0;
    int count = 0;
    for (int j = y - REACH < 0 ? 0 : y - REACH; j <= y + REACH && j < height; j++)
        for (int i = x - REACH < 0 ? 0 : x - REACH; i <= x + REACH && i < width; i++) {
            const struct pixel *p = &halves[0].pixels[j * width + i], *q = &halves[1].pixels[j * width + i];
            if (p->samples == 0 || !is_black(p->emission) || !is_black(q->emission)) continue;
            rgb d = sub(add(p->direct, p->indirect), add(q->direct, q->indirect));
            sum += dot(d, d);
            count++;
        }
    return count ? sum / (float)count : 0;
}

bool adaptive_weights(const struct model *model, const struct cached *cached, uint64_t seed, struct progress *progress,
                      float **weights, double *gain)
{
    const int width = model->scene->camera.width, height = model->scene->camera.height;
    const size_t count = (size_t)width * (size_t)height;
    struct film halves[2] = {{0}};
    double sum = 0, squares = 0, left = 0;
    *weights = malloc(count * sizeof **weights);
    bool ok = *weights && film_alloc(&halves[0], width, height, cached) &&
              film_alloc(&halves[1], width, height, cached);
    for (int half = 0; ok && half < 2; half++) {
        struct render_pass pass = {HALF, NULL, rng_mix(seed ^ (uint64_t)(SEED_HALF + half) << 32), STRIDE};
        render_samples(model, cached, &pass, progress, &halves[half]);
    }
    for (int y = 0; ok && y < height; y++)
        for (int x = 0; x < width; x++) {
            float square = square_about(halves, x, y), share = powf(square, EXPONENT);
            (*weights)[y * width + x] = share;
            sum += share;
            squares += square;
            if (share > 0) left += square / share;
        }
    for (size_t i = 0; ok && i < count; i++)
        (*weights)[i] = sum > 0 ? EVEN + (1 - EVEN) * (*weights)[i] * (float)((double)count / sum) : 1;
    /* Variances are as the squares, over the samples at each pixel. */
    *gain = left > 0 ? (1 - EVEN) * squares / (left * sum / (double)count) : 1;
    for (int half = 0; half < 2; half++) film_free(&halves[half]);
    return ok;
}
