/* SPDX-License-Identifier: Apache-2.0 */
#include "render/texture.h"

#include <stdio.h>
#include <stdlib.h>

bool textures_load(const struct scene *scene, struct textures *textures, char error[static SCENE_ERROR])
{
    *textures = (struct textures){scene, calloc((size_t)scene->image_count + 1, sizeof *textures->images)};
    if (!textures->images) {
        snprintf(error, SCENE_ERROR, "not enough memory for %d images", scene->image_count);
        return false;
    }
    for (int i = 0; i < scene->image_count; i++)
        if (!image_read(scene->images[i].file, scene->images[i].colour_space == IMAGE_SRGB, &textures->images[i],
                        error)) {
            textures_free(textures);
            return false;
        }
    return true;
}

void textures_free(struct textures *textures)
{
    if (textures->images)
        for (int i = 0; i < textures->scene->image_count; i++) image_free(&textures->images[i]);
    free(textures->images);
    *textures = (struct textures){0};
}

static inline int wrap(int x, int size, enum texture_extension extension)
{
    if (extension == TEXTURE_EXTEND) return x < 0 ? 0 : x >= size ? size - 1 : x;
    int m = x % size;
    return m < 0 ? m + size : m;
}

static inline rgb texel(const struct image *image, int x, int y, enum texture_extension extension)
{
    if (extension == TEXTURE_CLIP) {
        if (x < 0 || x >= image->width || y < 0 || y >= image->height) return (rgb){0};
    } else {
        x = wrap(x, image->width, extension);
        y = wrap(y, image->height, extension);
    }
    const float *p = image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channel_count;
    return image->channel_count < 3 ? vec3(p[0], p[0], p[0]) : vec_from(p);
}

/* Texel coordinates of v rows up from the bottom; far from the picture they stay in int's range. */
static inline float texel_coordinate(float u, int size) { return clampf(u * (float)size, -1e9f, 1e9f); }

rgb texture_image(const struct image *image, float2 uv, enum texture_interpolation interpolation,
                  enum texture_extension extension)
{
    float x = texel_coordinate(uv.x, image->width), y = texel_coordinate(1 - uv.y, image->height);
    if (interpolation == TEXTURE_CLOSEST) return texel(image, (int)floorf(x), (int)floorf(y), extension);
    float fx = floorf(x - 0.5f), fy = floorf(y - 0.5f), s = x - 0.5f - fx, t = y - 0.5f - fy;
    int ix = (int)fx, iy = (int)fy;
    return lerp3(lerp3(texel(image, ix, iy, extension), texel(image, ix + 1, iy, extension), s),
                 lerp3(texel(image, ix, iy + 1, extension), texel(image, ix + 1, iy + 1, extension), s), t);
}

/* Colour 1 where the sum of the cells' indices is even; the nudge off cell borders is Cycles'. */
static rgb checker(const struct scene_texture *texture, float2 uv)
{
    float x = floorf((uv.x * texture->scale + 1e-6f) * 0.999999f);
    float y = floorf((uv.y * texture->scale + 1e-6f) * 0.999999f);
    return vec_from(fmodf(fabsf(x + y), 2) < 0.5f ? texture->colour1 : texture->colour2);
}

rgb texture_lookup(const struct textures *textures, int index, float2 uv)
{
    const struct scene_texture *texture = &textures->scene->textures[index];
    const float *m = texture->uv_transform;
    float2 at = {m[0] * uv.x + m[1] * uv.y + m[2], m[3] * uv.x + m[4] * uv.y + m[5]};
    if (texture->type == TEXTURE_CHECKER) return checker(texture, at);
    return texture_image(&textures->images[texture->image], at, texture->interpolation, texture->extension);
}
