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
#define EXPONENT .4

/* Mean square difference of the halves over the pixels about (x, y) that count. */
static double square_about(const struct film halves[2], int x, int y)
{
    const int width = halves->width, height = halves->height;
    double sum = 0, square;
    int count = 0;
    for (int j = y - REACH < 0 ? 0 : y - REACH; j <= y + REACH && j < height; j++)
        for (int i = x - REACH < 0 ? 0 : x - REACH; i <= x + REACH && i < width; i++) {
            if (!film_differ(&halves[0].pixels[j * width + i], &halves[1].pixels[j * width + i], &square)) continue;
            sum += square;
            count++;
        }
    return count ? sum / count : 0;
}

bool adaptive_weights(const struct model *model, const struct cached *cached, uint64_t seed, struct progress *progress,
                      float **weights, double *gain)
{
    const int width = model->scene->camera.width, height = model->scene->camera.height;
    const size_t count = (size_t)width * (size_t)height;
    struct film halves[2];
    double sum = 0, squares = 0, left = 0;
    *weights = malloc(count * sizeof **weights);
    bool ok = render_halves(model, cached, HALF, seed, SEED_HALF, STRIDE, progress, halves) && *weights;
    for (int y = 0; ok && y < height; y++)
        for (int x = 0; x < width; x++) {
            double square = square_about(halves, x, y), share = pow(square, EXPONENT);
            (*weights)[y * width + x] = (float)share;
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
