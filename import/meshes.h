/* SPDX-License-Identifier: Apache-2.0 */
/* The meshes of a scene document, as spans of its buffer. */
#ifndef IMPORT_MESHES_H
#define IMPORT_MESHES_H

#include "import/buffer.h"
#include "import/json.h"
#include "import/scene.h"

/* Fills scene->meshes, which the scene owns. Errors go to the document. */
void meshes_read(struct json_node *root, const struct buffer *buffer, struct scene *scene);

/* The highest material slot that the mesh's faces name. */
uint32_t meshes_top_slot(const struct scene_mesh *mesh);

#endif
