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
    assert_true(s.camera.width == 384 && s.camera.height == 384 && s.camera.type == CAMERA_PERSPECTIVE);
    assert_true(s.camera.lens.radius == .01f && s.camera.lens.focus == 4 && s.camera.lens.blades == 6);
    assert_true(s.camera.lens.rotation == .2f && s.camera.lens.ratio == 1);
    assert_true(s.world.radiance[2] == 1 && s.world.texture == 0 && s.world.transform[10] == 1);

    assert_int_equal(s.image_count, 1);
    assert_string_equal(s.images[0].file, EXAMPLE "/textures/wood.png");
    assert_int_equal(s.images[0].colour_space, IMAGE_SRGB);
    assert_int_equal(s.texture_count, 4);
    assert_true(s.textures[0].type == TEXTURE_IMAGE && s.textures[0].image == 0);
    assert_true(s.textures[0].interpolation == TEXTURE_LINEAR && s.textures[0].extension == TEXTURE_REPEAT);
    assert_true(s.textures[1].type == TEXTURE_CHECKER && s.textures[1].image == SCENE_NONE);
    assert_true(s.textures[1].colour1[0] == .7f && s.textures[1].colour2[1] == .6f && s.textures[1].scale == 16);
    assert_true(s.textures[1].uv_transform[4] == 1 && !s.textures[0].alpha);
    assert_true(s.textures[2].alpha && s.textures[2].interpolation == TEXTURE_CLOSEST);
    assert_int_equal(s.textures[2].extension, TEXTURE_MIRROR);
    assert_true(s.textures[3].type == TEXTURE_ANGLE && s.textures[3].sample_count == 3);
    assert_true(s.textures[3].front[5] == .3f && s.textures[3].back[8] == .4f);

    assert_int_equal(s.material_count, 6);
    assert_string_equal(s.materials[0].name, "Wall");
    assert_int_equal(s.materials[0].closure_count, 1);
    const struct scene_closure *wall = s.materials[0].closures, *back = s.materials[1].closures;
    assert_true(wall->type == CLOSURE_DIFFUSE && wall->colour.value[1] == .6f && wall->front && wall->back);
    assert_true(wall->colour.texture == SCENE_NONE && wall->weight.texture == SCENE_NONE && wall->weight.value[2] == 1);
    assert_true(back->type == CLOSURE_PHONG && back->colour.value[0] == .4f);
    assert_true(back->ks.value[2] == .3f && back->exponent.value == 100);
    assert_true(s.materials[0].normal.type == NORMAL_OF_MESH && s.materials[0].emission.texture == SCENE_NONE);

    const struct scene_closure *ball = s.materials[2].closures;
    assert_true(ball->type == CLOSURE_PRINCIPLED && ball->colour.texture == 1 && ball->specular_tint.value[2] == 1);
    assert_true(ball->roughness.texture == 0 && ball->metallic.texture == SCENE_NONE && ball->ior.value == 1.5f);
    assert_true(ball->specular_level.value == .5f && ball->transmission.value == .2f);
    assert_true(ball->anisotropy.value == -.5f && ball->rotation.value == .25f);
    assert_true(ball->coat_weight.value == .3f && ball->coat_roughness.value == .1f && ball->coat_ior.value == 1.6f);
    assert_true(ball->coat_tint.value[2] == .8f && ball->sheen_weight.value == .1f);
    assert_true(ball->sheen_roughness.value == .4f && ball->sheen_tint.value[2] == .9f);
    assert_int_equal(ball->distribution, CLOSURE_GGX);
    assert_true(s.materials[2].normal.type == NORMAL_MAP && s.materials[2].normal.texture == 0);
    assert_true(s.materials[2].normal.strength == .7f);
    assert_true(s.materials[2].emission.value[0] == 0 && s.materials[2].emission_front && s.materials[2].emission_back);
    assert_true(s.materials[3].emission.value[0] == 15);
    assert_true(s.materials[3].emission_front && !s.materials[3].emission_back);
    assert_int_equal(s.materials[3].closure_count, 0);

    assert_int_equal(s.materials[4].closure_count, 2);
    const struct scene_closure *foil = s.materials[4].closures, *pane = s.materials[5].closures;
    assert_true(foil[0].type == CLOSURE_GLOSSY && foil[0].distribution == CLOSURE_ASHIKHMIN_SHIRLEY);
    assert_true(foil[0].weight.texture == 3 && foil[0].front && !foil[0].back && foil[0].roughness.value == .2f);
    assert_true(foil[0].anisotropy.value == .6f && foil[0].rotation.value == .1f && foil[0].colour.value[2] == .5f);
    assert_true(foil[1].type == CLOSURE_SHEEN && !foil[1].front && foil[1].back && foil[1].roughness.value == .5f);
    const struct scene_normal *bumps = &s.materials[4].normal;
    assert_true(bumps->type == NORMAL_HEIGHT && bumps->texture == 2 && bumps->strength == 1);
    assert_true(bumps->distance == .01f && bumps->filter == 1 && bumps->invert && s.materials[4].emission.texture == 0);
    assert_int_equal(s.materials[5].closure_count, 4);
    assert_true(pane[0].type == CLOSURE_GLASS && pane[0].distribution == CLOSURE_MULTI_GGX);
    assert_true(pane[0].ior.value == 1.45f && pane[0].weight.value[0] == .5f);
    assert_true(pane[1].type == CLOSURE_REFRACTION && pane[1].distribution == CLOSURE_BECKMANN);
    assert_true(pane[1].roughness.value == .1f && pane[2].type == CLOSURE_TRANSLUCENT);
    assert_true(pane[2].colour.value[1] == .8f && pane[3].type == CLOSURE_TRANSPARENT);

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
    assert_true(!s.objects[0].hidden && !s.objects[0].shadowless && s.objects[1].hidden && s.objects[1].shadowless);

    assert_int_equal(s.light_count, 4);
    const struct scene_light *l = s.lights;
    assert_true(l[0].type == LIGHT_AREA && l[0].shape == LIGHT_RECTANGLE && l[0].size[1] == .5f);
    assert_true(l[0].spread <= (float)M_PI && l[0].spread > 3.14f && l[0].power[2] == 10 && l[0].transform[11] == 4);
    assert_true(l[0].seen && l[0].shadowless && !l[1].seen && !l[1].shadowless);
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
    write_json(", \"back\": 15", "");
    if (!scene_read(folder, &s, error)) fail_msg("%s", error);
    assert_true(s.textures[3].back == s.textures[3].front);
    scene_free(&s);
    write_json(", \"distribution\": \"ggx\"}]", "}]");
    if (!scene_read(folder, &s, error)) fail_msg("%s", error);
    assert_int_equal(s.materials[2].closures->distribution, CLOSURE_MULTI_GGX);
    scene_free(&s);
}

