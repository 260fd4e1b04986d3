/* SPDX-License-Identifier: Apache-2.0 */
/* What the program reports in numbers: the file of --stats and the errors of `burnish compare`. */
#ifndef RENDER_STATS_H
#define RENDER_STATS_H

#include <stdio.h>

#include "render/compare.h"
#include "render/options.h"
#include "render/progress.h"

/* A whole run. */
struct stats {
    double cpu_s, wall_s; /* from the parsed scene to pixels; user CPU seconds of all threads */
    uint64_t rays;
    uint64_t triangles;      /* instances not multiplied */
    uint64_t peak_bytes;     /* most memory held so far */
    uint64_t loaded_records; /* of render.records, those that came from the file of --cache */
    int width, height, threads;
    struct render_stats render;
};

/* Name of a method as the command line spells it. */
const char *stats_method(enum render_method method);

/* Writes JSON to options->stats. False and a sentence where that fails. */
bool stats_write(const struct stats *stats, const struct options *options, const struct progress *progress,
                 char error[static IMAGE_ERROR]);

/* Prints the errors as a table, or as JSON: those of the masked set at the top level, those of all pixels under "all".
 * False where memory or the file's place runs out. */
bool stats_print_compare(FILE *file, const struct compare_result *result, bool json);

#endif
