/* SPDX-License-Identifier: Apache-2.0 */
/* Texture look-up as Cycles does it: bilinear or closest, no filtering, checker in UV, colours by angle. 8-bit sRGB
 * pictures are interpolated as they stand in the file and decoded then. Any thread may look up. */
#ifndef RENDER_TEXTURE_H
#define RENDER_TEXTURE_H

#include "eas/vec.h"
#include "import/scene.h"
#include "render/image.h"

/* Pictures of a scene, one per scene_image; each read once. */
struct textures {
    const struct scene *scene; /* borrowed */
    struct image *images;      /* scene->image_count; linear Rec. 709 or data */
    bool *encoded;             /* of each: it is still sRGB (never the world's) */
};

/* Where a texture is looked up. */
struct texture_place {
    float2 uv;
    float cosine; /* |cos| between the mesh's shading normal and the viewer */
    bool front;   /* the viewer is on the face's front */
};

bool textures_load(const struct scene *scene, struct textures *textures, char error[static SCENE_ERROR]);
void textures_free(struct textures *textures);

/* The colour of a picture at uv, v from the bottom row up, as its pixels are, or its alpha as grey; a picture of one or
 * two channels is grey, one without alpha opaque. */
rgb texture_image(const struct image *image, float2 uv, enum texture_interpolation interpolation,
                  enum texture_extension extension, bool alpha);

/* The colour of texture `index`. */
rgb texture_lookup(const struct textures *textures, int index, const struct texture_place *place);

/* A value of the scene there; of a scalar's texture the mean of the channels. */
rgb texture_colour(const struct textures *textures, const struct scene_colour *colour,
                   const struct texture_place *place);
float texture_scalar(const struct textures *textures, const struct scene_scalar *scalar,
                     const struct texture_place *place);

#endif
