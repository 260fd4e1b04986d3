/* SPDX-License-Identifier: Apache-2.0 */
#include "render/options.h"

#include <argp.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXIT_USAGE 2

enum key {
    KEY_STATS = 256,
    KEY_CACHE,
    KEY_RECORDS,
    KEY_FILL,
    KEY_SET,
    KEY_THREADS,
    KEY_SEED,
    KEY_SPP,
    KEY_ERROR,
    KEY_SIZE,
    KEY_IMAGE2,
    KEY_REFERENCE2,
    KEY_JSON,
    KEY_LAYER
};

static const char about[] =
    "Renders glossy scenes with a radiance cache, and measures pictures against each other. `burnish render --help' "
    "and `burnish compare --help' say more.\v"
    "Exit status: 0 done, 2 wrong usage, 3 an input file is missing or wrong, 4 out of memory or the output cannot be "
    "written.";

/* A whole number in [low, high], or a usage error. */
static uint64_t number(struct argp_state *state, const char *option, const char *text, uint64_t low, uint64_t high)
{
    char *end;
    errno = 0;
    unsigned long long value = strtoull(text, &end, 10);
    if (*text < '0' || *text > '9' || *end || errno || value < low || value > high)
        argp_error(state, "%s: found '%s', expected a whole number from %llu to %llu", option, text,
                   (unsigned long long)low, (unsigned long long)high);
    return value;
}

static void size(struct argp_state *state, const char *text, struct options *options)
{
    char *end;
    errno = 0;
    unsigned long width = strtoul(text, &end, 10), height = 0;
    bool good = *text >= '0' && *text <= '9' && *end == 'x' && end[1] >= '0' && end[1] <= '9';
    if (good) height = strtoul(end + 1, &end, 10);
    if (!good || *end || errno || width < 1 || height < 1 || width > OPTIONS_SIZE_MAX || height > OPTIONS_SIZE_MAX)
        argp_error(state, "--size: found '%s', expected WIDTHxHEIGHT in pixels, each from 1 to %d", text,
                   OPTIONS_SIZE_MAX);
    options->width = (int)width;
    options->height = (int)height;
}

/* A share in (0, 1], or a usage error. */
static double share(struct argp_state *state, const char *option, const char *text)
{
    char *end;
    double value = strtod(text, &end);
    if (*end || end == text || !(value > 0 && value <= 1))
        argp_error(state, "%s: found '%s', expected a number above 0, up to 1", option, text);
    return value;
}

static enum render_method method(struct argp_state *state, const char *text)
{
    if (strcmp(text, "auto") == 0) return RENDER_AUTO;
    if (strcmp(text, "eas") == 0) return RENDER_EAS;
    if (strcmp(text, "hybrid") == 0) return RENDER_HYBRID;
    if (strcmp(text, "gather") == 0) return RENDER_GATHER;
    if (strcmp(text, "hsh") == 0) return RENDER_HSH;
    if (strcmp(text, "path") == 0) return RENDER_PATH;
    argp_error(state, "--method: found '%s', expected auto, eas, hsh, hybrid, gather or path", text);
    return RENDER_EAS;
}

/* Which of two words `text` is: true for the second. */
static bool second_word(struct argp_state *state, const char *option, const char *text, const char *const words[2])
{
    if (strcmp(text, words[0]) != 0 && strcmp(text, words[1]) != 0)
        argp_error(state, "%s: found '%s', expected %s or %s", option, text, words[0], words[1]);
    return strcmp(text, words[1]) == 0;
}

static void require_ending(struct argp_state *state, const char *option, const char *path, const char *ending)
{
    size_t length = strlen(path), n = strlen(ending);
    if (length <= n || strcmp(path + length - n, ending) != 0)
        argp_error(state, "%s: found '%s', expected a name that ends in %s", option, path, ending);
}

static const struct argp_option render_arguments[] = {
    {"output", 'o', "OUT.exr", 0, "the picture to write", 0},
    {"method", 'm', "auto|eas|hsh|hybrid|gather|path", 0,
     "radiance cache of equivalent area sources or of hemispherical harmonics (the baseline), irradiance cache with "
     "traced specular rays, traced rays alone that end at a diffuse cache (for a denoiser), or path tracing (auto: "
     "eas; with --error path, gather or hybrid where that is cheaper)",
     0},
    {"spp", KEY_SPP, "N", 0, "mean of primary rays a pixel (16; path: 64); with --error: the most of them (1024)", 0},
    {"error", KEY_ERROR, "X", 0,
     "stop where the estimated error is X: CV(RMSE), without directly seen emitters; .05 is a preview, .02 good", 0},
    {"size", KEY_SIZE, "WxH", 0, "pixels (the scene's)", 0},
    {"set", KEY_SET, "materials/NAME/exponent=VALUE", 0,
     "replace a material's exponent or (roughness=) roughness, or move the camera: camera/shift=X,Y,Z in "
     "metres; may be given again",
     0},
    {"threads", KEY_THREADS, "N", 0, "threads (all cores); the picture does not depend on it", 0},
    {"seed", KEY_SEED, "N", 0, "chooses the random numbers (0)", 0},
    {"fill", KEY_FILL, "camera|surfaces", 0,
     "where records are made: where the camera sees, or all over the scene, for any camera (camera)", 0},
    {"records", KEY_RECORDS, "indirect|all", 0,
     "light that records hold: what bounced, or that of lamps, too (indirect)", 0},
    {"cache", KEY_CACHE, "FILE", 0,
     "take the caches from there, for any camera and exponents; make the file where it is not there", 0},
    {"stats", KEY_STATS, "FILE.json", 0, "write seconds, rays, records and bytes there", 0},
    {0}};

