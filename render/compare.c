/* SPDX-License-Identifier: Apache-2.0 */
#include "render/compare.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { IMAGE, IMAGE2, REFERENCE, REFERENCE2, IMAGES };

/* The four pictures' channels, 3 floats a pixel each. Where a second half is missing it is the first. */
struct planes {
    int width, height;
    long pixel_count;
    const struct image *images[IMAGES];
    int channels[IMAGES][3];
    unsigned char *keep; /* 1: pixel is no directly seen emitter and not near one */
};

__attribute__((format(printf, 2, 3))) static bool fail(char error[static IMAGE_ERROR], const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error, IMAGE_ERROR, format, arguments);
    va_end(arguments);
    return false;
}

static const char *const words[IMAGES] = {"the picture", "the picture's second half", "the reference",
                                          "the reference's second half"};

static float value(const struct planes *planes, int image, long pixel, int c)
{
    const struct image *source = planes->images[image];
    return source->pixels[pixel * source->channel_count + planes->channels[image][c]];
}

static bool find_channels(const struct image *image, const char *layer, int channels[static 3])
{
    for (int c = 0; c < 3; ++c) {
        char name[IMAGE_CHANNEL];
        snprintf(name, sizeof name, "%s.%c", layer, "RGB"[c]);
        channels[c] = image_channel(image, name);
        if (channels[c] < 0) return false;
    }
    return true;
}

/* Clears `keep` in the square of COMPARE_MARGIN pixels about each emitter. */
static void mask_emitters(struct planes *planes, const struct image *image, const int channels[static 3])
{
    for (int y = 0; y < planes->height; ++y)
        for (int x = 0; x < planes->width; ++x) {
            const float *pixel = image->pixels + ((long)y * planes->width + x) * image->channel_count;
            if (!(pixel[channels[0]] > 0 || pixel[channels[1]] > 0 || pixel[channels[2]] > 0)) continue;
            int x0 = x > COMPARE_MARGIN ? x - COMPARE_MARGIN : 0, x1 = x + COMPARE_MARGIN + 1;
            int y0 = y > COMPARE_MARGIN ? y - COMPARE_MARGIN : 0, y1 = y + COMPARE_MARGIN + 1;
            if (x1 > planes->width) x1 = planes->width;
            if (y1 > planes->height) y1 = planes->height;
            for (int i = y0; i < y1; ++i)
                memset(planes->keep + (size_t)i * (size_t)planes->width + x0, 0, (size_t)(x1 - x0));
        }
}

static bool check_image(const struct planes *planes, int index, const char *layer, char error[static IMAGE_ERROR])
{
    const struct image *image = planes->images[index];
    if (image->width != planes->width || image->height != planes->height)
        return fail(error, "%s is %d x %d pixels, expected %d x %d as the picture is", words[index], image->width,
                    image->height, planes->width, planes->height);
    for (long i = 0; i < planes->pixel_count; ++i)
        for (int c = 0; c < 3; ++c)
            if (!isfinite(value(planes, index, i, c)))
                return fail(error, "%s: found %g in %s.%c at pixel (%ld, %ld), expected a finite number", words[index],
                            (double)value(planes, index, i, c), layer, "RGB"[c], i % planes->width, i / planes->width);
    return true;
}

/* On success the caller frees planes->keep. */
static bool planes_open(const struct compare_input *input, struct planes *planes, char error[static IMAGE_ERROR])
{
    const char *layer = input->layer ? input->layer : "Combined";
    *planes = (struct planes){input->image->width,
                              input->image->height,
                              (long)input->image->width * input->image->height,
                              {input->image, input->image2 ? input->image2 : input->image, input->reference,
                               input->reference2 ? input->reference2 : input->reference},
                              {{0}},
                              NULL};
    for (int i = 0; i < IMAGES; ++i) {
        if (!find_channels(planes->images[i], layer, planes->channels[i]))
            return fail(error, "%s: found no channels %s.R, .G, .B, expected them", words[i], layer);
        if (!check_image(planes, i, layer, error)) return false;
    }
    planes->keep = malloc((size_t)planes->pixel_count);
    if (!planes->keep) return fail(error, "out of memory");
    memset(planes->keep, 1, (size_t)planes->pixel_count);
    const struct image *sources[] = {input->reference, input->image};
    for (int i = 0; i < 2; ++i) {
        int channels[3];
        if (!find_channels(sources[i], "Emission", channels) && !find_channels(sources[i], "Emit", channels)) continue;
        mask_emitters(planes, sources[i], channels);
        break;
    }
    return true;
}

