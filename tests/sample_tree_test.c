/* SPDX-License-Identifier: Apache-2.0 */
/* The tree over gather samples: its shape, and what groups keep of their samples. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>

#include "eas/irradiance.h"
#include "eas/sample_tree.h"
#include "render/rng.h"

enum { COUNT = 24 * 96 };
static const float3 ORIGIN = {1, 2, 3};

struct gather_case {
    struct gather_sample samples[COUNT];
    struct frame frame;
    struct sample_tree tree;
};

/* Stratified samples about a tilted normal, each of its own radiance; those of x < 0 (local) are black where asked. */
static struct gather_case *new_case(bool infinite, bool half_black)
{
    struct gather_case *c = calloc(1, sizeof *c);
    assert_non_null(c);
    struct rng rng = rng_seed(1, 2, 3);
    struct gather_grid grid = {24, 96};
    c->frame = frame_about(normalize(vec3(.3f, -.5f, .8f)));
    for (int i = 0; i < COUNT; i++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        float3 local = gather_direction(grid, i / grid.columns, i % grid.columns, u, v),
               dir = to_world(c->frame, local);
        float bright = half_black && local.x < 0 ? 0 : (float)(i + 1);
        c->samples[i] = (struct gather_sample){dir,
                                               infinite ? INFINITY : 1 + rng_float(&rng),
                                               scale(dir, -1),
                                               vec3(bright, .5f * bright, 1 - u),
                                               2 * PI / COUNT,
                                               vec3(0, 0, 0)};
        if (bright == 0) c->samples[i].radiance = vec3(0, 0, 0);
    }
    assert_true(sample_tree_build(&c->tree, c->samples, COUNT, ORIGIN, c->frame));
    return c;
}

static void free_case(struct gather_case *c)
{
    sample_tree_free(&c->tree);
    free(c);
}

static float node_omega(const struct tree_node *node) { return eas_translate(&node->eas, ORIGIN).omega; }

/* The root holds all samples; a node's samples, solid angle and power are the sums of its children's. */
static void sums(void **state)
{
    (void)state;
    for (int infinite = 0; infinite < 2; infinite++) {
        struct gather_case *c = new_case(infinite, true);
        const struct tree_node *nodes = c->tree.nodes;
        rgb power = {0};
        for (int i = 0; i < COUNT; i++) power = mad(power, c->samples[i].radiance, c->samples[i].omega);
        assert_int_equal(nodes[0].sample_count, COUNT);
        assert_float_equal(nodes[0].eas.radiance.x * 2 * PI / power.x, 1, 1e-4f);
        if (infinite) assert_float_equal(node_omega(&nodes[0]), 2 * PI, 1e-3f);
        for (uint32_t i = 0; i < c->tree.node_count; i++) {
            if (!nodes[i].child_count) continue;
            uint32_t count = 0;
            float omega = 0, red = 0, green = 0, whole = node_omega(&nodes[i]);
            for (uint32_t k = 0; k < nodes[i].child_count; k++) {
                const struct tree_node *child = &nodes[nodes[i].first_child + k];
                count += child->sample_count;
                omega += node_omega(child);
                red += node_omega(child) * child->eas.radiance.x;
                green += node_omega(child) * child->eas.radiance.y;
            }
            assert_int_equal(count, nodes[i].sample_count);
            if (i == 0 && !infinite) continue; /* no disc fills a hemisphere */
            assert_float_equal(omega / whole, 1, 1e-3f);
            assert_float_equal(red, whole * nodes[i].eas.radiance.x, 1e-3f * power.x);
            assert_float_equal(green, whole * nodes[i].eas.radiance.y, 1e-3f * power.y);
        }
        free_case(c);
    }
}

/* Leaves are single samples, each one once, at its own place. */
static void leaves(void **state)
{
    (void)state;
    struct gather_case *c = new_case(false, false);
    bool *seen = calloc(COUNT, sizeof *seen);
    int count = 0;
    for (uint32_t i = 0; i < c->tree.node_count; i++) {
        const struct tree_node *node = &c->tree.nodes[i];
        if (node->child_count) continue;
        assert_int_equal(node->sample_count, 1);
        int sample = (int)lrintf(node->eas.radiance.x) - 1;
        assert_in_range(sample, 0, COUNT - 1);
        assert_false(seen[sample]);
        seen[sample] = true;
        count++;
        const struct gather_sample *s = &c->samples[sample];
        assert_float_equal(length(sub(node->eas.position, mad(ORIGIN, s->dir, s->distance))), 0, 1e-5f);
        assert_float_equal(length(sub(node->eas.normal, s->normal)), 0, 1e-5f);
    }
    assert_int_equal(count, COUNT);
    free(seen);
    free_case(c);
}

/* Positions are means weighed by luminance x solid angle: the nodes', by those of their children. */
static void positions(void **state)
{
    (void)state;
    struct gather_case *c = new_case(false, false);
    for (uint32_t i = 0; i < c->tree.node_count; i++) {
        const struct tree_node *node = &c->tree.nodes[i];
        float3 sum = {0};
        float weight = 0;
        for (uint32_t k = 0; k < node->child_count; k++) {
            const struct tree_node *child = &c->tree.nodes[node->first_child + k];
            float w = luminance(child->eas.radiance) * (float)child->sample_count;
            sum = mad(sum, child->eas.position, w);
            weight += w;
        }
        if (weight > 0) assert_float_equal(length(sub(scale(sum, 1 / weight), node->eas.position)), 0, 1e-4f);
    }
    free_case(c);
}

