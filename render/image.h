/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures as floats, in and out through OpenImageIO: render/image.cpp is the one file that sees it. */
#ifndef RENDER_IMAGE_H
#define RENDER_IMAGE_H

#include <stdbool.h>
#include <stdint.h>

#define IMAGE_ERROR 1024

/* Interleaved floats, row 0 at the top. Owned by whoever holds the struct; freed by image_free. */
struct image {
    int width, height, channel_count;
    char (*channels)[64]; /* names, in Blender's words: "ViewLayer.Combined.R" … */
    float *pixels;        /* height * width * channel_count */
};

/* What to write into the header: name and text. */
struct image_attribute { const char *name, *value; };

/* Reads any format OpenImageIO knows. srgb: decode the first three channels to linear. False and a sentence naming the
 * file on failure; *image is then empty. */
bool image_read(const char *path, bool srgb, struct image *image, char error[static IMAGE_ERROR]);

/* Writes an EXR (32-bit float, or half where `half`) or a PNG (8-bit, values given as display-ready 0 … 1), to a temporary name beside
 * `path`, renamed at the end. The bytes depend on the arguments alone (no dates). */
bool image_write(const char *path, const struct image *image, bool half, const struct image_attribute *attributes,
                 int attribute_count, char error[static IMAGE_ERROR]);

/* Allocates zeroed pixels and names; false where memory runs out. */
bool image_alloc(struct image *image, int width, int height, int channel_count);
void image_free(struct image *image);

/* Index of a channel: "Combined.R" matches itself and any "LAYER.Combined.R"; plain "R" stands in for Combined.R where
 * there is no other. -1 where there is none. */
int image_channel(const struct image *image, const char *name);

#endif