/* The example with another camera. */
static void write_camera(const char *type, const char *window)
{
    char text[512], *start = strstr(json, "\"camera\": {"), *end = strstr(json, "\"world\"");
    assert_true(start && end);
    snprintf(text, sizeof text, "%.*s", (int)(end - start), start);
    char camera[512];
    snprintf(camera, sizeof camera,
             "\"camera\": {\"type\": \"%s\", \"transform\": [1,0,0,0, 0,1,0,0, 0,0,1,0], \"window\": %s, "
             "\"resolution\": [64, 32]},\n", type, window);
    write_json(text, camera);
}

static void reads_other_cameras(void **state)
{
    (void)state;
    struct scene s;
    char error[SCENE_ERROR];
    write_camera("orthographic", "[-2, 2, -1, 1]");
    if (!scene_read(folder, &s, error)) fail_msg("%s", error);
    assert_true(s.camera.type == CAMERA_ORTHOGRAPHIC && s.camera.window[1] == 2 && s.camera.lens.radius == 0);
    scene_free(&s);
    write_camera("panoramic", "[-3.1415928, 3.1415928, -1.5707964, 1.5707964]");
    if (!scene_read(folder, &s, error)) fail_msg("%s", error);
    assert_true(s.camera.type == CAMERA_PANORAMIC && s.camera.window[3] <= (float)M_PI_2);
    scene_free(&s);
    write_camera("panoramic", "[-4, 4, -1, 1]");
    expect_error("camera.window: found [-4, 4, -1, 1], expected at most once round");
    write_camera("panoramic", "[-1, 1, -1, 2]");
    expect_error("camera.window: found [-1, 1, -1, 2]");
    write_camera("panoramic", "[1, -1, -1, 1]");
    expect_error("expected left < right");
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
        {"\"colour\": [0.6", "\"ks\": 1, \"colour\": [0.6", "materials[0].closures[0].ks: unknown key"},
        {"{\"texture\": 1}", "{\"texture\": 1, \"scale\": 2}", "closures[0].base_colour.scale: unknown key"},
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
        {"\"perspective\"", "\"orthographic\"", "camera.lens: unknown key"},
        {"\"focus\": 4", "\"focus\": 0", "camera.lens.focus: found 0"},
        {"\"blades\": 6", "\"blades\": 2", "camera.lens.blades: found 2, expected 0 or at least 3"},
        {"\"radiance\": [1, 1, 1]", "\"radiance\": [1, -1, 1]", "world.radiance: number 1 is -1"},
        {"\"texture\": 0, \"transform\"", "\"texture\": 4, \"transform\"", "world.texture: found 4"},
        {"\"texture\": 0, \"transform\"", "\"texture\": 1, \"transform\"", "world.texture: texture 1 is no image"},
        {"textures/wood.png", "textures/oak.png", "images[0].file: "},
        {"textures/wood.png", "textures/oak.png", "textures/oak.png cannot be read: No such file"},
        {"textures/wood.png", "textures", "is not a file"},
        {"\"srgb\"", "\"aces\"", "images[0].colour_space: found \"aces\", expected \"srgb\", \"linear\" or \"data\""},
        {"\"image\": 0", "\"image\": 1", "textures[0].image: found 1, expected the index of one of 1 images"},
        {"\"image\": 0", "\"image\": -1", "textures[0].image: found -1"},
        {"\"image\": 0", "\"image\": 0.5", "textures[0].image: found 0.5"},
        {"\"repeat\"", "\"tile\"", "textures[0].extension: found \"tile\""},
        {"\"alpha\"", "\"red\"", "textures[2].channel: found \"red\", expected \"alpha\""},
        {"\"front\": 14", "\"front\": 4", "textures[3].front: view 4 holds float2, expected float3"},
        {"\"back\": 15", "\"back\": 0", "textures[3].back: found 5 elements, expected 3: as many as front"},
        {"\"offset\": 708, \"count\": 3", "\"offset\": 708, \"count\": 1", "textures[3].front: found 1 elements"},
        {"\"type\": \"angle\"", "\"type\": \"angle\", \"scale\": 1", "textures[3].scale: unknown key"},
        {"\"scale\": 16", "\"scale\": 0", "textures[1].scale: found 0"},
        {"\"phong\"", "\"ward\"", "materials[1].closures[0].type: found \"ward\""},
        {"\"exponent\": 100", "\"exponent\": -1", "materials[1].closures[0].exponent: found -1"},
        {"\"exponent\": 100", "\"exponent\": {}", "materials[1].closures[0].exponent.texture: found nothing"},
        {"\"metallic\": 0", "\"metallic\": 1.5", "closures[0].metallic: found 1.5, expected a number from 0 to 1"},
        {"{\"texture\": 0}", "1.5", "materials[2].closures[0].roughness: found 1.5"},
        {"\"ior\": 1.5", "\"ior\": 0.5", "materials[2].closures[0].ior: found 0.5"},
        {"\"ior\": 1.5", "\"ior\": 1e39", "materials[2].closures[0].ior: found 1e+39"},
        {"[15,15,15]", "[15,-1,15]", "materials[3].emission: number 1 is -1"},
        {"\"front\"},", "\"top\"},", "materials[3].emission_sides: found \"top\", expected \"both\", \"front\" or"},
        {"\"emission\": {\"texture\": 0}", "\"emission\": {\"texture\": 4}", "materials[4].emission.texture: found 4"},
        {"\"sides\": \"front\"", "\"sides\": \"left\"", "materials[4].closures[0].sides: found \"left\""},
        {"\"anisotropy\": 0.6", "\"anisotropy\": -1.5", "anisotropy: found -1.5, expected a number from -1"},
        {"\"weight\": 0.3", "\"weight\": 3", "materials[2].closures[0].coat.weight: found 3"},
        {"\"tint\": [1,1,0.9]", "\"tints\": [1,1,0.9]", "materials[2].closures[0].sheen.tint: found nothing"},
        {"\"distribution\": \"ggx\"", "\"distribution\": \"beckmann\"", "closures[0].distribution: found \"beckmann\""},
        {"\"distribution\": \"beckmann\"", "\"distribution\": \"multi-ggx\"", "materials[5].closures[1].distribution"},
        {"\"ior\": 1.45", "\"ior\": 0", "materials[5].closures[0].ior: found 0, expected a number of at least 0.1"},
        {"\"translucent\"", "\"translucent\", \"ior\": 1", "materials[5].closures[2].ior: unknown key"},
        {"\"map\": 0", "\"map\": 3", "materials[2].normal.map: texture 3 goes by angle"},
        {"\"map\": 0", "\"mop\": 0", "materials[2].normal.map: found nothing"},
        {"\"height\": 2", "\"height\": 2, \"map\": 0", "materials[4].normal.map: unknown key"},
        {"\"distance\": 0.01", "\"distance\": -1", "materials[4].normal.distance: found -1"},
        {"\"camera\": false", "\"camera\": 0", "objects[1].camera: found 0, expected true or false"},
        {"\"shadow\": false}", "\"shadow\": null}", "shadow: found null, expected true or false"},
        {"\"name\": \"House\", \"pos", "\"name\": 5, \"pos", "meshes[0].name: found 5, expected a text"},
        {"\"uvs\": 4", "\"uvs\": 16", "meshes[0].uvs: found 16, expected the index of one of 16 views"},
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
        {"[0, 3]", "[0, 9]", "objects[0].materials[1]: found 9, expected the index of one of 6 materials"},
        {"[0, 3]", "[0]", "objects[0].materials: found 1, expected 2: a face of mesh \"House\" uses slot 1"},
        {"\"power\": [10,10,10]", "\"power\": [10,-10,10]", "lights[0].power: number 1 is -10"},
        {"\"size\": [0.5, 0.5]", "\"size\": [0.5, 0]", "lights[0].size: found [0.5, 0]"},
        {"\"rectangle\"", "\"sphere\"", "lights[0].shape: found \"sphere\", expected \"rectangle\" or \"ellipse\""},
        {"\"radius\": 0.1", "\"radius\": -1", "lights[1].radius: found -1"},
        {"\"blend\": 0.15", "\"blend\": 2", "lights[2].blend: found 2"},
        {"\"angle\": 0.8", "\"angle\": 4", "lights[2].angle: found 4"},
        {"\"irradiance\"", "\"power\"", "lights[3].irradiance: found nothing"},
        {"\"text\":", "\"txt\":", "notes[0].text: found nothing"},
        {"\"bytes\": 780", "\"bytes\": 784", "scene.bin has 780 bytes, expected 784"},
        {"\"bytes\": 780", "\"bytes\": -1", "buffer.bytes: found -1"},
        {"\"bytes\": 780", "\"bytes\": 1e300", "buffer.bytes: found 1e+300"},
        {"\"file\": \"scene.bin\"", "\"file\": \"mesh.bin\"", "mesh.bin cannot be opened: No such file"},
        {"\"file\": \"scene.bin\"", "\"file\": \"textures\"", "is not a file"},
        {"\"offset\": 60", "\"offset\": 62", "views[1].offset: found 62, expected a multiple of 4"},
        {"\"offset\": 744, \"count\": 3", "\"offset\": 744, \"count\": 4",
         "views[15]: ends at byte 792, but the buffer has 780"},
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
        {708, nan_bits, "textures[3].front: element 0 of view 14 holds nan, expected finite numbers"},
        {744 + 12, minus_one_bits, "textures[3].back: element 1 holds -1, expected at least 0"},
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
    expect_error("scene.bin has 500 bytes, expected 780");
    write_whole("scene.bin", buffer, buffer_bytes + 4);
    expect_error("scene.bin has 784 bytes, expected 780");
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
    struct scene_closure *phong = scene.materials[1].closures, *foil = scene.materials[4].closures;
    free(scene.materials[1].name);
    scene.materials[1].name = strdup("a/b=c");
    assert_true(scene_set(&scene, "materials/a/b=c/exponent=12.5", error));
    assert_true(phong->exponent.value == 12.5f && phong->exponent.texture == SCENE_NONE);
    assert_true(scene_set(&scene, "materials/Ball/roughness=.25", error));
    const struct scene_closure *ball = scene.materials[2].closures;
    assert_true(ball->roughness.value == .25f && ball->roughness.texture == SCENE_NONE);
    assert_true(ball->coat_roughness.value == .1f);
    assert_true(scene_set(&scene, "materials/Foil/roughness=.75", error));
    assert_true(foil[0].roughness.value == .75f && foil[1].roughness.value == .75f); /* all that have one */
    assert_true(scene_set(&scene, "materials/Pane/roughness=1", error));
    const struct scene_closure *pane = scene.materials[5].closures;
    assert_true(pane[0].roughness.value == 1 && pane[1].roughness.value == 1 && pane[2].roughness.value == 0);
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
                              {"materials/Foil/roughness=1.5", "expected a number from 0 to 1"},
                              {"materials/Wall/roughness=1", "no material 'Wall' with"},
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
        cmocka_unit_test(reads_other_cameras),
        cmocka_unit_test(names_faults_of_the_document),
        cmocka_unit_test(names_faults_of_the_buffer),
        cmocka_unit_test(names_a_folder_that_is_no_scene),
        cmocka_unit_test(sets_a_property),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
