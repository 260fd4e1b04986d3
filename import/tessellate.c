/* SPDX-License-Identifier: Apache-2.0 */
#include "import/tessellate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "import/subdivide.h"
#include "import/triangulate.h"

#define NONE UINT32_MAX

struct polygons {
    uint32_t face_count, corner_count;
    uint32_t size_max;          /* corners of the largest face */
    const uint32_t *face_sizes; /* NULL: all 4 */
    const uint32_t *corners;
    const float *positions; /* 3 a vertex */
    const float *normals;   /* 3 a corner; NULL: flat */
    const float *uvs;       /* 2 a corner, 2 a vertex where uv_by_vertex, or NULL */
    bool uv_by_vertex;
    const uint32_t *face_slots; /* NULL: all 0 */
};

/* Vertices and triangles as they are made; `next` chains those of one position. */
struct builder {
    struct triangles *out;
    uint32_t *first; /* the newest vertex made at each position */
    uint32_t *next;
};

/* Scales to length 1; false where there is no direction. */
static bool normalize(const double v[static 3], float unit[static 3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0) || !isfinite(length)) return false;
    for (int i = 0; i < 3; i++) unit[i] = (float)(v[i] / length);
    return true;
}

static bool triangle_normal(const float *a, const float *b, const float *c, float unit[static 3])
{
    double u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (double)b[i] - a[i];
        v[i] = (double)c[i] - a[i];
    }
    return normalize((double[3]){u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]},
                     unit);
}

static const float *corner_position(const struct polygons *p, uint32_t corner)
{
    return p->positions + 3 * (size_t)p->corners[corner];
}

/* The normal of a face's vector area; up where the face has none. */
static void face_normal(const struct polygons *p, uint32_t corner, uint32_t size, float unit[static 3])
{
    double sum[3] = {0, 0, 0};
    const float *a = corner_position(p, corner);
    for (uint32_t i = 1; i + 1 < size; i++) {
        const float *b = corner_position(p, corner + i), *c = corner_position(p, corner + i + 1);
        for (int axis = 0; axis < 3; axis++) {
            int u = (axis + 1) % 3, v = (axis + 2) % 3;
            sum[axis] += ((double)b[u] - a[u]) * ((double)c[v] - a[v]) - ((double)b[v] - a[v]) * ((double)c[u] - a[u]);
        }
    }
    if (!normalize(sum, unit)) memcpy(unit, (float[3]){0, 0, 1}, 3 * sizeof(float));
}

static uint32_t add_vertex(struct triangles *out, const struct polygons *p, uint32_t corner, const float *normal)
{
    uint32_t vertex = out->vertex_count++;
    memcpy(out->positions + 3 * (size_t)vertex, corner_position(p, corner), 3 * sizeof(float));
    memcpy(out->normals + 3 * (size_t)vertex, normal, 3 * sizeof(float));
    if (p->uvs)
        memcpy(out->uvs + 2 * (size_t)vertex, p->uvs + 2 * (size_t)(p->uv_by_vertex ? p->corners[corner] : corner),
               2 * sizeof(float));
    return vertex;
}

/* The vertex of a smooth corner: one that was made at its position with the same normal and uv, or a new one. */
static uint32_t shared_vertex(struct builder *b, const struct polygons *p, uint32_t corner, const float *facet)
{
    const float *given = p->normals + 3 * (size_t)corner;
    float normal[3];
    if (!normalize((double[3]){given[0], given[1], given[2]}, normal)) memcpy(normal, facet, sizeof normal);
    uint32_t *first = &b->first[p->corners[corner]];
    for (uint32_t i = *first; i != NONE; i = b->next[i])
        if (!memcmp(b->out->normals + 3 * (size_t)i, normal, sizeof normal) &&
            (!p->uvs || !memcmp(b->out->uvs + 2 * (size_t)i, p->uvs + 2 * (size_t)corner, 2 * sizeof(float))))
            return i;
    uint32_t vertex = add_vertex(b->out, p, corner, normal);
    b->next[vertex] = *first;
    return *first = vertex;
}

