/* SPDX-License-Identifier: Apache-2.0 */
/* Samples by a pilot's noise: a picture whose left is plain and whose right, a narrow lobe over a wall of stripes, is
 * noisy. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "render/adaptive.h"
#include "tests/stage.h"

enum { SIZE = 64, SPP = 16, SEEDS = 8, STRIPES = 5 };

static struct stage *new_scene(void)
{
    struct stage *s = new_stage();
    s->scene.camera.width = s->scene.camera.height = SIZE;
    add_quad(s, vec3(-2, 0, -2), vec3(2, 0, 0), vec3(0, 4, 0), grey(.02f, 0, 0, 0));
    add_quad(s, vec3(2, 0, -2), vec3(2, 0, 0), vec3(0, 4, 0), grey(0, .8f, 1000, 0));
    float3 stripes[4 * STRIPES];
    for (int i = 0; i < STRIPES; i++) {
        float left = -4.0f + 2 * (float)i;
        stripes[4 * i] = vec3(left, -9, 2);
        stripes[4 * i + 1] = vec3(left, 9, 2);
        stripes[4 * i + 2] = vec3(left + 1, 9, 2);
        stripes[4 * i + 3] = vec3(left + 1, -9, 2);
    }
    add_mesh(s, stripes, 4, STRIPES, grey(0, 0, 0, 1));
    return s;
}

/* Of the left and the right half: mean radiance, and the sum of the pixels' variances over seeds. */
struct measured {
    double mean[2], squares[2];
};

static struct measured measure(const struct model *model, const struct cached *cached, const float *weights)
{
    struct measured out = {{0}, {0}};
    struct progress quiet = {.quiet = true};
    double sums[SIZE * SIZE] = {0}, squares[SIZE * SIZE] = {0};
    for (int seed = 0; seed < SEEDS; seed++) {
        struct film film;
        struct render_pass pass = {SPP, weights, 100 + (uint64_t)seed, 1};
        assert_true(film_alloc(&film, SIZE, SIZE, true));
        render_samples(model, cached, &pass, &quiet, &film);
        for (int i = 0; i < SIZE * SIZE; i++) {
            const struct pixel *p = &film.pixels[i];
            double value = p->samples > 0 ? (p->direct.x + p->indirect.x) / p->samples : 0;
            sums[i] += value / SEEDS;
            squares[i] += value * value / SEEDS;
            out.mean[i % SIZE >= SIZE / 2] += value / (SEEDS * SIZE * SIZE / 2);
        }
        film_free(&film);
    }
    for (int i = 0; i < SIZE * SIZE; i++) out.squares[i % SIZE >= SIZE / 2] += squares[i] - sums[i] * sums[i];
    return out;
}

static void samples_go_where_the_noise_is(void **state)
{
    (void)state;
    struct stage *s = new_scene();
    struct model model = build(s);
    struct progress quiet = {.quiet = true};
    struct fill_options wanted = {.kind = FILL_EAS, .seed = 1};
    struct fill fill = {0};
    struct cached cached;
    char error[SCENE_ERROR];
    float *weights;
    double gain, sums[2] = {0};
    assert_true(fill_build(&model, &wanted, &quiet, &fill, error));
    assert_true(cached_prepare(&model, &fill, &cached));
    assert_true(adaptive_weights(&model, &cached, 1, &quiet, &weights, &gain));
    for (int i = 0; i < SIZE * SIZE; i++) sums[i % SIZE >= SIZE / 2] += weights[i] / (SIZE * SIZE);
    assert_float_equal(sums[0] + sums[1], 1, 1e-4f);
    assert_true(sums[1] > 3 * sums[0]);
    struct measured even = measure(&model, &cached, NULL), shared = measure(&model, &cached, weights);
    assert_true(shared.squares[1] < .85 * even.squares[1]); /* half the picture has most samples */
    assert_true(gain > 1.2 && gain < 2);
    for (int half = 0; half < 2; half++)
        assert_float_equal(shared.mean[half], even.mean[half], .01f * (float)(even.mean[0] + even.mean[1]));
    free(weights);
    cached_free(&cached);
    fill_free(&fill);
    end(s, &model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(samples_go_where_the_noise_is)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
