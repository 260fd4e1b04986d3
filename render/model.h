/* SPDX-License-Identifier: Apache-2.0 */
/* A scene made ready to render: triangles, BVH, textures, lights. */
#ifndef RENDER_MODEL_H
#define RENDER_MODEL_H

#include "import/scene.h"
#include "render/camera.h"
#include "render/light.h"
#include "render/texture.h"
#include "render/trace.h"

struct model {
    const struct scene *scene;    /* borrowed */
    struct triangles *triangles;  /* one a mesh; world space where one object alone uses it */
    struct trace_object *objects; /* one an object, in the scene's order */
    struct textures textures;
    struct trace *trace;
    struct lights *lights;
    bool panes;                 /* some material lets light pass straight on: shadow rays have to look */
    double tessellate_s, bvh_s; /* wall seconds */
    uint64_t triangle_count;    /* instances not multiplied */
    float radius;               /* of a sphere about the bounding box, m */
};

/* False and a sentence on failure; nothing is left to free then. The meshes are tessellated in parallel. */
bool model_build(const struct scene *scene, struct model *model, char error[static SCENE_ERROR]);
void model_free(struct model *model);

#endif
