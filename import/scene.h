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

enum camera_type { CAMERA_PERSPECTIVE, CAMERA_ORTHOGRAPHIC, CAMERA_PANORAMIC };

/* A thin lens; a pinhole where radius is 0. */
struct scene_lens {
    float radius, focus;   /* m; focus along -Z */
    int blades;            /* of its opening, 0: round */
    float rotation, ratio; /* of the opening: rad; its height over its width */
};

struct scene_camera {
    float transform[12]; /* camera to world, 3 x 4; looks along -Z, +Y up */
    float window[4];     /* left, right, bottom, top at z = -1; ORTHOGRAPHIC: in m; PANORAMIC: angles, rad */
    int width, height;   /* pixels */
    enum camera_type type;
    struct scene_lens lens; /* PERSPECTIVE */
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

enum texture_type { TEXTURE_IMAGE, TEXTURE_CHECKER, TEXTURE_ANGLE };
enum texture_interpolation { TEXTURE_LINEAR, TEXTURE_CLOSEST };
enum texture_extension { TEXTURE_REPEAT, TEXTURE_EXTEND, TEXTURE_CLIP, TEXTURE_MIRROR };

struct scene_texture {
    enum texture_type type;
    int image; /* IMAGE */
    enum texture_interpolation interpolation;
    enum texture_extension extension;
    bool alpha;                          /* IMAGE: its alpha channel, as grey */
    float colour1[3], colour2[3], scale; /* CHECKER */
    float uv_transform[6];               /* IMAGE, CHECKER: 2 x 3 */
    uint32_t sample_count;               /* ANGLE: >= 2, from |cos| 0 to 1, on either side; spans of scene.buffer */
    const float *front, *back;
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

enum closure_type {
    CLOSURE_DIFFUSE,
    CLOSURE_PHONG,
    CLOSURE_GLOSSY,
    CLOSURE_PRINCIPLED,
    CLOSURE_SHEEN,
    CLOSURE_GLASS,
    CLOSURE_REFRACTION,
    CLOSURE_TRANSLUCENT,
    CLOSURE_TRANSPARENT
};
enum closure_distribution { CLOSURE_GGX, CLOSURE_MULTI_GGX, CLOSURE_BECKMANN, CLOSURE_ASHIKHMIN_SHIRLEY };

/* A summand of a material. What its type has no word for has its default. */
struct scene_closure {
    enum closure_type type;
    bool front, back; /* the sides of a face that it is on */
    struct scene_colour weight, colour /* colour, kd or base_colour */, ks, specular_tint, coat_tint, sheen_tint;
    struct scene_scalar exponent, metallic, roughness, ior, specular_level, transmission;
    struct scene_scalar anisotropy, rotation; /* -1 .. 1; turns */
    struct scene_scalar coat_weight, coat_roughness, coat_ior, sheen_weight, sheen_roughness;
    enum closure_distribution distribution;
};

enum normal_type { NORMAL_OF_MESH, NORMAL_MAP, NORMAL_HEIGHT };

/* What bends the shading normal. */
struct scene_normal {
    enum normal_type type;
    int texture; /* an image or a checker */
    float strength, distance; /* HEIGHT: m */
    float filter;             /* HEIGHT: pixels over which heights are compared */
    bool invert;              /* HEIGHT */
};

struct scene_material {
    char *name;
    int closure_count;
    struct scene_closure *closures; /* owned */
    struct scene_colour emission;   /* W/m2/sr */
    bool emission_front, emission_back;
    struct scene_normal normal;
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
    bool hidden;         /* camera rays don't see it */
    bool shadowless;     /* it casts no shadow */
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
    bool seen;              /* by camera rays */
    bool shadowless;        /* nothing casts a shadow in its light */
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

/* Replaces a property of a material on each of its closures that has it: "materials/NAME/exponent=VALUE" (phong, >= 0)
 * or "materials/NAME/roughness=VALUE" (0 .. 1; a principled one's coat and sheen keep theirs), where NAME may hold
 * slashes; or moves the camera: "camera/shift=X,Y,Z" (m, world space, from where it stands). False and one sentence
 * where the text is no such thing or no material has the name or the property. */
bool scene_set(struct scene *scene, const char *assignment, char error[SCENE_ERROR]);

/* A closure of this type with the format's defaults, black; on both sides. */
struct scene_closure scene_closure_of(enum closure_type type);

/* Whether the format gives closures of this type a roughness (a principled one's own, not its coat's). */
bool scene_closure_has_roughness(enum closure_type type);

/* Frees all that *scene owns and empties it; an empty one is fine. */
void scene_free(struct scene *scene);

#endif