static double root(double mean) { return mean < 0 ? -sqrt(-mean) : sqrt(mean); }

struct means {
    double x, r;
    long pixels;
};

static struct means find_means(const struct planes *planes, bool masked)
{
    double x = 0, r = 0;
    long pixels = 0;
    for (long i = 0; i < planes->pixel_count; ++i) {
        if (masked && !planes->keep[i]) continue;
        ++pixels;
        for (int c = 0; c < 3; ++c) {
            x += 0.5 * ((double)value(planes, IMAGE, i, c) + (double)value(planes, IMAGE2, i, c));
            r += 0.5 * ((double)value(planes, REFERENCE, i, c) + (double)value(planes, REFERENCE2, i, c));
        }
    }
    double count = 3.0 * (double)(pixels ? pixels : 1);
    return (struct means){x / count, r / count, pixels};
}

/* (x1-A)(x2-B), made symmetric: with a half missing on one side, the mean of the other side's halves counts. */
static double product(const double v[static IMAGES])
{
    return 0.5 * ((v[IMAGE] - v[REFERENCE]) * (v[IMAGE2] - v[REFERENCE2]) +
                  (v[IMAGE] - v[REFERENCE2]) * (v[IMAGE2] - v[REFERENCE]));
}

/* Mean over the R, G, B of a block's kept pixels of the product of its means; false where it keeps none. */
static bool block_product(const struct planes *planes, bool masked, int x0, int y0, double *mean)
{
    double sums[3][IMAGES] = {{0}};
    long count = 0;
    for (int y = y0; y < y0 + COMPARE_BLOCK && y < planes->height; ++y)
        for (int x = x0; x < x0 + COMPARE_BLOCK && x < planes->width; ++x) {
            long i = (long)y * planes->width + x;
            if (masked && !planes->keep[i]) continue;
            ++count;
            for (int c = 0; c < 3; ++c)
                for (int k = 0; k < IMAGES; ++k) sums[c][k] += (double)value(planes, k, i, c);
        }
    if (!count) return false;
    *mean = 0;
    for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < IMAGES; ++k) sums[c][k] /= (double)count;
        *mean += product(sums[c]) / 3;
    }
    return true;
}

/* See compare_errors: continuous, the usual s/(2 sqrt m) far from 0, and |root| = 2 sigma at m = 2 s. */
static double root_sigma(double mean, double s)
{
    if (fabs(mean) <= 2 * s) return sqrt(s / 2);
    return 0.5 * (sqrt(fabs(mean)) - sqrt(fabs(mean) - 2 * s));
}

static void add_blocks(const struct planes *planes, bool masked, double mean_r, struct compare_errors *errors)
{
    double sum = 0, squares = 0, mean;
    long count = 0;
    for (int pass = 0; pass < 2; ++pass) /* the second for the spread about the first's mean */
        for (int y = 0; y < planes->height; y += COMPARE_BLOCK)
            for (int x = 0; x < planes->width; x += COMPARE_BLOCK) {
                if (!block_product(planes, masked, x, y, &mean)) continue;
                if (pass == 0) {
                    sum += mean;
                    ++count;
                } else {
                    squares += (mean - sum / (double)count) * (mean - sum / (double)count);
                }
            }
    errors->block_cv = root(sum / (double)count) / mean_r;
    if (count > 1)
        errors->block_sigma =
            root_sigma(sum / (double)count, sqrt(squares / (double)(count - 1) / (double)count)) / mean_r;
}