static error_t parse_render(int key, char *text, struct argp_state *state)
{
    struct options *options = state->input;
    switch (key) {
    case 'o':
        require_ending(state, "--output", text, ".exr");
        options->output = text;
        return 0;
    case 'm': options->render.method = method(state, text); return 0;
    case KEY_SPP: options->render.spp = (int)number(state, "--spp", text, 1, 1 << 24); return 0;
    case KEY_ERROR: options->render.error = share(state, "--error", text); return 0;
    case KEY_SIZE: size(state, text, options); return 0;
    case KEY_THREADS: options->threads = (int)number(state, "--threads", text, 1, 1024); return 0;
    case KEY_SEED: options->render.seed = number(state, "--seed", text, 0, INT64_MAX); return 0;
    case KEY_FILL:
        options->render.over_surfaces = second_word(state, "--fill", text, (const char *const[]){"camera", "surfaces"});
        return 0;
    case KEY_RECORDS:
        options->render.lamps_in_records =
            second_word(state, "--records", text, (const char *const[]){"indirect", "all"});
        return 0;
    case KEY_CACHE: options->cache = text; return 0;
    case KEY_STATS: options->stats = text; return 0;
    case KEY_SET:
        if (options->set_count == OPTIONS_SETS) argp_error(state, "--set: at most %d times", OPTIONS_SETS);
        options->sets[options->set_count++] = text;
        return 0;
    case ARGP_KEY_ARG:
        if (options->scene) argp_error(state, "found a second scene, '%s', expected one", text);
        options->scene = text;
        return 0;
    case ARGP_KEY_END:
        if (!options->scene) argp_error(state, "expected the folder of a scene");
        if (!options->output) argp_error(state, "expected -o OUT.exr");
        if (options->cache && options->render.method == RENDER_PATH)
            argp_error(state, "--cache: --method path has no caches");
        if (options->render.method == RENDER_PATH || options->render.method == RENDER_GATHER) {
            const char *name = options->render.method == RENDER_PATH ? "path" : "gather";
            if (options->render.over_surfaces) argp_error(state, "--fill: --method %s has no records", name);
            if (options->render.lamps_in_records) argp_error(state, "--records: --method %s has no records", name);
        }
        if (options->render.error > 0 && options->cache)
            argp_error(state, "--error: makes caches of its own, which --cache can't keep");
        if (!options->render.spp && options->render.error > 0) options->render.spp = 1024;
        if (!options->render.spp) options->render.spp = options->render.method == RENDER_PATH ? 64 : 16;
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option compare_arguments[] = {
    {"image2", KEY_IMAGE2, "FILE", 0, "an independent second half of the picture: takes its noise out of the errors",
     0},
    {"reference2", KEY_REFERENCE2, "FILE", 0, "the same for the reference", 0},
    {"layer", KEY_LAYER, "NAME", 0, "Combined, Direct, Indirect … (Combined)", 0},
    {"difference", 'd', "OUT.png", 0, "write a false-colour picture of the errors", 0},
    {"json", KEY_JSON, NULL, 0, "print JSON", 0},
    {0}};

static error_t parse_compare(int key, char *text, struct argp_state *state)
{
    struct options *options = state->input;
    switch (key) {
    case KEY_IMAGE2: options->image2 = text; return 0;
    case KEY_REFERENCE2: options->reference2 = text; return 0;
    case KEY_LAYER: options->layer = text; return 0;
    case KEY_JSON: options->json = true; return 0;
    case 'd':
        require_ending(state, "--difference", text, ".png");
        options->difference = text;
        return 0;
    case ARGP_KEY_ARG:
        if (options->reference) argp_error(state, "found a third picture, '%s', expected two", text);
        *(options->image ? &options->reference : &options->image) = text;
        return 0;
    case ARGP_KEY_END:
        if (!options->reference) argp_error(state, "expected two pictures, IMAGE and REFERENCE");
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp render_command = {render_arguments,
                                           parse_render,
                                           "SCENE_DIR -o OUT.exr",
                                           "Renders the scene in a folder (import/FORMAT.md).",
                                           NULL,
                                           NULL,
                                           NULL};
static const struct argp compare_command = {
    compare_arguments,
    parse_compare,
    "IMAGE REFERENCE",
    "Prints the errors of a picture against a reference (render/compare.h), without directly seen emitters and with.",
    NULL,
    NULL,
    NULL};

/* The first word chooses the command; all after it is that command's. */
static error_t parse_command(int key, char *text, struct argp_state *state)
{
    struct options *options = state->input;
    const struct argp *command;
    static char render_name[] = "burnish render", compare_name[] = "burnish compare"; /* for messages */
    char *name;
    switch (key) {
    case ARGP_KEY_NO_ARGS: argp_error(state, "expected a command: render or compare"); return 0;
    case ARGP_KEY_ARG:
        if (strcmp(text, "render") == 0) {
            options->command = COMMAND_RENDER;
            command = &render_command;
            name = render_name;
        } else if (strcmp(text, "compare") == 0) {
            options->command = COMMAND_COMPARE;
            command = &compare_command;
            name = compare_name;
        } else {
            argp_error(state, "found the command '%s', expected render or compare", text);
            return 0;
        }
        state->argv[state->next - 1] = name;
        argp_parse(command, state->argc - state->next + 1, state->argv + state->next - 1, 0, NULL, options);
        state->next = state->argc;
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

void options_parse(int argc, char **argv, struct options *options)
{
    static const struct argp program = {NULL, parse_command, "render|compare …", about, NULL, NULL, NULL};
    argp_program_version = "burnish " BURNISH_VERSION;
    argp_err_exit_status = EXIT_USAGE;
    *options = (struct options){.render = {.method = RENDER_AUTO}, .layer = "Combined"};
    argp_parse(&program, argc, argv, ARGP_IN_ORDER, NULL, options);
}
