/* SPDX-License-Identifier: Apache-2.0 */
/* The command line, by argp. */
#ifndef RENDER_OPTIONS_H
#define RENDER_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "render/render.h"

#define OPTIONS_SIZE_MAX 32768 /* pixels a side */
#define OPTIONS_SETS 32        /* assignments by --set */

struct options {
    enum command { COMMAND_RENDER, COMMAND_COMPARE } command;
    /* render */
    const char *scene, *output;
    const char *stats; /* NULL: none */
    const char *cache; /* file of the caches, NULL: none */
    int width, height; /* 0: the scene's */
    int threads;       /* 0: all cores */
    int set_count;
    const char *sets[OPTIONS_SETS]; /* for scene_set, in the order given */
    struct render_options render;
    /* compare; those that are not given are NULL */
    const char *image, *image2, *reference, *reference2, *difference;
    const char *layer; /* "Combined" … */
    bool json;
};

/* Fills *options with strings of argv, or ends the program as argp does: 2 and one sentence on stderr on a usage
 * error, 0 after --help and --version. Changes argv. */
void options_parse(int argc, char **argv, struct options *options);

#endif
