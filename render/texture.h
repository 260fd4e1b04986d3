/* SPDX-License-Identifier: Apache-2.0 */
/* Texture look-up as Cycles does it: bilinear or closest, no filtering, checker in UV. */
#ifndef RENDER_TEXTURE_H
#define RENDER_TEXTURE_H

#include "eas/vec.h"
#include "import/scene.h"
#include "render/image.h"

/* Decoded pictures of a scene, linear Rec. 709, one per scene_image; each read once. */
struct textures {
    const struct scene *scene; /* borrowed */
    struct image *images;      /* scene->image_count */
};

bool textures_load(const struct scene *scene, struct textures *textures, char error[static SCENE_ERROR]);
void textures_free(struct textures *textures);

/* The colour of a picture at uv, v from the bottom row up; a picture of one or two channels is grey. */
rgb texture_image(const struct image *image, float2 uv, enum texture_interpolation interpolation,
                  enum texture_extension extension);

/* The colour of texture `index` at uv. */
rgb texture_lookup(const struct textures *textures, int index, float2 uv);

#endif
