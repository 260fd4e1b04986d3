/* SPDX-License-Identifier: Apache-2.0 */
#include "import/meshes.h"

#include <stdlib.h>

static void check_count(const struct json_node *at, const char *key, uint32_t found, uint32_t expected,
                        const char *what)
{
    if (!at->file->failed && found != expected)
        json_fail(at, key, "found %u elements, expected %u: one a %s", found, expected, what);
}

static void check_faces(const struct json_node *at, const struct scene_mesh *mesh)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < mesh->face_count; i++) {
        sum += mesh->face_sizes[i];
        if (mesh->face_sizes[i] < 3) {
            json_fail(at, "face_sizes", "face %u has %u corners, expected 3 or more", i, mesh->face_sizes[i]);
            return;
        }
    }
    if (sum != mesh->corner_count)
        json_fail(at, "corners", "found %u corners, expected %llu: the sum of face_sizes", mesh->corner_count,
                  (unsigned long long)sum);
}

/* Each element names a vertex. */
static void check_vertices(const struct json_node *at, const char *key, const uint32_t *indices, size_t count,
                           uint32_t vertex_count)
{
    for (size_t i = 0; i < count; i++)
        if (indices[i] >= vertex_count) {
            json_fail(at, key, "element %zu names vertex %u, expected one of %u", i, indices[i], vertex_count);
            return;
        }
}

static void check_sharpness(const struct json_node *at, const char *key, const float *sharpness, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (sharpness[i] < 0) {
            json_fail(at, key, "element %u is %g, expected a sharpness of at least 0", i, sharpness[i]);
            return;
        }
}

struct edge {
    uint32_t low, high, index;
};

static int compare_edges(const void *left, const void *right)
{
    const struct edge *a = left, *b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    return (a->high > b->high) - (a->high < b->high);
}

static struct edge edge_of(uint32_t a, uint32_t b, uint32_t index)
{
    return a < b ? (struct edge){a, b, index} : (struct edge){b, a, index};
}

/* Each crease lies on an edge of some face. */
static void check_creases(const struct json_node *at, const struct scene_mesh *mesh)
{
    uint32_t count = mesh->crease_count;
    struct edge *creases = malloc((count + 1) * sizeof *creases);
    bool *found = calloc(count + 1, sizeof *found); /* of the sorted creases */
    if (!creases || !found) {
        json_fail(at, NULL, "out of memory");
        goto done;
    }
    for (uint32_t i = 0; i < count; i++)
        creases[i] = edge_of(mesh->crease_edges[2 * i], mesh->crease_edges[2 * i + 1], i);
    qsort(creases, count, sizeof *creases, compare_edges);
    const uint32_t *corners = mesh->corners;
    for (uint32_t f = 0; f < mesh->face_count; corners += mesh->face_sizes[f++])
        for (uint32_t i = 0, size = mesh->face_sizes[f]; i < size; i++) {
            struct edge key = edge_of(corners[i], corners[i + 1 < size ? i + 1 : 0], 0);
            struct edge *hit = bsearch(&key, creases, count, sizeof *creases, compare_edges);
            if (hit) found[hit - creases] = true;
        }
    for (uint32_t i = 0; i < count; i++) {
        bool twin = i && !compare_edges(&creases[i], &creases[i - 1]); /* named twice: bsearch found either */
        bool next_twin = i + 1 < count && !compare_edges(&creases[i], &creases[i + 1]);
        if (twin || next_twin)
            json_fail(at, "crease_edges", "the edge of vertices %u and %u is named twice", creases[i].low,
                      creases[i].high);
        else if (!found[i])
            json_fail(at, "crease_edges", "element %u joins vertices %u and %u, expected an edge of a face",
                      creases[i].index, creases[i].low, creases[i].high);
    }
done:
    free(creases);
    free(found);
}

