/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of the mean GGX lobe (tests/mean_ggx_errors.h) by alphas and caps, and its cost per cap as a ratio to one lobe
 * evaluated at a given angle, powf(cosf(angle), n): a program to run by hand on an idle machine, no test.
 *
 *     build/tests/mean_ggx_bench
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <time.h>

#include "tests/mean_ggx_errors.h"

#define DEGREE (PI / 180)
enum { ALPHAS = 6, ASPECTS = 3, THETAS = 6, PLACES = 6, COUNT = 256, ROUNDS = 2000 };

static const float ALPHA[ALPHAS] = {.09f, .16f, .25f, .36f, .64f, 1}, ANISOTROPIC[ASPECTS] = {0, .775f, .997f};
static const float THETA[THETAS] = {.5f, 2, 5, 10, 20, 30};
/* Elevations of caps: degrees for those above the horizon, radii for those across it. */
static const float ABOVE[PLACES] = {8, 15, 25, 40, 60, 85}, ACROSS[PLACES] = {-.7f, -.4f, 0, .4f, .7f, .95f};

/* Over all places of a cap, tangents along it and turned by 45 degrees. */
static struct errors over_places(float alpha, float anisotropic, float theta, bool across, bool white, float least_up)
{
    struct errors all = {0, 0};
    int count = 0;
    for (int place = 0; place < PLACES; place++)
        for (int turned = 0; turned < 2; turned++) {
            float elevation = across ? ACROSS[place] * theta : ABOVE[place] * DEGREE;
            if (!across && elevation < theta) continue;
            struct lobe lobe = ggx_lobe(sqrtf(alpha), anisotropic, (float)turned * PI / 4, white);
            struct errors one = errors_of(&lobe, cap_at(elevation, theta), least_up);
            all.rms += sqr(one.rms);
            all.most = maxf(all.most, one.most);
            count++;
        }
    all.rms = sqrtf(all.rms / (float)count);
    return all;
}

static void print_errors(bool across, bool white, float least_up)
{
    printf("\ncaps %s the horizon, F %s, viewers at least %.0f degrees up: rms / largest error in %%\n%-22s",
           across ? "across" : "above", white ? "1" : ".04 to 1", least_up / DEGREE, "alpha_x, alpha_y, cap");
    for (int k = 0; k < THETAS; k++) printf("%10g deg", THETA[k]);
    struct errors all[THETAS] = {{0, 0}};
    for (int i = 0; i < ALPHAS; i++)
        for (int j = 0; j < ASPECTS; j++) {
            float2 alpha = ggx_alphas(sqrtf(ALPHA[i]), ANISOTROPIC[j]);
            printf("\n%8.3f %.3f        ", alpha.x, alpha.y);
            for (int k = 0; k < THETAS; k++) {
                struct errors one = over_places(ALPHA[i], ANISOTROPIC[j], THETA[k] * DEGREE, across, white, least_up);
                all[k].rms += sqr(one.rms) / (ALPHAS * ASPECTS);
                all[k].most = maxf(all[k].most, one.most);
                printf("%6.2f /%6.2f", 100 * one.rms, 100 * one.most);
                fflush(stdout);
            }
        }
    printf("\n%-22s", "all");
    for (int k = 0; k < THETAS; k++) printf("%6.2f /%6.2f", 100 * sqrtf(all[k].rms), 100 * all[k].most);
    printf("\n");
}

static double seconds(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* CPU time of one thread, the least of many interleaved rounds. */
static void print_cost(const char *what, float low, float high, float theta, int at_once)
{
    static struct cap caps[COUNT];
    static rgb values[COUNT];
    static float angles[COUNT];
    struct lobe lobe = ggx_lobe(.5f, .775f, 0, false);
    double least[2] = {1, 1};
    for (int i = 0; i < COUNT; i++) {
        float u = (float)i / COUNT;
        caps[i] = cap_at(low + (high - low) * u, theta);
        angles[i] = u;
    }
    for (int round = 0; round < ROUNDS; round++) {
        double start = seconds();
        struct mean_ggx mean = mean_ggx(&lobe, vec3(0, 0, 1), direction(.7f, 3));
        for (int i = 0; i < COUNT; i += at_once) mean_ggx_caps(&mean, caps + i, at_once, values + i);
        double middle = seconds();
        float sum = 0;
        for (int i = 0; i < COUNT; i++) sum += powf(cosf(angles[i]), 40);
        angles[0] = 1e-9f * (sum + values[0].x); /* or both would be left out */
        double end = seconds();
        least[0] = fmin(least[0], middle - start);
        least[1] = fmin(least[1], end - middle);
    }
    printf("%-40s %6.1f ns a cap, %4.1f ns a lobe, ratio %5.1f\n", what, least[0] * 1e9 / COUNT, least[1] * 1e9 / COUNT,
           least[0] / least[1]);
}

int main(void)
{
    print_cost("above the horizon, 5 degrees", .2f, 1.4f, 5 * DEGREE, COUNT);
    print_cost("above the horizon, one at a time", .2f, 1.4f, 5 * DEGREE, 1);
    print_cost("across the horizon", -.05f, .05f, 5 * DEGREE, COUNT);
    for (int across = 0; across < 2; across++)
        for (int white = 1; white >= 0; white--) print_errors(across, white, asinf(.2f));
    print_errors(false, true, 5 * DEGREE);
    print_errors(true, true, 5 * DEGREE);
    return 0;
}
