/* SPDX-License-Identifier: Apache-2.0 */
/* The images, textures and materials of a scene document. */
#ifndef IMPORT_MATERIALS_H
#define IMPORT_MATERIALS_H

#include "import/json.h"
#include "import/scene.h"

/* Fills scene->images, ->textures and ->materials, which the scene owns. Errors go to the document. */
void materials_read(struct json_node *root, const char *folder, struct scene *scene);

#endif
