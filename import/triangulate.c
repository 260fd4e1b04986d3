/* SPDX-License-Identifier: Apache-2.0 */
#include "import/triangulate.h"

#include <math.h>
#include <stdlib.h>

/* True where the diagonal 0-2 leaves both other corners on one side, so that the halves would overlap (Blender's
 * is_quad_flip_v3_first_third_fast). */
static bool quad_folds(const float *a, const float *b, const float *c, const float *d)
{
    float ab[3], ac[3], ad[3];
    for (int i = 0; i < 3; i++) {
        ab[i] = b[i] - a[i];
        ac[i] = c[i] - a[i];
        ad[i] = d[i] - a[i];
    }
    float left[3] = {ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]};
    float right[3] = {ad[1] * ac[2] - ad[2] * ac[1], ad[2] * ac[0] - ad[0] * ac[2], ad[0] * ac[1] - ad[1] * ac[0]};
    return left[0] * right[0] + left[1] * right[1] + left[2] * right[2] > 0;
}

/* A corner of the polygon that is left, projected; a ring. */
struct ring_corner {
    double x, y;
    uint32_t previous, next;
};

/* Twice the signed area of a triangle; positive where it turns left. */
static double turn(const struct ring_corner *a, const struct ring_corner *b, const struct ring_corner *c)
{
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

/* True where no other corner of the ring lies in the triangle at corner b. Only a reflex corner can. */
static bool is_empty(const struct ring_corner *ring, uint32_t b)
{
    const struct ring_corner *pa = &ring[ring[b].previous], *pb = &ring[b], *pc = &ring[ring[b].next];
    for (uint32_t i = pc->next; i != pb->previous; i = ring[i].next) {
        const struct ring_corner *p = &ring[i];
        if (turn(&ring[p->previous], p, &ring[p->next]) <= 0 && turn(pa, pb, p) >= 0 && turn(pb, pc, p) >= 0 &&
            turn(pc, pa, p) >= 0)
            return false;
    }
    return true;
}

/* The corner to clip: the next ear from `start` on; failing that (crossing or flat polygons) the next corner that
 * doesn't turn right; failing that `start`. */
static uint32_t find_ear(const struct ring_corner *ring, uint32_t start)
{
    uint32_t straight = start;
    bool found = false;
    uint32_t i = start;
    do {
        double area = turn(&ring[ring[i].previous], &ring[i], &ring[ring[i].next]);
        if (area > 0 && is_empty(ring, i)) return i;
        if (area >= 0 && !found) {
            straight = i;
            found = true;
        }
        i = ring[i].next;
    } while (i != start);
    return straight;
}

/* Drops the axis along which the polygon's normal (Newell) is longest; keeps the sense of rotation positive. */
static void project(const float *positions, const uint32_t *corners, uint32_t size, struct ring_corner *ring)
{
    double normal[3] = {0, 0, 0};
    const float *a = positions + 3 * (size_t)corners[size - 1];
    for (uint32_t i = 0; i < size; i++) {
        const float *b = positions + 3 * (size_t)corners[i];
        for (int axis = 0; axis < 3; axis++) {
            int u = (axis + 1) % 3, v = (axis + 2) % 3;
            normal[axis] += ((double)a[u] - b[u]) * ((double)a[v] + b[v]);
        }
        a = b;
    }
    int axis = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
    axis = fabs(normal[axis]) > fabs(normal[2]) ? axis : 2;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    double sign = normal[axis] < 0 ? -1 : 1;
    for (uint32_t i = 0; i < size; i++) {
        const float *p = positions + 3 * (size_t)corners[i];
        ring[i] = (struct ring_corner){p[u], sign * p[v], i ? i - 1 : size - 1, i + 1 < size ? i + 1 : 0};
    }
}

bool triangulate_polygon(const float *positions, const uint32_t *corners, uint32_t size, uint32_t *triangles)
{
    uint32_t *out = triangles;
    if (size == 3) {
        *out++ = 0, *out++ = 1, *out++ = 2;
        return true;
    }
    if (size == 4) {
        const float *p[4];
        for (int i = 0; i < 4; i++) p[i] = positions + 3 * (size_t)corners[i];
        bool folds = quad_folds(p[0], p[1], p[2], p[3]);
        *out++ = 0, *out++ = 1, *out++ = folds ? 3 : 2;
        *out++ = folds ? 1 : 0, *out++ = 2, *out++ = 3;
        return true;
    }
    struct ring_corner *ring = malloc(size * sizeof *ring);
    if (!ring) return false;
    project(positions, corners, size, ring);
    uint32_t start = 1;
    for (uint32_t left = size; left > 3; left--) {
        uint32_t ear = find_ear(ring, start), before = ring[ear].previous, after = ring[ear].next;
        *out++ = before, *out++ = ear, *out++ = after;
        ring[before].next = after;
        ring[after].previous = before;
        start = ring[after].next; /* every other corner: fewer slivers than a fan */
    }
    *out++ = ring[start].previous, *out++ = start, *out++ = ring[start].next;
    free(ring);
    return true;
}