/* A black group lies at the mean of its samples, and so does a tree that is all black. */
static void black_groups(void **state)
{
    (void)state;
    struct gather_case *c = new_case(false, true);
    int black = 0;
    for (uint32_t i = 0; i < c->tree.node_count; i++) {
        const struct eas *eas = &c->tree.nodes[i].eas;
        assert_true(isfinite(eas->position.x + eas->position.y + eas->position.z + eas->area));
        assert_float_equal(length(eas->normal), 1, 1e-5f);
        black += is_black(eas->radiance) && c->tree.nodes[i].child_count > 1;
        if (is_black(eas->radiance)) assert_true(to_local(c->frame, sub(eas->position, ORIGIN)).x < 0);
    }
    assert_true(black > 10);
    for (int i = 0; i < COUNT; i++) c->samples[i].radiance = vec3(0, 0, 0);
    assert_true(sample_tree_build(&c->tree, c->samples, COUNT, ORIGIN, c->frame));
    float3 mean = {0};
    for (int i = 0; i < COUNT; i++)
        mean = mad(mean, mad(ORIGIN, c->samples[i].dir, c->samples[i].distance), 1.0f / COUNT);
    assert_float_equal(length(sub(c->tree.nodes[0].eas.position, mean)), 0, 1e-4f);
    /* Far out in a lobe light is so faint that its share of the solid angle has no reciprocal: as good as black. */
    for (int i = 0; i < COUNT; i++) c->samples[i].radiance = vec3(1e-40f, 1e-40f, 1e-40f);
    assert_true(sample_tree_build(&c->tree, c->samples, COUNT, ORIGIN, c->frame));
    assert_true(length(sub(c->tree.nodes[0].eas.position, mean)) < 1e-4f); /* and is a number */
    free_case(c);
}

/* Bounds of the samples below a node, in the record's frame. */
struct bounds {
    float z0, z1, phi0, phi1;
};

static void bound(const struct gather_case *c, uint32_t node, struct bounds *b)
{
    const struct tree_node *n = &c->tree.nodes[node];
    for (uint32_t k = 0; k < n->child_count; k++) bound(c, n->first_child + k, b);
    if (n->child_count) return;
    float3 dir = to_local(c->frame, n->eas.position);
    float phi = atan2f(dir.y, dir.x);
    if (phi < 0) phi += 2 * PI;
    b->z0 = minf(b->z0, dir.z);
    b->z1 = maxf(b->z1, dir.z);
    b->phi0 = minf(b->phi0, phi);
    b->phi1 = maxf(b->phi1, phi);
}

/* A central cap and six sectors of equal solid angle; the cap again so; a sector in four. */
static void structure(void **state)
{
    (void)state;
    struct gather_case *c = new_case(true, false);
    uint32_t node = 0;
    for (int level = 0; level < 2; level++) {
        const struct tree_node *cap = &c->tree.nodes[node];
        float inner = level ? 1 - 1 / 49.0f : 1 - 1 / 7.0f, outer = level ? 1 - 1 / 7.0f : 0;
        assert_int_equal(cap->child_count, 7);
        for (uint32_t k = 0; k < 7; k++) {
            const struct tree_node *child = &c->tree.nodes[cap->first_child + k];
            struct bounds b = {1, 0, 7, 0};
            bound(c, cap->first_child + k, &b);
            assert_float_equal((float)child->sample_count / (float)cap->sample_count, 1 / 7.0f, .035f);
            if (k == 0) {
                assert_true(b.z0 >= inner - 1e-5f);
                continue;
            }
            assert_true(b.z0 >= outer - 1e-5f && b.z1 <= inner + 1e-5f);
            assert_true(b.phi0 >= (float)(k - 1) * PI / 3 - 1e-4f && b.phi1 <= (float)k * PI / 3 + 1e-4f);
            /* Its four parts don't overlap: their extents in z and phi are half of it. */
            assert_int_equal(child->child_count, 4);
            for (uint32_t q = 0; q < 4; q++) {
                struct bounds part = {1, 0, 7, 0};
                bound(c, child->first_child + q, &part);
                assert_true(part.z1 - part.z0 <= .5f * (inner - outer) + 1e-5f);
                assert_true(part.phi1 - part.phi0 <= PI / 6 + 1e-4f);
            }
        }
        node = cap->first_child;
    }
    free_case(c);
}

/* Samples of one direction can't be told apart: one leaf. No samples: no node. A tree may be built again. */
static void corner_cases(void **state)
{
    (void)state;
    struct sample_tree tree = {0};
    struct frame frame = frame_about(vec3(0, 0, 1));
    struct gather_sample s = {vec3(.6f, 0, .8f), 2, vec3(0, 0, -1), vec3(1, 2, 3), .1f, vec3(0, 0, 0)},
                         twins[] = {s, s, s};
    assert_true(sample_tree_build(&tree, twins, 3, ORIGIN, frame));
    assert_int_equal(tree.node_count, 1);
    assert_int_equal(tree.nodes[0].sample_count, 3);
    assert_float_equal(node_omega(&tree.nodes[0]), .3f, 1e-5f);
    twins[2].dir = vec3(0, 0, 1);
    assert_true(sample_tree_build(&tree, twins, 3, ORIGIN, frame));
    assert_int_equal(tree.node_count, 3);
    assert_true(sample_tree_build(&tree, twins, 0, ORIGIN, frame));
    assert_int_equal(tree.node_count, 0);
    sample_tree_free(&tree);
    assert_null(tree.nodes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(sums),      cmocka_unit_test(leaves),
                                       cmocka_unit_test(positions), cmocka_unit_test(black_groups),
                                       cmocka_unit_test(structure), cmocka_unit_test(corner_cases)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