/* A flat face has its own vertices: one a corner where it is plane, else three a triangle, as the renderers that shade
 * triangles one by one see it. */
static void add_flat_face(struct triangles *out, const struct polygons *p, uint32_t corner, uint32_t size,
                          const float *facet, const uint32_t *cut, uint32_t *indices)
{
    uint32_t count = 3 * (size - 2);
    bool plane = true;
    float normal[3];
    for (uint32_t i = 0; i < count && plane && size > 3; i += 3)
        if (triangle_normal(corner_position(p, corner + cut[i]), corner_position(p, corner + cut[i + 1]),
                            corner_position(p, corner + cut[i + 2]), normal))
            plane = normal[0] * facet[0] + normal[1] * facet[1] + normal[2] * facet[2] > 1 - 1e-6f;
    if (plane) {
        for (uint32_t i = 0; i < count; i++) indices[i] = out->vertex_count + cut[i];
        for (uint32_t i = 0; i < size; i++) add_vertex(out, p, corner + i, facet);
        return;
    }
    for (uint32_t i = 0; i < count; i += 3) {
        if (!triangle_normal(corner_position(p, corner + cut[i]), corner_position(p, corner + cut[i + 1]),
                             corner_position(p, corner + cut[i + 2]), normal))
            memcpy(normal, facet, sizeof normal);
        for (int k = 0; k < 3; k++) indices[i + k] = add_vertex(out, p, corner + cut[i + k], normal);
    }
}

/* Gives back what the estimate of the vertex count was too high by. */
static void shrink(float **numbers, size_t count)
{
    float *smaller = realloc(*numbers, (count + 1) * sizeof **numbers);
    if (smaller) *numbers = smaller;
}

/* False where memory runs out; *out then holds what was allocated. */
static bool add_polygons(const struct polygons *p, uint32_t vertex_count, struct triangles *out)
{
    size_t triangles = p->corner_count - 2 * (size_t)p->face_count,
           vertices = p->normals ? p->corner_count : 3 * triangles;
    out->positions = malloc((vertices + 1) * 3 * sizeof(float));
    out->normals = malloc((vertices + 1) * 3 * sizeof(float));
    out->uvs = p->uvs ? malloc((vertices + 1) * 2 * sizeof(float)) : NULL;
    out->indices = malloc((triangles + 1) * 3 * sizeof(uint32_t));
    out->slots = malloc((triangles + 1) * sizeof(uint32_t));
    uint32_t *cut = malloc(3 * (size_t)p->size_max * sizeof *cut);
    struct builder b = {out, NULL, NULL};
    bool ok = out->positions && out->normals && (out->uvs || !p->uvs) && out->indices && out->slots && cut;
    if (p->normals) {
        b.first = malloc((vertex_count + (size_t)1) * sizeof *b.first);
        b.next = malloc((vertices + 1) * sizeof *b.next);
        ok = ok && b.first && b.next;
        if (b.first) memset(b.first, 0xff, vertex_count * sizeof *b.first); /* NONE */
    }
    for (uint32_t f = 0, corner = 0; ok && f < p->face_count; f++) {
        uint32_t size = p->face_sizes ? p->face_sizes[f] : 4;
        ok = triangulate_polygon(p->positions, p->corners + corner, size, cut);
        if (!ok) break;
        float facet[3];
        face_normal(p, corner, size, facet);
        uint32_t *indices = out->indices + 3 * (size_t)out->triangle_count;
        if (!p->normals) add_flat_face(out, p, corner, size, facet, cut, indices);
        for (uint32_t i = 0; p->normals && i < 3 * (size - 2); i++)
            indices[i] = shared_vertex(&b, p, corner + cut[i], facet);
        for (uint32_t i = 0; i < size - 2; i++)
            out->slots[out->triangle_count++] = p->face_slots ? p->face_slots[f] : 0;
        corner += size;
    }
    free(cut);
    free(b.first);
    free(b.next);
    if (ok) {
        shrink(&out->positions, 3 * (size_t)out->vertex_count);
        shrink(&out->normals, 3 * (size_t)out->vertex_count);
        if (out->uvs) shrink(&out->uvs, 2 * (size_t)out->vertex_count);
    }
    return ok;
}

