/* SPDX-License-Identifier: Apache-2.0 */
/* The command line, by argp. Usage errors exit 2 with one sentence. */
#ifndef RENDER_OPTIONS_H
#define RENDER_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "render/render.h"

struct options {
    enum command { COMMAND_RENDER, COMMAND_COMPARE } command;
    /* render */
    const char *scene, *output, *stats;
    int width, height; /* 0: the scene's */
    int threads;       /* 0: all cores */
    struct render_options render;
    /* compare */
    const char *image, *reference, *reference2, *difference;
    bool json;
};

/* Fills *options or ends the program as argp does (2 on a usage error, 0 after --help). */
void options_parse(int argc, char **argv, struct options *options);

#endif
