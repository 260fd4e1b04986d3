/* SPDX-License-Identifier: Apache-2.0 */
/* Small scenes for tests of light transport, built by hand; cmocka.h comes before this. */
#ifndef TESTS_STAGE_H
#define TESTS_STAGE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "render/image.h"
#include "render/model.h"

/* A scene under construction: meshes of one material, made of quads or one polygon. */
enum { MESHES = 8, CORNERS = 256 };

struct stage {
    struct scene scene;
    struct scene_mesh meshes[MESHES];
    struct scene_object objects[MESHES];
    struct scene_material materials[MESHES];
    struct scene_light lights[4];
    int slots[MESHES];
    float positions[MESHES][3 * CORNERS];
    uint32_t corners[MESHES][CORNERS], sizes[MESHES][CORNERS];
    struct scene_image image;
    struct scene_texture texture;
    char sky[128];
};

static inline struct stage *new_stage(void)
{
    struct stage *s = calloc(1, sizeof *s);
    assert_non_null(s);
    s->scene = (struct scene){.world.texture = SCENE_NONE,
                              .meshes = s->meshes,
                              .objects = s->objects,
                              .materials = s->materials,
                              .lights = s->lights};
    s->scene.camera = (struct scene_camera){
        .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, .window = {-1, 1, -1, 1}, .width = 64, .height = 64};
    return s;
}

/* A material of one closure, good until MATERIALS more are made. */
static inline struct scene_material material_of(struct scene_closure closure)
{
    enum { MATERIALS = 256 };
    static struct scene_closure closures[MATERIALS];
    static int count;
    struct scene_closure *own = &closures[count++ % MATERIALS];
    *own = closure;
    return (struct scene_material){.closure_count = 1,
                                   .closures = own,
                                   .emission.texture = SCENE_NONE,
                                   .emission_front = true,
                                   .emission_back = true,
                                   .normal.texture = SCENE_NONE};
}

static inline struct scene_material grey(float kd, float ks, float exponent, float emission)
{
    struct scene_closure closure = scene_closure_of(ks > 0 ? CLOSURE_PHONG : CLOSURE_DIFFUSE);
    closure.colour = (struct scene_colour){{kd, kd, kd}, SCENE_NONE};
    closure.ks = (struct scene_colour){{ks, ks, ks}, SCENE_NONE};
    closure.exponent.value = exponent;
    struct scene_material material = material_of(closure);
    for (int i = 0; i < 3; i++) material.emission.value[i] = emission;
    return material;
}

static inline struct scene_object *add_object(struct stage *s, int mesh, int material)
{
    struct scene_object *object = &s->objects[s->scene.object_count];
    int *slot = &s->slots[s->scene.object_count++];
    *slot = material;
    *object = (struct scene_object){
        .mesh = mesh, .slot_count = 1, .materials = slot, .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    return object;
}

/* Adds faces of `size` corners each, with their own object and material. */
static inline struct scene_object *add_mesh(struct stage *s, const float3 *points, uint32_t size, uint32_t faces,
                                            struct scene_material material)
{
    int m = s->scene.mesh_count++;
    uint32_t count = size * faces;
    assert_true(m < MESHES && count <= CORNERS);
    memcpy(s->positions[m], points, count * sizeof *points);
    for (uint32_t i = 0; i < count; i++) s->corners[m][i] = i;
    for (uint32_t i = 0; i < faces; i++) s->sizes[m][i] = size;
    s->meshes[m] = (struct scene_mesh){.name = "mesh",
                                       .vertex_count = count,
                                       .face_count = faces,
                                       .corner_count = count,
                                       .positions = s->positions[m],
                                       .face_sizes = s->sizes[m],
                                       .corners = s->corners[m]};
    s->materials[s->scene.material_count] = material;
    return add_object(s, m, s->scene.material_count++);
}

/* A square about the centre, its front where cross(u, v) points. */
static inline struct scene_object *add_quad(struct stage *s, float3 c, float3 u, float3 v,
                                            struct scene_material material)
{
    float3 points[4] = {sub(sub(c, u), v), sub(add(c, u), v), add(add(c, u), v), add(sub(c, u), v)};
    return add_mesh(s, points, 4, 1, material);
}

/* The cube from -half to half, fronts outside. */
static inline void add_cube(struct stage *s, float half, struct scene_material material)
{
    float3 points[24];
    int count = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int side = -1; side <= 1; side += 2)
            for (int k = 0; k < 4; k++) {
                float a = k == 1 || k == 2 ? half : -half, b = k >= 2 ? half : -half, at = (float)side * half;
                float xyz[3];
                xyz[axis] = at;
                xyz[(axis + 1) % 3] = side > 0 ? a : b;
                xyz[(axis + 2) % 3] = side > 0 ? b : a;
                points[count++] = vec_from(xyz);
            }
    add_mesh(s, points, 4, 6, material);
}

/* The picture of a dim sky with one bright texel, in a temporary file. */
static inline void add_sky(struct stage *s)
{
    struct image image;
    char error[IMAGE_ERROR];
    const char *parent = getenv("TMPDIR");
    snprintf(s->sky, sizeof s->sky, "%.80s/burnish-sky-%d.exr", parent ? parent : P_tmpdir, (int)getpid());
    assert_true(image_alloc(&image, 32, 16, 3));
    for (int i = 0; i < 32 * 16 * 3; i++) image.pixels[i] = i / 3 == 4 * 32 + 16 ? 60 : 0.2f;
    for (int c = 0; c < 3; c++) snprintf(image.channels[c], IMAGE_CHANNEL, "%c", "RGB"[c]);
    assert_true(image_write(s->sky, &image, false, NULL, 0, error));
    image_free(&image);
    s->image = (struct scene_image){s->sky, IMAGE_LINEAR};
    s->texture = (struct scene_texture){.type = TEXTURE_IMAGE};
    s->scene.images = &s->image;
    s->scene.textures = &s->texture;
    s->scene.image_count = s->scene.texture_count = 1;
    s->scene.world = (struct scene_world){{1, 1, 1}, 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
}

static inline struct model build(struct stage *s)
{
    struct model model;
    char error[SCENE_ERROR];
    assert_true(model_build(&s->scene, &model, error));
    return model;
}

static inline void end(struct stage *s, struct model *model)
{
    model_free(model);
    if (s->sky[0]) remove(s->sky);
    free(s);
}

#endif
