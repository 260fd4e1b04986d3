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

/* The colour of texture `index` at uv. */
rgb texture_lookup(const struct textures *textures, int index, float2 uv);

#endif