static void read_subdivision(struct json_node *parent, const struct buffer *buffer, struct scene_mesh *mesh)
{
    static const char *const schemes[] = {"catmull-clark", "bilinear", NULL};
    static const char *const boundaries[] = {"edge-only", "edge-and-corner", NULL};
    static const char *const uv_boundaries[] = {
        "none", "corners-only", "corners-plus1", "corners-plus2", "boundaries", "all", NULL};
    struct json_node at = json_get_object(parent, "subdivision");
    mesh->subdivided = true;
    mesh->scheme = json_get_word(&at, "scheme", schemes);
    mesh->boundary = json_get_word(&at, "boundary", boundaries);
    mesh->uv_boundary = json_get_word(&at, "uv_boundary", uv_boundaries);
    mesh->smooth = json_get_bool(&at, "smooth");
    uint32_t count;
    if (json_has(&at, "crease_edges") || json_has(&at, "crease_sharpness")) {
        mesh->crease_edges = buffer_span(buffer, &at, "crease_edges", BUFFER_UINT2, mesh->name, &mesh->crease_count);
        mesh->crease_sharpness = buffer_span(buffer, &at, "crease_sharpness", BUFFER_FLOAT, mesh->name, &count);
        check_count(&at, "crease_sharpness", count, mesh->crease_count, "crease");
        if (!at.file->failed) {
            check_vertices(&at, "crease_edges", mesh->crease_edges, 2 * (size_t)mesh->crease_count, mesh->vertex_count);
            check_sharpness(&at, "crease_sharpness", mesh->crease_sharpness, mesh->crease_count);
            check_creases(&at, mesh);
        }
    }
    if (json_has(&at, "corner_vertices") || json_has(&at, "corner_sharpness")) {
        mesh->corner_vertices =
            buffer_span(buffer, &at, "corner_vertices", BUFFER_UINT, mesh->name, &mesh->sharp_corner_count);
        mesh->corner_sharpness = buffer_span(buffer, &at, "corner_sharpness", BUFFER_FLOAT, mesh->name, &count);
        check_count(&at, "corner_sharpness", count, mesh->sharp_corner_count, "corner vertex");
        if (!at.file->failed) {
            check_vertices(&at, "corner_vertices", mesh->corner_vertices, mesh->sharp_corner_count, mesh->vertex_count);
            check_sharpness(&at, "corner_sharpness", mesh->corner_sharpness, mesh->sharp_corner_count);
        }
    }
    json_end(&at);
}

static void read_mesh(struct json_node *at, const struct buffer *buffer, struct scene_mesh *mesh)
{
    uint32_t count;
    mesh->name = json_get_text(at, "name");
    const char *name = mesh->name ? mesh->name : "";
    mesh->positions = buffer_span(buffer, at, "positions", BUFFER_FLOAT3, name, &mesh->vertex_count);
    mesh->face_sizes = buffer_span(buffer, at, "face_sizes", BUFFER_UINT, name, &mesh->face_count);
    mesh->corners = buffer_span(buffer, at, "corners", BUFFER_UINT, name, &mesh->corner_count);
    if (at->file->failed) return;
    check_faces(at, mesh);
    check_vertices(at, "corners", mesh->corners, mesh->corner_count, mesh->vertex_count);
    if (json_has(at, "normals")) {
        mesh->normals = buffer_span(buffer, at, "normals", BUFFER_FLOAT3, name, &count);
        check_count(at, "normals", count, mesh->corner_count, "corner");
    }
    if (json_has(at, "uvs")) {
        mesh->uvs = buffer_span(buffer, at, "uvs", BUFFER_FLOAT2, name, &count);
        check_count(at, "uvs", count, mesh->corner_count, "corner");
    }
    if (json_has(at, "face_materials")) {
        mesh->face_materials = buffer_span(buffer, at, "face_materials", BUFFER_UINT, name, &count);
        check_count(at, "face_materials", count, mesh->face_count, "face");
    }
    if (json_has(at, "subdivision") && !at->file->failed) {
        read_subdivision(at, buffer, mesh);
        if (mesh->normals) json_fail(at, "normals", "found normals, expected none: the mesh is a cage");
    }
    json_end(at);
}

void meshes_read(struct json_node *root, const struct buffer *buffer, struct scene *scene)
{
    struct json_node list = json_get_list(root, "meshes");
    scene->meshes = json_new_array(&list, sizeof *scene->meshes, &scene->mesh_count);
    for (int i = 0; i < scene->mesh_count; i++) {
        struct json_node item = json_get_item(&list, i);
        read_mesh(&item, buffer, &scene->meshes[i]);
    }
}

uint32_t meshes_top_slot(const struct scene_mesh *mesh)
{
    uint32_t top = 0;
    for (uint32_t i = 0; mesh->face_materials && i < mesh->face_count; i++)
        top = mesh->face_materials[i] > top ? mesh->face_materials[i] : top;
    return top;
}
