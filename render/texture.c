/* SPDX-License-Identifier: Apache-2.0 */
#include "render/texture.h"

#include <stdio.h>
#include <stdlib.h>

/* Whether the world shows the picture, whose look-up is render/environment.c's. */
static bool is_of_world(const struct scene *scene, int image)
{
    int texture = scene->world.texture;
    return texture != SCENE_NONE && scene->textures[texture].image == image;
}

bool textures_load(const struct scene *scene, struct textures *textures, char error[static SCENE_ERROR])
{
    size_t count = (size_t)scene->image_count + 1;
    *textures =
        (struct textures){scene, calloc(count, sizeof *textures->images), calloc(count, sizeof *textures->encoded)};
    if (!textures->images || !textures->encoded) {
        snprintf(error, SCENE_ERROR, "not enough memory for %d images", scene->image_count);
        textures_free(textures);
        return false;
    }
    for (int i = 0; i < scene->image_count; i++) {
        const struct scene_image *image = &scene->images[i];
        bool srgb = image->colour_space == IMAGE_SRGB;
        textures->encoded[i] = srgb && !is_of_world(scene, i) && image_has_bytes(image->file);
        if (!image_read(image->file, srgb && !textures->encoded[i], &textures->images[i], error)) {
            textures_free(textures);
            return false;
        }
    }
    return true;
}

void textures_free(struct textures *textures)
{
    if (textures->images)
        for (int i = 0; i < textures->scene->image_count; i++) image_free(&textures->images[i]);
    free(textures->images);
    free(textures->encoded);
    *textures = (struct textures){0};
}

static inline int wrap(int x, int size, enum texture_extension extension)
{
    if (extension == TEXTURE_EXTEND) return x < 0 ? 0 : x >= size ? size - 1 : x;
    int period = extension == TEXTURE_MIRROR ? 2 * size : size, m = x % period;
    if (m < 0) m += period;
    return m < size ? m : period - 1 - m;
}

static inline rgb texel(const struct image *image, int x, int y, enum texture_extension extension, bool alpha)
{
    if (extension == TEXTURE_CLIP) {
        if (x < 0 || x >= image->width || y < 0 || y >= image->height) return (rgb){0};
    } else {
        x = wrap(x, image->width, extension);
        y = wrap(y, image->height, extension);
    }
    int count = image->channel_count;
    const float *p = image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)count;
    if (alpha) return count % 2 ? vec3(1, 1, 1) : vec3(p[count - 1], p[count - 1], p[count - 1]);
    return count < 3 ? vec3(p[0], p[0], p[0]) : vec_from(p);
}

/* Texel coordinates of v rows up from the bottom; far from the picture they stay in int's range. */
static inline float texel_coordinate(float u, int size) { return clampf(u * (float)size, -1e9f, 1e9f); }

rgb texture_image(const struct image *image, float2 uv, enum texture_interpolation interpolation,
                  enum texture_extension extension, bool alpha)
{
    float x = texel_coordinate(uv.x, image->width), y = texel_coordinate(1 - uv.y, image->height);
    if (interpolation == TEXTURE_CLOSEST) return texel(image, (int)floorf(x), (int)floorf(y), extension, alpha);
    float fx = floorf(x - 0.5f), fy = floorf(y - 0.5f), s = x - 0.5f - fx, t = y - 0.5f - fy;
    int ix = (int)fx, iy = (int)fy;
    rgb upper = lerp3(texel(image, ix, iy, extension, alpha), texel(image, ix + 1, iy, extension, alpha), s);
    rgb lower = lerp3(texel(image, ix, iy + 1, extension, alpha), texel(image, ix + 1, iy + 1, extension, alpha), s);
    return lerp3(upper, lower, t);
}

/* Colour 1 where the sum of the cells' indices is even; the nudge off cell borders is Cycles'. */
static rgb checker(const struct scene_texture *texture, float2 uv)
{
    float x = floorf((uv.x * texture->scale + 1e-6f) * 0.999999f);
    float y = floorf((uv.y * texture->scale + 1e-6f) * 0.999999f);
    return vec_from(fmodf(fabsf(x + y), 2) < 0.5f ? texture->colour1 : texture->colour2);
}

static rgb by_angle(const struct scene_texture *texture, const struct texture_place *place)
{
    const float *samples = place->front ? texture->front : texture->back;
    float x = clampf(place->cosine, 0, 1) * (float)(texture->sample_count - 1);
    uint32_t i = (uint32_t)x < texture->sample_count - 2 ? (uint32_t)x : texture->sample_count - 2;
    return lerp3(vec_from(samples + 3 * i), vec_from(samples + 3 * i + 3), x - (float)i);
}

rgb texture_lookup(const struct textures *textures, int index, const struct texture_place *place)
{
    const struct scene_texture *texture = &textures->scene->textures[index];
    if (texture->type == TEXTURE_ANGLE) return by_angle(texture, place);
    const float *m = texture->uv_transform;
    float2 uv = place->uv, at = {m[0] * uv.x + m[1] * uv.y + m[2], m[3] * uv.x + m[4] * uv.y + m[5]};
    if (texture->type == TEXTURE_CHECKER) return checker(texture, at);
    rgb c = texture_image(&textures->images[texture->image], at, texture->interpolation, texture->extension,
                          texture->alpha);
    if (!textures->encoded[texture->image] || texture->alpha) return c;
    return vec3(image_srgb_decode(c.x), image_srgb_decode(c.y), image_srgb_decode(c.z));
}

rgb texture_colour(const struct textures *textures, const struct scene_colour *colour,
                   const struct texture_place *place)
{
    return colour->texture == SCENE_NONE ? vec_from(colour->value) : texture_lookup(textures, colour->texture, place);
}

float texture_scalar(const struct textures *textures, const struct scene_scalar *scalar,
                     const struct texture_place *place)
{
    if (scalar->texture == SCENE_NONE) return scalar->value;
    rgb c = texture_lookup(textures, scalar->texture, place);
    return (c.x + c.y + c.z) / 3;
}
