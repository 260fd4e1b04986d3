/* SPDX-License-Identifier: Apache-2.0 */
/* Cost of the mean BRDF of modified Phong in the loop over a record (eas_reflect: translation, look-up, sum), per EAS,
 * as a ratio to one lobe evaluated at a given angle, powf(cosf(angle), n) times radiance, in the same loop. CPU time of
 * one thread, the least of many interleaved rounds: a program to run by hand on an idle machine, no test.
 *
 *     build/tests/mean_brdf_bench
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <time.h>

#include "eas/eas.h"

enum { COUNT = 300, VIEWERS = 64, ROUNDS = 40 };

static const float3 N = {0, 0, 1}, ORIGIN = {0, 0, 0};
static const rgb WHITE = {1, 1, 1};

/* EAS and, one a viewer, lobes; the angles are of the lobes evaluated one by one. */
struct bench {
    struct eas eas[COUNT];
    struct mean_lobe lobes[VIEWERS];
    float angles[COUNT];
    struct brdf brdf;
    volatile float sink;
};

/* Numbers in 0 … 1: the dimensions of an R sequence (Roberts 2018). */
static float spread(int i, int dimension)
{
    const double steps[4] = {.8566749, .7338919, .6287067, .5385972};
    return (float)fmod(.5 + steps[dimension] * (i + 1), 1);
}

static struct eas eas_at(int i, float3 direction, float omega)
{
    return eas_make(ORIGIN, scale(direction, 1 + spread(i, 3)), scale(direction, -1), WHITE, omega, false);
}

static double seconds(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void reflect_all(struct bench *b)
{
    for (int v = 0; v < VIEWERS; v++) b->sink = eas_reflect(b->eas, COUNT, &b->lobes[v], ORIGIN).x;
}

static void evaluate_all(struct bench *b)
{
    for (int v = 0; v < VIEWERS; v++) {
        rgb sum = {0};
        float exponent = b->lobes[v].lobe->exponent;
        for (int i = 0; i < COUNT; i++) sum = mad(sum, b->eas[i].radiance, powf(cosf(b->angles[i]), exponent));
        b->sink = sum.x + sum.y + sum.z;
    }
}

static void compare(struct bench *b, const char *what)
{
    double least[2] = {1e9, 1e9};
    void (*const kinds[2])(struct bench *) = {reflect_all, evaluate_all};
    for (int round = 0; round < ROUNDS; round++)
        for (int k = 0; k < 2; k++) {
            double start = seconds();
            kinds[k](b);
            double took = seconds() - start;
            if (took < least[k]) least[k] = took;
        }
    double per_eas = 1e9 / (COUNT * VIEWERS);
    printf("%-44s n %4.0f: %5.1f ns an EAS, %4.1f ns a lobe, ratio %5.2f\n", what, b->brdf.lobes[0].exponent,
           least[0] * per_eas, least[1] * per_eas, least[0] / least[1]);
}

static void look(struct bench *b, const struct mean_brdf *tables, int v, float3 mirror)
{
    b->lobes[v] = mean_lobe(tables, &b->brdf.lobes[0], N, reflect(mirror, N));
}

/* Caps of .02 sr (4.6 degrees) in the lobe, within two sigmas of a mirror direction 53 degrees up. */
static void all_hit(struct bench *b, const struct mean_brdf *tables, float sigma)
{
    const float3 mirror = {.6f, 0, .8f};
    for (int i = 0; i < COUNT; i++) {
        float r = 2 * sigma * sqrtf(spread(i, 0)), phi = 2 * PI * spread(i, 1);
        float3 local = {sinf(r) * cosf(phi), sinf(r) * sinf(phi), cosf(r)};
        b->eas[i] = eas_at(i, to_world(frame_about(mirror), local), .01f + .02f * spread(i, 2));
    }
    for (int v = 0; v < VIEWERS; v++) look(b, tables, v, mirror);
    compare(b, "all hit, above the horizon");
}

/* A record: the hemisphere in 300 EAS, seen by viewers all over it up to a height. */
static void record(struct bench *b, const struct mean_brdf *tables, float height, const char *what)
{
    for (int i = 0; i < COUNT; i++) {
        float z = spread(i, 0), r = sqrtf(1 - z * z), phi = 2 * PI * spread(i, 1);
        b->eas[i] = eas_at(i, vec3(r * cosf(phi), r * sinf(phi), z), 2 * PI / COUNT);
    }
    for (int v = 0; v < VIEWERS; v++) {
        float z = height * ((float)v + .5f) / VIEWERS, r = sqrtf(1 - z * z), phi = 2.399963f * (float)v;
        look(b, tables, v, vec3(r * cosf(phi), r * sinf(phi), z));
    }
    compare(b, what);
}

/* Caps of .02 sr about the horizon, a mirror direction two degrees up. */
static void all_clipped(struct bench *b, const struct mean_brdf *tables, float sigma)
{
    for (int i = 0; i < COUNT; i++) {
        float up = .05f * (2 * spread(i, 0) - 1), azimuth = 2 * sigma * (2 * spread(i, 1) - 1);
        b->eas[i] = eas_at(i, vec3(cosf(up) * cosf(azimuth), cosf(up) * sinf(azimuth), sinf(up)), .02f);
    }
    for (int v = 0; v < VIEWERS; v++) look(b, tables, v, vec3(cosf(.035f), 0, sinf(.035f)));
    compare(b, "all hit, across the horizon");
}

int main(void)
{
    static struct bench b;
    struct mean_brdf *tables = mean_brdf_build();
    if (!tables) return 1;
    for (int i = 0; i < COUNT; i++) b.angles[i] = .5f * spread(i, 0);
    const float exponents[] = {20, 100, 200, 1000};
    for (int k = 0; k < 4; k++) {
        b.brdf = brdf_phong(ORIGIN, WHITE, exponents[k]);
        float sigma = 1 / sqrtf(exponents[k] + 1);
        all_hit(&b, tables, sigma);
        record(&b, tables, 1, "a record's 300 over the hemisphere");
        record(&b, tables, .2f, "the same, viewers below 12 degrees");
        all_clipped(&b, tables, sigma);
    }
    mean_brdf_free(tables);
    return 0;
}
