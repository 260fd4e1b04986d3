/* SPDX-License-Identifier: Apache-2.0 */
/* The images and textures of a scene document. */
#ifndef IMPORT_TEXTURES_H
#define IMPORT_TEXTURES_H

#include "import/buffer.h"

/* Fills scene->images and ->textures, which the scene owns. Errors go to the document. */
void textures_read(struct json_node *root, const char *folder, const struct buffer *buffer, struct scene *scene);

#endif
