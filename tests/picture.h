/* SPDX-License-Identifier: Apache-2.0 */
/* Whole pictures of a stage, by any method; cmocka.h comes before this. */
#ifndef TESTS_PICTURE_H
#define TESTS_PICTURE_H

#include "render/render.h"
#include "tests/stage.h"

/* Means over a picture, and how many records it took. */
struct light {
    double direct, indirect, emission;
    uint64_t records;
};

static inline struct light draw(const struct model *model, struct render_options options)
{
    struct progress quiet = {.quiet = true};
    struct fill_options wanted = render_fill(&options);
    struct fill fill = {0};
    struct film film;
    struct render_stats stats;
    char error[SCENE_ERROR];
    bool cached = options.method != RENDER_PATH;
    if (cached) assert_true(fill_build(model, &wanted, &quiet, &fill, error));
    assert_true(render(model, &options, cached ? &fill : NULL, &quiet, &film, &stats, error));
    struct light light = {.records = stats.records};
    for (int i = 0; i < film.width * film.height; i++) {
        double share = 1.0 / film.width / film.height / film.pixels[i].samples;
        light.direct += film.pixels[i].direct.x * share;
        light.indirect += film.pixels[i].indirect.x * share;
        light.emission += film.pixels[i].emission.x * share;
    }
    film_free(&film);
    fill_free(&fill);
    return light;
}

#endif