/* The limit surface's own vertices; only the quads are cut. */
static bool add_smooth_quads(struct subdivided *s, struct triangles *out)
{
    size_t triangles = 2 * (size_t)s->quad_count;
    out->indices = malloc((triangles + 1) * 3 * sizeof(uint32_t));
    out->slots = malloc((triangles + 1) * sizeof(uint32_t));
    if (!out->indices || !out->slots) return false;
    for (size_t q = 0; q < s->quad_count; q++) {
        const uint32_t *quad = s->quads + 4 * q;
        uint32_t cut[6];
        triangulate_polygon(s->positions, quad, 4, cut);
        for (int i = 0; i < 6; i++) out->indices[6 * q + i] = quad[cut[i]];
        out->slots[2 * q] = out->slots[2 * q + 1] = s->slots[q];
    }
    out->vertex_count = s->vertex_count;
    out->triangle_count = (uint32_t)triangles;
    out->positions = s->positions;
    out->normals = s->normals;
    out->uvs = s->uvs;
    s->positions = s->normals = s->uvs = NULL;
    return true;
}

static bool tessellate_cage(const struct scene_mesh *mesh, int level, struct triangles *out, char *error)
{
    struct subdivided s;
    if (!subdivide(mesh, level, &s, error)) return false;
    bool ok;
    if (s.normals) {
        ok = add_smooth_quads(&s, out);
    } else {
        struct polygons polygons = {.face_count = s.quad_count,
                                    .corner_count = 4 * s.quad_count,
                                    .size_max = 4,
                                    .corners = s.quads,
                                    .positions = s.positions,
                                    .uvs = s.uvs,
                                    .uv_by_vertex = true,
                                    .face_slots = s.slots};
        ok = add_polygons(&polygons, s.vertex_count, out);
    }
    subdivide_free(&s);
    if (!ok) snprintf(error, SCENE_ERROR, "mesh \"%s\": out of memory at subdivision level %d", mesh->name, level);
    return ok;
}

bool tessellate(const struct scene_mesh *mesh, int level, struct triangles *out, char error[static SCENE_ERROR])
{
    memset(out, 0, sizeof *out);
    bool ok;
    if (mesh->subdivided && mesh->face_count) {
        ok = tessellate_cage(mesh, level, out, error);
    } else {
        struct polygons polygons = {.face_count = mesh->face_count,
                                    .corner_count = mesh->corner_count,
                                    .size_max = 3,
                                    .face_sizes = mesh->face_sizes,
                                    .corners = mesh->corners,
                                    .positions = mesh->positions,
                                    .normals = mesh->normals,
                                    .uvs = mesh->uvs,
                                    .face_slots = mesh->face_materials};
        for (uint32_t f = 0; f < mesh->face_count; f++)
            polygons.size_max = mesh->face_sizes[f] > polygons.size_max ? mesh->face_sizes[f] : polygons.size_max;
        ok = add_polygons(&polygons, mesh->vertex_count, out);
        if (!ok)
            snprintf(error, SCENE_ERROR, "mesh \"%s\": out of memory for %u triangles", mesh->name,
                     mesh->corner_count - 2 * mesh->face_count);
    }
    if (!ok) triangles_free(out);
    return ok;
}

void triangles_free(struct triangles *triangles)
{
    free(triangles->positions);
    free(triangles->normals);
    free(triangles->uvs);
    free(triangles->indices);
    free(triangles->slots);
    memset(triangles, 0, sizeof *triangles);
}
