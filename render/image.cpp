// SPDX-License-Identifier: Apache-2.0
#include "render/image.h"

#include <OpenImageIO/imageio.h>

#include <cerrno>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include <unistd.h>

__attribute__((format(printf, 2, 3))) static bool fail(char *error, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error, IMAGE_ERROR, format, arguments);
    va_end(arguments);
    for (char *c = error; *c; ++c) // OpenImageIO's messages may run over several lines
        if (*c == '\n') *c = ' ';
    return false;
}

bool image_alloc(struct image *image, int width, int height, int channel_count)
{
    *image = {};
    if (width < 1 || height < 1 || channel_count < 1) return false;
    size_t pixel_count = size_t(width) * size_t(height);
    if (pixel_count > SIZE_MAX / sizeof(float) / size_t(channel_count)) return false;
    image->width = width;
    image->height = height;
    image->channel_count = channel_count;
    image->pixels = static_cast<float *>(calloc(pixel_count * size_t(channel_count), sizeof(float)));
    image->channels = static_cast<char(*)[IMAGE_CHANNEL]>(calloc(size_t(channel_count), IMAGE_CHANNEL));
    if (image->pixels && image->channels) return true;
    image_free(image);
    return false;
}

void image_free(struct image *image)
{
    free(image->pixels);
    free(image->channels);
    *image = {};
}

int image_channel(const struct image *image, const char *name)
{
    size_t length = strlen(name);
    for (int i = 0; i < image->channel_count; ++i) {
        const char *channel = image->channels[i];
        size_t n = strlen(channel);
        if (n < length || strcmp(channel + n - length, name) != 0) continue;
        if (n == length || channel[n - length - 1] == '.') return i;
    }
    if (strncmp(name, "Combined.", 9) == 0)
        for (int i = 0; i < image->channel_count; ++i)
            if (strcmp(image->channels[i], name + 9) == 0) return i;
    return -1;
}

// IEC 61966-2-1
float image_srgb_encode(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f; }

float image_srgb_decode(float x) { return x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f); }

static bool read_pixels(const char *path, struct image *image, char *error)
{
    if (access(path, R_OK) != 0) return fail(error, "%s: cannot be read: %s", path, strerror(errno));
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path, &config);
    if (!input) return fail(error, "%s: cannot be read as a picture: %s", path, OIIO::geterror().c_str());
    const OIIO::ImageSpec &spec = input->spec();
    if (spec.depth > 1 || spec.deep)
        return fail(error, "%s: found a volume or deep picture, expected a flat one", path);
    if (!image_alloc(image, spec.width, spec.height, spec.nchannels))
        return fail(error, "%s: out of memory for %d x %d pixels of %d channels", path, spec.width, spec.height,
                    spec.nchannels);
    for (int i = 0; i < spec.nchannels; ++i) {
        std::string name = spec.channel_name(i);
        snprintf(image->channels[i], IMAGE_CHANNEL, "%s", name.c_str());
    }
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image->pixels))
        return fail(error, "%s: is cut short or damaged: %s", path, input->geterror().c_str());
    return true;
}

bool image_has_bytes(const char *path)
try {
    std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path);
    OIIO::geterror(); // image_read will say it
    return input && input->spec().format.size() == 1;
} catch (const std::exception &) {
    return false;
}

static void decode(struct image *image)
{
    size_t pixel_count = size_t(image->width) * size_t(image->height), stride = size_t(image->channel_count);
    size_t colours = stride < 3 ? 1 : 3;
    for (size_t i = 0; i < pixel_count; ++i)
        for (size_t c = 0; c < colours; ++c)
            image->pixels[i * stride + c] = image_srgb_decode(image->pixels[i * stride + c]);
}

bool image_read(const char *path, bool srgb, struct image *image, char *error)
try {
    *image = {};
    OIIO::attribute("threads", 1); // or --threads would not hold
    if (!read_pixels(path, image, error)) {
        image_free(image);
        return false;
    }
    if (srgb) decode(image);
    return true;
} catch (const std::exception &e) {
    image_free(image);
    return fail(error, "%s: cannot be read as a picture: %s", path, e.what());
}

bool image_temporary(const char *path, char *name, size_t size)
{
    int length = snprintf(name, size, "%s.%ld.part", path, long(getpid()));
    return length > 0 && size_t(length) < size;
}

// To `name`, in the format that the ending of `path` asks for.
static bool write_pixels(const char *path, const char *name, const struct image *image, bool half,
                         const struct image_attribute *attributes, int attribute_count, char *error)
{
    std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path);
    if (!output) return fail(error, "%s: cannot be written: %s", path, OIIO::geterror().c_str());
    bool png = strcmp(output->format_name(), "png") == 0;
    if (!png && strcmp(output->format_name(), "openexr") != 0)
        return fail(error, "%s: cannot be written: found the ending of a .%s, expected .exr or .png", path,
                    output->format_name());
    OIIO::ImageSpec spec(image->width, image->height, image->channel_count,
                         png    ? OIIO::TypeDesc::UINT8
                         : half ? OIIO::TypeDesc::HALF
                                : OIIO::TypeDesc::FLOAT);
    spec.channelnames.clear();
    for (int i = 0; i < image->channel_count; ++i) spec.channelnames.push_back(image->channels[i]);
    if (png) {
        spec.attribute("oiio:ColorSpace", "sRGB");
        spec.attribute("oiio:UnassociatedAlpha", 1); // as image_read gives it
    } else {
        spec.attribute("compression", "zip");
        // OpenImageIO would put the present date here.
        spec.attribute("DateTime", "1970:01:01 00:00:00");
    }
    for (int i = 0; i < attribute_count; ++i) spec.attribute(attributes[i].name, attributes[i].value);
    bool written = output->open(name, spec) && output->write_image(OIIO::TypeDesc::FLOAT, image->pixels);
    std::string message = output->geterror();
    if (written && output->close()) return true;
    if (message.empty()) message = output->geterror();
    return fail(error, "%s: cannot be written: %s", path, message.c_str());
}

bool image_write(const char *path, const struct image *image, bool half, const struct image_attribute *attributes,
                 int attribute_count, char *error)
{
    char name[4096];
    if (!image_temporary(path, name, sizeof name)) return fail(error, "%.200s…: the name is too long", path);
    try {
        OIIO::attribute("threads", 1);
        if (write_pixels(path, name, image, half, attributes, attribute_count, error)) {
            if (rename(name, path) == 0) return true;
            fail(error, "%s: cannot be written: %s", path, strerror(errno));
        }
    } catch (const std::exception &e) {
        fail(error, "%s: cannot be written: %s", path, e.what());
    }
    unlink(name);
    return false;
}
