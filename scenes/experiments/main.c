/* SPDX-License-Identifier: Apache-2.0 */
/* paper_experiments: what the paper's page measures beside pictures of scenes. Each command prints a CSV. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes/experiments/cuts.h"
#include "scenes/experiments/one_record.h"
#include "scenes/experiments/shift.h"

enum { EXIT_DONE, EXIT_USAGE = 2, EXIT_FAILED };

static const char usage[] = "usage: paper_experiments mean_brdf\n"
                            "       paper_experiments shift SCENE_DIR\n"
                            "       paper_experiments one_record SCENE_DIR X Y SIDE OUT_DIR\n";

static bool mean_brdf(char error[static SCENE_ERROR])
{
    if (cuts_print()) return true;
    snprintf(error, SCENE_ERROR, "mean_brdf: out of memory");
    return false;
}

static bool shift(const struct model *model, const struct diffuse_cache *bounced, char error[static SCENE_ERROR])
{
    struct shift_result results[SHIFT_EXPONENTS];
    if (!shift_measure(model, bounced, results)) {
        snprintf(error, SCENE_ERROR, "shift: out of memory");
        return false;
    }
    printf("exponent,way,bytes,cv\n");
    for (int k = 0; k < SHIFT_EXPONENTS; k++)
        for (int way = 0; way < SHIFT_WAYS; way++)
            printf("%g,%s,%u,%g\n", SHIFT_EXPONENT[k], SHIFT_NAMES[way], results[k].bytes[way], results[k].cv[way]);
    return true;
}

/* Reads the scene, fills its diffuse cache, runs the command of so many arguments. */
static bool with_scene(char **arguments, int count, char error[static SCENE_ERROR])
{
    struct scene scene;
    struct model model;
    struct diffuse_cache bounced;
    struct progress quiet = {.quiet = true};
    if (!scene_read(arguments[0], &scene, error)) return false;
    bool good = model_build(&scene, &model, error);
    if (good) {
        good = diffuse_cache_build(&model, 0, 0, &quiet, &bounced, error);
        if (good) {
            good = count == 1 ? shift(&model, &bounced, error)
                              : one_record(&model, &bounced, atoi(arguments[1]), atoi(arguments[2]), atoi(arguments[3]),
                                           arguments[4], error);
            diffuse_cache_free(&bounced);
        }
        model_free(&model);
    }
    scene_free(&scene);
    return good;
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        int arguments;
    } commands[] = {{"mean_brdf", 0}, {"shift", 1}, {"one_record", 5}};
    char error[SCENE_ERROR];
    for (size_t i = 0; argc > 1 && i < sizeof commands / sizeof *commands; i++) {
        int count = commands[i].arguments;
        if (argc != 2 + count || strcmp(argv[1], commands[i].name) != 0) continue;
        if (count == 0 ? mean_brdf(error) : with_scene(argv + 2, count, error)) return EXIT_DONE;
        fprintf(stderr, "paper_experiments: %s\n", error);
        return EXIT_FAILED;
    }
    fputs(usage, stderr);
    return EXIT_USAGE;
}