static bool find_errors(const struct planes *planes, bool masked, struct compare_errors *errors,
                        char error[static IMAGE_ERROR])
{
    struct means means = find_means(planes, masked);
    if (means.pixels == 0)
        return fail(error, "every pixel lies within %d pixels of a directly seen emitter: nothing is left to compare",
                    COMPARE_MARGIN);
    if (!(means.r > 0))
        return fail(error, "the reference's mean %sis %g, expected it above 0: there is nothing to be relative to",
                    masked ? "without the emitters " : "", means.r);
    double squares = 0, relative = 0, noise = 0;
    for (long i = 0; i < planes->pixel_count; ++i) {
        if (masked && !planes->keep[i]) continue;
        for (int c = 0; c < 3; ++c) {
            double v[IMAGES];
            for (int k = 0; k < IMAGES; ++k) v[k] = (double)value(planes, k, i, c);
            double p = product(v), r = 0.5 * (v[REFERENCE] + v[REFERENCE2]), d = 0.5 * (v[REFERENCE] - v[REFERENCE2]);
            squares += p;
            relative += p / (r * r + 0.01 * means.r * means.r);
            noise += d * d;
        }
    }
    double count = 3.0 * (double)means.pixels;
    *errors = (struct compare_errors){.rmse = root(squares / count),
                                      .cv_rmse = root(squares / count) / means.r,
                                      .relmse = relative / count,
                                      .mean_ratio = means.x / means.r,
                                      .reference_cv = sqrt(noise / count) / means.r,
                                      .pixels = means.pixels};
    add_blocks(planes, masked, means.r, errors);
    return true;
}

bool compare(const struct compare_input *input, struct compare_result *result, char error[static IMAGE_ERROR])
{
    struct planes planes;
    if (!planes_open(input, &planes, error)) {
        free(planes.keep);
        return false;
    }
    bool good = find_errors(&planes, false, &result->all, error) && find_errors(&planes, true, &result->masked, error);
    free(planes.keep);
    return good;
}

struct stop {
    float at, colour[3];
};
static const struct stop stops[] = {{0, {0, 0, 0}},   {.02f, {0, 0, .4f}}, {.05f, {0, .2f, 1}}, {.1f, {0, .7f, .2f}},
                                    {.2f, {1, 1, 0}}, {.5f, {.9f, 0, 0}},  {1, {1, 1, 1}}};

static void false_colour(float x, float out[static 3])
{
    int last = (int)(sizeof stops / sizeof stops[0]) - 1, i = 1;
    while (i < last && x > stops[i].at) ++i;
    float t = (x - stops[i - 1].at) / (stops[i].at - stops[i - 1].at);
    if (t > 1) t = 1;
    for (int c = 0; c < 3; ++c) out[c] = stops[i - 1].colour[c] + t * (stops[i].colour[c] - stops[i - 1].colour[c]);
}

bool compare_picture(const struct compare_input *input, struct image *picture, char error[static IMAGE_ERROR])
{
    struct planes planes;
    if (!planes_open(input, &planes, error)) {
        free(planes.keep);
        return false;
    }
    double mean_r = find_means(&planes, false).r;
    bool good = mean_r > 0 ? image_alloc(picture, planes.width, planes.height, 3) || fail(error, "out of memory")
                           : fail(error, "the reference is black: there is nothing to be relative to");
    for (long i = 0; good && i < planes.pixel_count; ++i) {
        double difference = 0;
        for (int c = 0; c < 3; ++c) {
            double x = (double)value(&planes, IMAGE, i, c) + (double)value(&planes, IMAGE2, i, c);
            double r = (double)value(&planes, REFERENCE, i, c) + (double)value(&planes, REFERENCE2, i, c);
            difference += fabs(x - r) / 6;
        }
        false_colour((float)(difference / mean_r), picture->pixels + 3 * i);
    }
    for (int c = 0; good && c < 3; ++c) snprintf(picture->channels[c], IMAGE_CHANNEL, "%c", "RGB"[c]);
    free(planes.keep);
    return good;
}
