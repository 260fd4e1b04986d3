/* SPDX-License-Identifier: Apache-2.0 */
/* The scene as plain arrays: the format of import/FORMAT.md in the same words.
 *
 *     struct scene scene;
 *     char error[SCENE_ERROR];
 *     if (!scene_read("scenes/cornell/scene", &scene, error)) fail(error);
 *     ...
 *     scene_free(&scene);
 *
 * scene_read checks everything once (types, ranges, indices, finite numbers, files that exist), so that nobody after it
 * has to. Units: metres, watts, radians; Z up; linear Rec. 709. Nothing here changes after reading: any thread may
 * read.
 */
#ifndef IMPORT_SCENE_H
#define IMPORT_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SCENE_ERROR 1024 /* bytes of an error sentence */
#define SCENE_NONE (-1)  /* an index that names nothing */

struct scene_camera {
    float transform[12]; /* camera to world, 3 x 4; looks along -Z, +Y up */
    float window[4];     /* left, right, bottom, top at z = -1 */
    int width, height;   /* pixels */
};

struct scene_world {
    float radiance[3]; /* W/m2/sr, a factor where there is a texture */
    int texture;       /* an image texture, or SCENE_NONE */
    float transform[12];
};

enum image_colour_space { IMAGE_SRGB, IMAGE_LINEAR, IMAGE_DATA };

struct scene_image {
    char *file; /* path to open, folder included */
    enum image_colour_space colour_space;
};

enum texture_type { TEXTURE_IMAGE, TEXTURE_CHECKER };
enum texture_interpolation { TEXTURE_LINEAR, TEXTURE_CLOSEST };
enum texture_extension { TEXTURE_REPEAT, TEXTURE_EXTEND, TEXTURE_CLIP };

struct scene_texture {
    enum texture_type type;
    int image; /* TEXTURE_IMAGE */
    enum texture_interpolation interpolation;
    enum texture_extension extension;
    float colour1[3], colour2[3], scale; /* TEXTURE_CHECKER */
    float uv_transform[6];               /* 2 x 3 */
};

/* A constant, or a texture that replaces it. */
struct scene_colour {
    float value[3];
    int texture;
};
struct scene_scalar {
    float value;
    int texture;
};

enum material_type { MATERIAL_DIFFUSE, MATERIAL_PHONG, MATERIAL_PRINCIPLED };

struct scene_material {
    char *name;
    enum material_type type;
    struct scene_colour colour;                  /* colour, kd or base_colour */
    struct scene_colour ks;                      /* PHONG */
    struct scene_scalar exponent;                /* PHONG */
    struct scene_scalar metallic, roughness;     /* PRINCIPLED */
    float ior, specular_level, specular_tint[3]; /* PRINCIPLED */
    float emission[3];                           /* W/m2/sr */
    bool emission_front_only;
};

enum subdivision_scheme { SUBDIVISION_CATMULL_CLARK, SUBDIVISION_BILINEAR };
enum subdivision_boundary { BOUNDARY_EDGE_ONLY, BOUNDARY_EDGE_AND_CORNER };
/* In OpenSubdiv's order and words. */
enum subdivision_uv_boundary {
    UV_BOUNDARY_NONE,
    UV_BOUNDARY_CORNERS_ONLY,
    UV_BOUNDARY_CORNERS_PLUS1,
    UV_BOUNDARY_CORNERS_PLUS2,
    UV_BOUNDARY_BOUNDARIES,
    UV_BOUNDARY_ALL
};

/* Polygons in object space; a cage where `subdivided`. The arrays are spans of scene.buffer. */
struct scene_mesh {
    char *name;
    uint32_t vertex_count, face_count, corner_count;
    const float *positions;         /* 3 a vertex */
    const uint32_t *face_sizes;     /* corners of each face, >= 3 */
    const uint32_t *corners;        /* vertex of each corner */
    const float *normals;           /* 3 a corner, of any length; NULL: flat */
    const float *uvs;               /* 2 a corner, or NULL */
    const uint32_t *face_materials; /* slot of each face, or NULL: all 0 */
    bool subdivided, smooth;        /* smooth: limit normals */
    enum subdivision_scheme scheme;
    enum subdivision_boundary boundary;
    enum subdivision_uv_boundary uv_boundary;
    uint32_t crease_count, sharp_corner_count;
    const uint32_t *crease_edges; /* 2 vertices each, an edge of some face */
    const float *crease_sharpness;
    const uint32_t *corner_vertices;
    const float *corner_sharpness;
};

struct scene_object {
    char *name;
    int mesh;
    uint32_t slot_count;
    int *materials;      /* one a slot; owned. No slots: the default material */
    float transform[12]; /* object to world */
};

enum light_type { LIGHT_POINT, LIGHT_SPOT, LIGHT_AREA, LIGHT_SUN };
enum light_shape { LIGHT_SPHERE, LIGHT_DISC, LIGHT_RECTANGLE, LIGHT_ELLIPSE };

struct scene_light {
    char *name;
    enum light_type type;
    enum light_shape shape; /* POINT, SPOT: sphere or disc; AREA: rectangle or ellipse */
    float transform[12];    /* light to world; shines along -Z */
    float power[3];         /* W; SUN: irradiance, W/m2 */
    float radius;           /* POINT, SPOT: m */
    float size[2];          /* AREA: full extents, m */
    float angle;            /* SPOT: full opening; SUN: full diameter; rad */
    float blend;            /* SPOT: 0 .. 1 */
    float spread;           /* AREA: full opening, rad; pi: all */
};

struct scene_note {
    char *object, *material, *node, *text;
}; /* the first three may be NULL */

struct scene {
    struct scene_camera camera;
    struct scene_world world;
    int image_count, texture_count, material_count, mesh_count, object_count, light_count, note_count;
    struct scene_image *images;
    struct scene_texture *textures;
    struct scene_material *materials;
    struct scene_mesh *meshes;
    struct scene_object *objects;
    struct scene_light *lights;
    struct scene_note *notes;
    unsigned char *buffer; /* scene.bin */
    size_t buffer_bytes;
};

/* Reads folder/scene.json and scene.bin. On failure returns false, leaves *scene empty (nothing to free) and puts one
 * sentence in error: file, line:column or JSON path, what was found, what was expected. */
bool scene_read(const char *folder, struct scene *scene, char error[SCENE_ERROR]);

/* Replaces a constant or textured property of a material: "materials/NAME/exponent=VALUE" (phong, >= 0) or
 * "materials/NAME/roughness=VALUE" (principled, 0 .. 1), where NAME may hold slashes; or moves the camera:
 * "camera/shift=X,Y,Z" (m, world space, from where it stands). False and one sentence where the text is no such thing
 * or no material has the name or the property. */
bool scene_set(struct scene *scene, const char *assignment, char error[SCENE_ERROR]);

/* Frees all that *scene owns and empties it; an empty one is fine. */
void scene_free(struct scene *scene);

#endif
