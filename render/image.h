/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures as floats, in and out through OpenImageIO: render/image.cpp is the one file that sees it.
 * Different pictures may be read and written by different threads. */
#ifndef RENDER_IMAGE_H
#define RENDER_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#define IMAGE_MESSAGE char *error
#else
#define IMAGE_MESSAGE char error[static IMAGE_ERROR]
#endif

#define IMAGE_ERROR 1024 /* bytes of an error sentence */
#define IMAGE_CHANNEL 64 /* bytes of a channel's name, its end included */

/* Interleaved floats, row 0 at the top. Owned by whoever holds the struct; freed by image_free. */
struct image {
    int width, height, channel_count;
    char (*channels)[IMAGE_CHANNEL]; /* names, in Blender's words: "ViewLayer.Combined.R" … */
    float *pixels;                   /* height * width * channel_count */
};

/* Whether the file has at most 8 bits a channel; false, too, where it can't be read. */
bool image_has_bytes(const char *path);

/* What to write into the header: name and text. */
struct image_attribute {
    const char *name, *value;
};

/* Reads any format OpenImageIO knows; 8- and 16-bit values become 0 … 1, alpha stays unassociated. srgb: decode the
 * colour channels (the first three, or the one of a grey picture) to linear. False and a sentence naming the file on
 * failure; *image is then empty. */
bool image_read(const char *path, bool srgb, struct image *image, IMAGE_MESSAGE);

/* Writes an EXR (32-bit float, or half where `half`) or a PNG (8-bit sRGB, values given as display-ready 0 … 1), by the
 * ending of `path`, under image_temporary's name first, renamed at the end: `path` never holds a part of a picture. The
 * bytes depend on the arguments alone. False and a sentence on failure; nothing is left behind. */
bool image_write(const char *path, const struct image *image, bool half, const struct image_attribute *attributes,
                 int attribute_count, IMAGE_MESSAGE);

/* The name under which this process writes `path` until it is whole, beside it, so that a signal handler can remove it.
 * False where it does not fit in size bytes. */
bool image_temporary(const char *path, char *name, size_t size);

/* Allocates zeroed pixels and names; false where memory runs out. */
bool image_alloc(struct image *image, int width, int height, int channel_count);
void image_free(struct image *image);

/* Index of a channel: "Combined.R" matches itself and any "LAYER.Combined.R"; plain "R" stands in for "Combined.R" (and
 * so on for G, B) where there is no other. -1 where there is none. */
int image_channel(const struct image *image, const char *name);

/* Display value of linear x by the sRGB curve, and back; not clamped. */
float image_srgb_encode(float x);
float image_srgb_decode(float x);

#ifdef __cplusplus
}
#endif
#undef IMAGE_MESSAGE

#endif
