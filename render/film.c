/* SPDX-License-Identifier: Apache-2.0 */
#include "render/film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEPTH_NONE 1e10f /* what Blender writes where nothing is hit */

bool film_alloc(struct film *film, int width, int height, bool cache)
{
    *film = (struct film){width, height, cache, calloc((size_t)width * (size_t)height, sizeof(struct pixel))};
    return film->pixels != NULL;
}

void film_free(struct film *film)
{
    free(film->pixels);
    *film = (struct film){0};
}

static rgb mean_radiance(const struct pixel *p) { return scale(add(p->direct, p->indirect), 1 / p->samples); }

bool film_differ(const struct pixel *p, const struct pixel *q, double *square)
{
    if (!is_black(p->emission) || !is_black(q->emission) || p->samples == 0 || q->samples == 0) return false;
    rgb d = sub(mean_radiance(p), mean_radiance(q));
    *square = ((double)d.x * d.x + (double)d.y * d.y + (double)d.z * d.z) / 3;
    return true;
}

double film_noise(const struct film *a, const struct film *b)
{
    double squares = 0, sum = 0;
    int64_t count = 0;
    for (int i = 0; i < a->width * a->height; i++) {
        const struct pixel *p = &a->pixels[i], *q = &b->pixels[i];
        double square;
        if (!film_differ(p, q, &square)) continue;
        rgb s = add(mean_radiance(p), mean_radiance(q));
        /* The difference has the variance of both; a's is b's share of the samples. */
        squares += q->samples / (p->samples + q->samples) * square;
        sum += .5 * ((double)s.x + s.y + s.z) / 3;
        count++;
    }
    return sum > 0 ? sqrt(squares / (double)count) / (sum / (double)count) : 0;
}

/* In the order in which write_pixel fills them. The cache's four come last. */
static const char *const channels[] = {
    "Combined.R", "Combined.G", "Combined.B", "Direct.R",   "Direct.G",  "Direct.B",  "Indirect.R", "Indirect.G",
    "Indirect.B", "Emission.R", "Emission.G", "Emission.B", "Albedo.R",  "Albedo.G",  "Albedo.B",   "Normal.X",
    "Normal.Y",   "Normal.Z",   "Depth.Z",    "Records.R",  "Records.G", "Records.B", "EASCount.V"};
enum { CHANNELS = sizeof channels / sizeof channels[0], CACHE_CHANNELS = 4 };

static float *put(float *out, float3 v, float factor)
{
    out[0] = v.x * factor;
    out[1] = v.y * factor;
    out[2] = v.z * factor;
    return out + 3;
}

static void write_pixel(const struct pixel *pixel, bool cache, float *out)
{
    float factor = pixel->samples > 0 ? 1 / pixel->samples : 0;
    out = put(out, add(pixel->emission, add(pixel->direct, pixel->indirect)), factor);
    out = put(out, pixel->direct, factor);
    out = put(out, pixel->indirect, factor);
    out = put(out, pixel->emission, factor);
    out = put(out, pixel->albedo, factor);
    out = put(out, pixel->normal, factor);
    *out++ = pixel->hits > 0 ? pixel->depth / pixel->hits : DEPTH_NONE;
    if (!cache) return;
    out = put(out, pixel->records, factor);
    *out = pixel->eas_count * factor;
}

bool film_image(const struct film *film, struct image *image)
{
    int count = film->cache ? CHANNELS : CHANNELS - CACHE_CHANNELS;
    if (!image_alloc(image, film->width, film->height, count)) return false;
    for (int i = 0; i < count; ++i) {
        strcpy(image->channels[i], "ViewLayer.");
        strcat(image->channels[i], channels[i]);
    }
    size_t pixel_count = (size_t)film->width * (size_t)film->height;
    for (size_t i = 0; i < pixel_count; ++i)
        write_pixel(&film->pixels[i], film->cache, image->pixels + i * (size_t)count);
    return true;
}
