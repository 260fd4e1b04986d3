/* SPDX-License-Identifier: Apache-2.0 */
/* The materials of a scene document. */
#ifndef IMPORT_MATERIALS_H
#define IMPORT_MATERIALS_H

#include "import/json.h"
#include "import/scene.h"

/* Fills scene->materials, which the scene owns; its textures are there. Errors go to the document. */
void materials_read(struct json_node *root, struct scene *scene);

#endif
