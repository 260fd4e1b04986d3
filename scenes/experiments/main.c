/* SPDX-License-Identifier: Apache-2.0 */
/* paper_experiments: what the paper's page measures beside pictures of scenes. Each command prints a CSV. */
#include <stdio.h>
#include <string.h>

#include "scenes/experiments/cuts.h"

static const struct {
    const char *name;
    bool (*print)(void);
} commands[] = {{"mean_brdf", cuts_print}};

int main(int argc, char **argv)
{
    for (size_t i = 0; argc == 2 && i < sizeof commands / sizeof *commands; i++)
        if (strcmp(argv[1], commands[i].name) == 0) {
            if (commands[i].print()) return 0;
            fprintf(stderr, "paper_experiments %s: out of memory\n", argv[1]);
            return 4;
        }
    fputs("usage: paper_experiments mean_brdf\n", stderr);
    return 2;
}
