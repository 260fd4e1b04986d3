/* SPDX-License-Identifier: Apache-2.0 */
/* Reads tests/scenes/example, and copies of it with one fault each, which the error must name. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "import/scene.h"

#define EXAMPLE "tests/scenes/example"
#define LENGTH(a) (sizeof(a) / sizeof(a)[0])

static char *json;                 /* the example's scene.json */
static unsigned char buffer[4096]; /* its scene.bin */
static size_t buffer_bytes;
static char folder[4096]; /* a temporary copy */

static size_t read_whole(const char *path, void *bytes, size_t size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t count = fread(bytes, 1, size - 1, file);
    assert_true(feof(file));
    fclose(file);
    return count;
}

static void write_whole(const char *name, const void *bytes, size_t size)
{
    char path[5000];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static int set_up(void **state)
{
    (void)state;
    json = calloc(1, 1 << 16);
    read_whole(EXAMPLE "/scene.json", json, 1 << 16);
    buffer_bytes = read_whole(EXAMPLE "/scene.bin", buffer, sizeof buffer);
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/burnish-scene-XXXXXX", parent ? parent : P_tmpdir);
    assert_non_null(mkdtemp(folder));
    char path[5000];
    snprintf(path, sizeof path, "%s/textures", folder);
    assert_int_equal(mkdir(path, 0755), 0);
    write_whole("textures/wood.png", "", 0); /* that it is there is all that the reader asks */
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    const char *names[] = {"textures/wood.png", "textures", "scene.json", "scene.bin", ""};
    for (size_t i = 0; i < LENGTH(names); i++) {
        char path[5000];
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        remove(path);
    }
    free(json);
    return 0;
}

/* Reads the copy, which must fail with a sentence that has `fragment` in it and leave the scene empty. */
static void expect_error(const char *fragment)
{
    static const struct scene empty;
    struct scene scene;
    char error[SCENE_ERROR] = "";
    memset(&scene, 0xff, sizeof scene);
    if (scene_read(folder, &scene, error)) fail_msg("read without an error, expected \"%s\"", fragment);
    if (!strstr(error, fragment) || !strstr(error, folder) || strchr(error, '\n'))
        fail_msg("\"%s\" lacks \"%s\"", error, fragment);
    assert_memory_equal(&scene, &empty, sizeof scene);
}

static void write_json(const char *find, const char *replace)
{
    char *text = malloc(1 << 16), *place = strstr(json, find);
    if (!place) fail_msg("the example lacks %s", find);
    int size = snprintf(text, 1 << 16, "%.*s%s%s", (int)(place - json), json, replace, place + strlen(find));
    write_whole("scene.json", text, size);
    free(text);
}

static void reads_the_example(void **state)
{
    (void)state;
    struct scene s;
    char error[SCENE_ERROR];
    if (!scene_read(EXAMPLE, &s, error)) fail_msg("%s", error);
    const float camera[12] = {1, 0, 0, 0, 0, 0, -1, -4, 0, 1, 0, 1};
    assert_memory_equal(s.camera.transform, camera, sizeof camera);
    assert_true(s.camera.window[0] == -.325f && s.camera.window[3] == .325f);
    assert_true(s.camera.width == 384 && s.camera.height == 384);
    assert_true(s.world.radiance[2] == 1 && s.world.texture == 0 && s.world.transform[10] == 1);

    assert_int_equal(s.image_count, 1);
    assert_string_equal(s.images[0].file, EXAMPLE "/textures/wood.png");
    assert_int_equal(s.images[0].colour_space, IMAGE_SRGB);
    assert_int_equal(s.texture_count, 2);
    assert_true(s.textures[0].type == TEXTURE_IMAGE && s.textures[0].image == 0);
    assert_true(s.textures[0].interpolation == TEXTURE_LINEAR && s.textures[0].extension == TEXTURE_REPEAT);
    assert_true(s.textures[1].type == TEXTURE_CHECKER && s.textures[1].image == SCENE_NONE);
    assert_true(s.textures[1].colour1[0] == .7f && s.textures[1].colour2[1] == .6f && s.textures[1].scale == 16);
    assert_true(s.textures[1].uv_transform[4] == 1);

    assert_int_equal(s.material_count, 4);
    assert_string_equal(s.materials[0].name, "Wall");
    assert_true(s.materials[0].type == MATERIAL_DIFFUSE && s.materials[0].colour.value[1] == .6f);
    assert_true(s.materials[0].colour.texture == SCENE_NONE && s.materials[0].ks.texture == SCENE_NONE);
    assert_true(s.materials[1].type == MATERIAL_PHONG && s.materials[1].colour.value[0] == .4f);
    assert_true(s.materials[1].ks.value[2] == .3f && s.materials[1].exponent.value == 100);
    assert_true(s.materials[2].type == MATERIAL_PRINCIPLED && s.materials[2].colour.texture == 1);
    assert_true(s.materials[2].roughness.texture == 0 && s.materials[2].metallic.texture == SCENE_NONE);
    assert_true(s.materials[2].ior == 1.5f && s.materials[2].specular_level == .5f);
    assert_true(s.materials[2].specular_tint[2] == 1);
    assert_true(s.materials[3].emission[0] == 15 && s.materials[3].emission_front_only);
    assert_true(s.materials[2].emission[0] == 0 && !s.materials[2].emission_front_only);

    assert_int_equal(s.mesh_count, 2);
    const struct scene_mesh *house = &s.meshes[0], *box = &s.meshes[1];
    assert_true(house->vertex_count == 5 && house->face_count == 2 && house->corner_count == 7);
    assert_true(house->positions[14] == 3 && house->face_sizes[1] == 3 && house->corners[6] == 4);
    assert_true(house->normals[1] == -1 && house->uvs[13] == 1.5f && house->face_materials[1] == 1);
    assert_true(!house->subdivided && !house->crease_edges);
    assert_true(box->subdivided && box->smooth && !box->normals && !box->face_materials);
    assert_true(box->scheme == SUBDIVISION_CATMULL_CLARK && box->boundary == BOUNDARY_EDGE_ONLY);
    assert_true(box->uv_boundary == UV_BOUNDARY_CORNERS_ONLY);
    assert_true(box->crease_count == 4 && box->crease_edges[7] == 4 && box->crease_sharpness[0] == 2.5f);
    assert_true(box->sharp_corner_count == 1 && box->corner_vertices[0] == 0 && box->corner_sharpness[0] == 10);

    assert_int_equal(s.object_count, 3);
    assert_string_equal(s.objects[1].name, "Box.001");
    assert_true(s.objects[0].slot_count == 2 && s.objects[0].materials[1] == 3);
    assert_true(s.objects[1].mesh == 1 && s.objects[1].materials[0] == 2 && s.objects[1].transform[11] == .5f);

    assert_int_equal(s.light_count, 4);
    const struct scene_light *l = s.lights;
    assert_true(l[0].type == LIGHT_AREA && l[0].shape == LIGHT_RECTANGLE && l[0].size[1] == .5f);
    assert_true(l[0].spread <= (float)M_PI && l[0].spread > 3.14f && l[0].power[2] == 10 && l[0].transform[11] == 4);
    assert_true(l[1].type == LIGHT_POINT && l[1].shape == LIGHT_SPHERE && l[1].radius == .1f);
    assert_true(l[2].type == LIGHT_SPOT && l[2].shape == LIGHT_DISC && l[2].angle == .8f && l[2].blend == .15f);
    assert_true(l[3].type == LIGHT_SUN && l[3].power[0] == 1 && l[3].angle == .00918f);

    assert_int_equal(s.note_count, 1);
    assert_string_equal(s.notes[0].node, "Noise Texture");
    assert_string_equal(s.notes[0].text, "left out: replaced by its mean colour");
    scene_free(&s);
    scene_free(&s); /* an empty one is fine */
}

/* What may be left out. */
static void reads_without_the_optional(void **state)
{
    (void)state;
    struct scene s;
    char error[SCENE_ERROR];
    write_whole("scene.bin", buffer, buffer_bytes);
    write_json("\"world\": {\"radiance\": [1, 1, 1], \"texture\": 0, \"transform\": [1,0,0,0, 0,1,0,0, 0,0,1,0]},", "");
    if (!scene_read(folder, &s, error)) fail_msg("%s", error);
    assert_true(s.world.radiance[0] == 0 && s.world.texture == SCENE_NONE && s.world.transform[0] == 1);
    scene_free(&s);
    write_json("\"materials\": [0, 3]", "\"materials\": []");
    if (!scene_read(folder, &s, error)) fail_msg("%s", error);
    assert_int_equal(s.objects[0].slot_count, 0);
    scene_free(&s);
    write_json(", \"spread\": 3.1415927", "");
    if (!scene_read(folder, &s, error)) fail_msg("%s", error);
    assert_true(s.lights[0].spread == (float)M_PI);
    scene_free(&s);
}

static void names_faults_of_the_document(void **state)
{
    (void)state;
    static const char *const faults[][3] = {
        /* find, replace, what the error says */
        {"\"up\": \"z\",", "\"up\" \"z\",", "scene.json:4:"},
        {"\"up\": \"z\",", "\"up\": \"z\",\n\"up\": \"z\",", "scene.json:5:"},
        {"\"up\": \"z\",", "\"up\": \"z\",\"up\": \"z\",", "duplicate object key"},
        {"\"version\": 1", "\"version\": 1e999", "scene.json:2:"},
        {"\"generator\":", "\"seed\": 1, \"generator\":", "scene.json: seed: unknown key"},
        {"\"size\": [0.5, 0.5]", "\"size\": [0.5, 0.5], \"spred\": 1", "lights[0].spred: unknown key"},
        {"\"colour\": [0.6", "\"ks\": 1, \"colour\": [0.6", "materials[0].ks: unknown key"},
        {"{\"texture\": 1}", "{\"texture\": 1, \"scale\": 2}", "materials[2].base_colour.scale: unknown key"},
        {"\"burnish-scene\"", "\"glTF\"", "format: found \"glTF\", expected \"burnish-scene\""},
        {"\"version\": 1", "\"version\": 2", "version: found 2, expected at most 1: the scene is newer"},
        {"\"version\": 1", "\"version\": 0", "version: found 0"},
        {"\"version\": 1", "\"version\": \"1\"", "version: found \"1\""},
        {"\"metre\"", "\"a\\nb\"", "units: found \"a b\", expected"},
        {"\"up\": \"z\",", "\"up\": \"\n", "scene.json:4:"},
        {"\"metre\"", "\"foot\"", "units: found \"foot\", expected \"metre\""},
        {"\"z\"", "\"y\"", "up: found \"y\""},
        {"\"linear-rec709\"", "\"aces\"", "colour_space: found \"aces\""},
        {"\"camera\": {", "\"camera\": [{}], \"c\": {", "scene.json: camera: found a list of 1, expected an object"},
        {"\"meshes\": [", "\"meshes\": null, \"m\": [", "meshes: found null, expected a list"},
        {"\"lights\": [", "\"lights\": [3, ", "lights[0]: found 3, expected an object"},
        {"\"perspective\"", "\"fisheye\"", "camera.type: found \"fisheye\""},
        {"[1,0,0,0, 0,0,-1,-4, 0,1,0,1]", "\"x\"", "camera.transform: found \"x\", expected 12 numbers"},
        {"[1,0,0,0, 0,0,-1,-4, 0,1,0,1]", "[1,0]", "camera.transform: found a list of 2, expected 12 numbers"},
        {"[1,0,0,0, 0,0,-1,-4, 0,1,0,1]", "[1,0,0,0, 0,0,-1,-4, 0,1,0,null]", "camera.transform: number 11 is null"},
        {"[1,0,0,0, 0,0,-1,-4, 0,1,0,1]", "[1,0,0,1e39, 0,0,-1,-4, 0,1,0,1]", "camera.transform: number 3 is 1e+39"},
        {"[0,-1,0,3, 1,0,0,0, 0,0,1,0.5]", "[0,-1,0,3, 1,0,0,0, 0,0,0,0.5]", "objects[2].transform: determinant"},
        {"[0,-1,0,3, 1,0,0,0, 0,0,1,0.5]", "[1,2,3,0, 4,5,6,0, 7,8,9,0]", "objects[2].transform: determinant"},
        {"[-0.325, 0.325, -0.325, 0.325]", "[0.3, -0.3, -0.3, 0.3]", "camera.window: found [0.3, -0.3"},
        {"[-0.325, 0.325, -0.325, 0.325]", "[-0.3, 0.3, 0.3, 0.3]", "camera.window"},
        {"[384, 384]", "[0, 384]", "camera.resolution"},
        {"[384, 384]", "[384, 65537]", "camera.resolution: found 65537"},
        {"[384, 384]", "[384, 1.5]", "camera.resolution: found 1.5"},
        {"\"radiance\": [1, 1, 1]", "\"radiance\": [1, -1, 1]", "world.radiance: number 1 is -1"},
        {"\"texture\": 0, \"transform\"", "\"texture\": 2, \"transform\"", "world.texture: found 2"},
        {"\"texture\": 0, \"transform\"", "\"texture\": 1, \"transform\"", "world.texture: texture 1 is a checker"},
        {"textures/wood.png", "textures/oak.png", "images[0].file: "},
        {"textures/wood.png", "textures/oak.png", "textures/oak.png cannot be read: No such file"},
        {"textures/wood.png", "textures", "is not a file"},
        {"\"srgb\"", "\"aces\"", "images[0].colour_space: found \"aces\", expected \"srgb\", \"linear\" or \"data\""},
        {"\"image\": 0", "\"image\": 1", "textures[0].image: found 1, expected the index of one of 1 images"},
        {"\"image\": 0", "\"image\": -1", "textures[0].image: found -1"},
        {"\"image\": 0", "\"image\": 0.5", "textures[0].image: found 0.5"},
        {"\"repeat\"", "\"mirror\"", "textures[0].extension: found \"mirror\""},
        {"\"scale\": 16", "\"scale\": 0", "textures[1].scale: found 0"},
        {"\"phong\"", "\"ward\"", "materials[1].type: found \"ward\""},
        {"\"exponent\": 100", "\"exponent\": -1", "materials[1].exponent: found -1, expected a number of at least 0"},
        {"\"exponent\": 100", "\"exponent\": {}", "materials[1].exponent.texture: found nothing"},
        {"\"metallic\": 0", "\"metallic\": 1.5", "materials[2].metallic: found 1.5, expected a number from 0 to 1"},
        {"{\"texture\": 0}", "1.5", "materials[2].roughness: found 1.5"},
        {"\"ior\": 1.5", "\"ior\": 0.5", "materials[2].ior: found 0.5"},
        {"\"ior\": 1.5", "\"ior\": 1e39", "materials[2].ior: found 1e+39"},
        {"[15,15,15]", "[15,-1,15]", "materials[3].emission: number 1 is -1"},
        {"\"front\"", "\"back\"", "materials[3].emission_sides: found \"back\""},
        {"\"name\": \"House\", \"pos", "\"name\": 5, \"pos", "meshes[0].name: found 5, expected a text"},
        {"\"uvs\": 4", "\"uvs\": 14", "meshes[0].uvs: found 14, expected the index of one of 14 views"},
        {"\"uvs\": 4", "\"uvs\": 3", "meshes[0].uvs: view 3 holds float3, expected float2"},
        {"\"uvs\": 4", "\"uvs\": 9", "meshes[0].uvs: found 24 elements, expected 7: one a corner"},
        {"\"normals\": 3", "\"normals\": 0", "meshes[0].normals: found 5 elements, expected 7"},
        {"\"face_materials\": 5", "\"face_materials\": 2", "meshes[0].face_materials: found 7 elements, expected 2"},
        {"\"corners\": 2", "\"corners\": 7", "meshes[0].corners: found 6 corners, expected 7"},
        {"\"uvs\": 9", "\"uvs\": 9, \"normals\": 10", "meshes[1].normals: view 10 holds uint2"},
        {"\"uvs\": 4, \"face_materials\": 5",
         "\"uvs\": 4, \"subdivision\": {\"scheme\": \"bilinear\", \"boundary\": \"edge-only\", \"uv_boundary\": "
         "\"all\","
         "\"smooth\": true}",
         "meshes[0].normals: found normals, expected none: the mesh is a cage"},
        {"\"catmull-clark\"", "\"loop\"", "meshes[1].subdivision.scheme: found \"loop\""},
        {"\"crease_sharpness\": 11,", "", "meshes[1].subdivision.crease_sharpness: found nothing"},
        {"\"crease_sharpness\": 11", "\"crease_sharpness\": 13", "crease_sharpness: found 1 elements, expected 4"},
        {"\"smooth\": true", "\"smooth\": 1", "meshes[1].subdivision.smooth: found 1, expected true or false"},
        {"\"mesh\": 0", "\"mash\": 0", "objects[0].mesh: found nothing"},
        {"\"mesh\": 0", "\"mesh\": 2", "objects[0].mesh: found 2, expected the index of one of 2 meshes"},
        {"[0, 3]", "[0, 9]", "objects[0].materials[1]: found 9, expected the index of one of 4 materials"},
        {"[0, 3]", "[0]", "objects[0].materials: found 1, expected 2: a face of mesh \"House\" uses slot 1"},
        {"\"power\": [10,10,10]", "\"power\": [10,-10,10]", "lights[0].power: number 1 is -10"},
        {"\"size\": [0.5, 0.5]", "\"size\": [0.5, 0]", "lights[0].size: found [0.5, 0]"},
        {"\"rectangle\"", "\"sphere\"", "lights[0].shape: found \"sphere\", expected \"rectangle\" or \"ellipse\""},
        {"\"radius\": 0.1", "\"radius\": -1", "lights[1].radius: found -1"},
        {"\"blend\": 0.15", "\"blend\": 2", "lights[2].blend: found 2"},
        {"\"angle\": 0.8", "\"angle\": 4", "lights[2].angle: found 4"},
        {"\"irradiance\"", "\"power\"", "lights[3].irradiance: found nothing"},
        {"\"text\":", "\"txt\":", "notes[0].text: found nothing"},
        {"\"bytes\": 708", "\"bytes\": 712", "scene.bin has 708 bytes, expected 712"},
        {"\"bytes\": 708", "\"bytes\": -1", "buffer.bytes: found -1"},
        {"\"bytes\": 708", "\"bytes\": 1e300", "buffer.bytes: found 1e+300"},
        {"\"file\": \"scene.bin\"", "\"file\": \"mesh.bin\"", "mesh.bin cannot be opened: No such file"},
        {"\"file\": \"scene.bin\"", "\"file\": \"textures\"", "is not a file"},
        {"\"offset\": 60", "\"offset\": 62", "views[1].offset: found 62, expected a multiple of 4"},
        {"\"offset\": 704, \"count\": 1", "\"offset\": 704, \"count\": 2",
         "views[13]: ends at byte 712, but the buffer has 708"},
        {"\"offset\": 704", "\"offset\": 4503599627370496", "views[13]: ends at byte"},
        {"\"count\": 5", "\"count\": -5", "views[0].count: found -5"},
        {"\"count\": 5", "\"count\": 2147483647", "views[0]: ends at byte"},
        {"\"float3\"", "\"half3\"", "views[0].type: found \"half3\""},
    };
    write_whole("scene.bin", buffer, buffer_bytes);
    for (size_t i = 0; i < LENGTH(faults); i++) {
        write_json(faults[i][0], faults[i][1]);
        expect_error(faults[i][2]);
    }
    write_whole("scene.json", "[]", 2);
    expect_error("scene.json: found a list of 0, expected an object");
    write_whole("scene.json", "", 0);
    expect_error("scene.json:1:");
}

static void names_faults_of_the_buffer(void **state)
{
    (void)state;
    const uint32_t nan_bits = 0x7fc00000, infinity_bits = 0xff800000, minus_one_bits = 0xbf800000;
    const struct {
        size_t offset;
        uint32_t bits;
        const char *fragment;
    } faults[] = {
        {12, nan_bits, "meshes[0].positions: mesh \"House\": element 1 of view 0 holds nan"},
        {12 * 4 + 8, infinity_bits, "meshes[0].positions: mesh \"House\": element 4 of view 0 holds -inf"},
        {96 + 12 * 6, nan_bits, "meshes[0].normals: mesh \"House\": element 6 of view 3 holds nan"},
        {180 + 4, nan_bits, "meshes[0].uvs: mesh \"House\": element 0 of view 4 holds nan"},
        {60, 2, "meshes[0].face_sizes: face 0 has 2 corners, expected 3 or more"},
        {64, 4, "meshes[0].corners: found 7 corners, expected 8"},
        {64, UINT32_MAX, "meshes[0].corners: found 7 corners, expected 4294967299"},
        {68, 5, "meshes[0].corners: element 0 names vertex 5, expected one of 5"},
        {240, 2, "objects[0].materials: found 2, expected 3: a face of mesh \"House\" uses slot 2"},
        {652 + 4 * 3, 8, "meshes[1].subdivision.crease_edges: element 3 names vertex 8, expected one of 8"},
        {652 + 4 * 1, 6, "crease_edges: element 0 joins vertices 4 and 6, expected an edge of a face"},
        {652 + 4 * 2, 4, "crease_edges: element 1 joins vertices 4 and 6, expected an edge of a face"},
        {652 + 4 * 3, 5, "crease_edges: element 1 joins vertices 5 and 5, expected an edge of a face"},
        {684, minus_one_bits, "meshes[1].subdivision.crease_sharpness: element 0 is -1"},
        {684, nan_bits, "meshes[1].subdivision.crease_sharpness: mesh \"Box\": element 0 of view 11 holds nan"},
        {700, 8, "meshes[1].subdivision.corner_vertices: element 0 names vertex 8"},
        {704, minus_one_bits, "meshes[1].subdivision.corner_sharpness: element 0 is -1"},
    };
    write_json("", "");
    for (size_t i = 0; i < LENGTH(faults); i++) {
        unsigned char copy[sizeof buffer];
        memcpy(copy, buffer, buffer_bytes);
        memcpy(copy + faults[i].offset, &faults[i].bits, 4);
        write_whole("scene.bin", copy, buffer_bytes);
        expect_error(faults[i].fragment);
    }
    unsigned char twice[sizeof buffer];
    memcpy(twice, buffer, buffer_bytes);
    memcpy(twice + 652 + 8, (uint32_t[2]){5, 4}, 8);
    write_whole("scene.bin", twice, buffer_bytes);
    expect_error("crease_edges: the edge of vertices 4 and 5 is named twice");
    write_whole("scene.bin", buffer, 500);
    expect_error("scene.bin has 500 bytes, expected 708");
    write_whole("scene.bin", buffer, buffer_bytes + 4);
    expect_error("scene.bin has 712 bytes, expected 708");
}

static void names_a_folder_that_is_no_scene(void **state)
{
    (void)state;
    struct scene scene;
    char error[SCENE_ERROR];
    assert_false(scene_read("no/such/folder", &scene, error));
    assert_string_equal(error, "no/such/folder/scene.json: cannot be opened: No such file or directory");
    char long_name[6000];
    memset(long_name, 'a', sizeof long_name);
    long_name[sizeof long_name - 1] = 0;
    assert_false(scene_read(long_name, &scene, error));
    assert_non_null(strstr(error, "longer"));
}

static void sets_a_property(void **state)
{
    (void)state;
    struct scene scene;
    char error[SCENE_ERROR];
    assert_true(scene_read(EXAMPLE, &scene, error));
    struct scene_material *phong = NULL, *principled = NULL;
    for (int i = 0; i < scene.material_count; i++) {
        if (scene.materials[i].type == MATERIAL_PHONG) phong = &scene.materials[i];
        if (scene.materials[i].type == MATERIAL_PRINCIPLED) principled = &scene.materials[i];
    }
    assert_non_null(phong);
    assert_non_null(principled);
    free(phong->name);
    phong->name = strdup("a/b=c");
    assert_true(scene_set(&scene, "materials/a/b=c/exponent=12.5", error));
    assert_true(phong->exponent.value == 12.5f && phong->exponent.texture == SCENE_NONE);
    char text[256];
    snprintf(text, sizeof text, "materials/%s/roughness=.25", principled->name);
    assert_true(scene_set(&scene, text, error));
    assert_true(principled->roughness.value == .25f);
    const float *camera = scene.camera.transform, at[3] = {camera[3], camera[7], camera[11]};
    assert_true(scene_set(&scene, "camera/shift=.5,-2,1e-1", error) && scene_set(&scene, "camera/shift=0,0,1", error));
    assert_true(camera[3] == at[0] + .5f && camera[7] == at[1] - 2 && camera[11] == at[2] + .1f + 1);
    const char *wrong[][2] = {{"camera/shift=1,2", "found '1,2'"},
                              {"camera/shift=1,2,3,4", "found '1,2,3,4'"},
                              {"camera/shift=1,inf,3", "found '1,inf,3'"},
                              {"camera/shift=", "three numbers"},
                              {"camera/tilt=1", "expected materials/NAME"},
                              {"materials/a/b=c/exponent=-1", "found '-1'"},
                              {"materials/a/b=c/exponent=nan", "found 'nan'"},
                              {"materials/a/b=c/exponent=", "found ''"},
                              {"materials/a/b=c/exponent=1x", "found '1x'"},
                              {"materials/a/b=c/roughness=1", "no material"},
                              {"materials/a/b=/exponent=1", "no material 'a/b='"},
                              {"materials/a/b=c/exp=1", "the property 'exp'"},
                              {"material/a/exponent=1", "expected materials/NAME"},
                              {"materials/exponent=1", "expected materials/NAME"},
                              {"materials/a/b=c/exponent", "no material"}};
    for (size_t i = 0; i < LENGTH(wrong); i++) {
        assert_false(scene_set(&scene, wrong[i][0], error));
        if (!strstr(error, wrong[i][1])) fail_msg("%s: \"%s\", expected \"%s\"", wrong[i][0], error, wrong[i][1]);
    }
    assert_true(camera[3] == at[0] + .5f);
    scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_the_example),
        cmocka_unit_test(reads_without_the_optional),
        cmocka_unit_test(names_faults_of_the_document),
        cmocka_unit_test(names_faults_of_the_buffer),
        cmocka_unit_test(names_a_folder_that_is_no_scene),
        cmocka_unit_test(sets_a_property),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
