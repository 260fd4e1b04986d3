/* SPDX-License-Identifier: Apache-2.0 */
/* burnish: scene in, picture out; picture against picture. */
#include <limits.h>
#include <omp.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "import/scene_hash.h"
#include "render/accuracy.h"
#include "render/cache_file.h"
#include "render/compare.h"
#include "render/options.h"
#include "render/render.h"
#include "render/stats.h"

enum { EXIT_DONE, EXIT_INPUT = 3, EXIT_OUTPUT = 4 };

/* The unfinished outputs, for the signal handler, which can be handed nothing. */
enum { PICTURE, CACHE, OUTPUTS };
static char unfinished[OUTPUTS][PATH_MAX];

static void remove_unfinished(int signal)
{
    for (int i = 0; i < OUTPUTS; i++) unlink(unfinished[i]);
    raise(signal); /* SA_RESETHAND: now ends the program, and the shell learns by what */
}

/* From now on a signal that ends the program leaves no part of `path` behind. Says early whether it can be written. */
static bool prepare_output(const char *path, int which, char error[static IMAGE_ERROR])
{
    char folder[PATH_MAX];
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    if (length >= sizeof folder || !image_temporary(path, unfinished[which], sizeof unfinished[which])) {
        snprintf(error, IMAGE_ERROR, "%.200s…: the name is too long", path);
        return false;
    }
    memcpy(folder, path, length);
    folder[length] = '\0';
    if (access(slash ? folder : ".", W_OK | X_OK) != 0) {
        snprintf(error, IMAGE_ERROR, "%s: cannot be written: found no folder that is there and writable, expected one",
                 path);
        return false;
    }
    struct sigaction action = {.sa_handler = remove_unfinished, .sa_flags = (int)SA_RESETHAND | SA_NODEFER};
    int signals[] = {SIGINT, SIGTERM, SIGHUP};
    for (int i = 0; i < 3; ++i) sigaction(signals[i], &action, NULL);
    return true;
}

static int fail(int code, const char *error)
{
    fprintf(stderr, "burnish: %s\n", error);
    return code;
}

/* The last part of the scene's path, as the user typed it. */
static void scene_name(const char *path, char *name, size_t size)
{
    size_t end = strlen(path);
    while (end > 1 && path[end - 1] == '/') --end;
    size_t start = end;
    while (start > 0 && path[start - 1] != '/') --start;
    snprintf(name, size, "%.*s", (int)(end - start), path + start);
}

/* Header: all that the pixels depend on, and nothing else, so that equal pictures are equal files. */
static bool write_picture(const struct options *options, const struct image *image, int spp,
                          char error[static IMAGE_ERROR])
{
    char scene[256], spp_text[16], seed[32];
    scene_name(options->scene, scene, sizeof scene);
    snprintf(spp_text, sizeof spp_text, "%d", spp);
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)options->render.seed);
    const struct image_attribute attributes[] = {
        {"burnish:version", BURNISH_VERSION},
        {"burnish:scene", scene},
        {"burnish:method", stats_method(options->render.method)},
        {"burnish:records", options->render.lamps_in_records ? "all" : "indirect"},
        {"burnish:fill", options->render.over_surfaces ? "surfaces" : "camera"},
        {"burnish:spp", spp_text},
        {"burnish:seed", seed}};
    return image_write(options->output, image, false, attributes, sizeof attributes / sizeof attributes[0], error);
}

static uint64_t peak_bytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (uint64_t)usage.ru_maxrss * 1024;
}

/* Takes the caches from options->cache, and says what a reader of the picture should know. 0 or an exit code. */
static int load_caches(const struct model *model, const struct options *options, uint64_t hash,
                       struct progress *progress, struct fill *fill, uint64_t *loaded, char error[static SCENE_ERROR])
{
    struct fill_options wanted = render_fill(&options->render);
    struct cache_file_change change;
    progress_begin(progress, "loading", 0);
    if (!cache_file_read(options->cache, hash, model->scene, &wanted, fill, &change, error)) return EXIT_INPUT;
    progress_end(progress, 0);
    *loaded = fill_records(fill);
    if (change.materials) fprintf(stderr, "burnish: %s: %s\n", options->cache, change.stale);
    if (wanted.surfaces || (!change.camera && !change.materials)) return EXIT_DONE;
    if (!fill_extend(model, progress, fill, error)) return EXIT_OUTPUT;
    if (fill_records(fill) > *loaded)
        fprintf(stderr, "burnish: %s: %llu records were added to its %llu for this picture; the file stays as it was\n",
                options->cache, (unsigned long long)(fill_records(fill) - *loaded), (unsigned long long)*loaded);
    return EXIT_DONE;
}

/* The caches: from options->cache where that is there; else made, and kept there. 0 or an exit code; the caller frees
 * *fill in any case. */
static int prepare_caches(const struct model *model, struct options *options, struct progress *progress,
                          struct fill *fill, uint64_t *loaded, char error[static SCENE_ERROR])
{
    struct fill_options wanted = render_fill(&options->render);
    uint64_t hash = 0;
    if (options->cache && !scene_hash(options->scene, model->scene, &hash, error)) return EXIT_INPUT;
    if (options->cache && access(options->cache, F_OK) == 0)
        return load_caches(model, options, hash, progress, fill, loaded, error);
    bool made = options->render.error > 0 ? accuracy_fill(model, &options->render, progress, fill, error)
                                          : fill_build(model, &wanted, progress, fill, error);
    if (!made) return EXIT_OUTPUT;
    if (options->cache && !cache_file_write(options->cache, hash, model->scene, fill, error)) return EXIT_OUTPUT;
    return EXIT_DONE;
}

/* From the parsed scene to pixels. 0 or an exit code. */
static int make_picture(struct scene *scene, struct options *options, struct progress *progress,
                        struct stats *stats, struct image *image, char error[static SCENE_ERROR])
{
    double wall = progress_wall(), cpu = progress_cpu();
    if (options->width) camera_resize(&scene->camera, options->width, options->height);
    struct model model;
    progress_begin(progress, "model", 0);
    if (!model_build(scene, &model, error)) return EXIT_INPUT;
    if (!accuracy_choose(&model, &options->render, progress)) {
        model_free(&model);
        snprintf(error, SCENE_ERROR, "out of memory");
        return EXIT_OUTPUT;
    }
    progress_end(progress, trace_rays(model.trace));
    struct film film = {0};
    struct fill fill = {0};
    bool cached = options->render.method != RENDER_PATH;
    int code = cached ? prepare_caches(&model, options, progress, &fill, &stats->loaded_records, error) : EXIT_DONE;
    if (code == EXIT_DONE &&
        !render(&model, &options->render, cached ? &fill : NULL, progress, &film, &stats->render, error))
        code = EXIT_OUTPUT;
    if (code == EXIT_DONE && !film_image(&film, image)) {
        code = EXIT_OUTPUT;
        snprintf(error, SCENE_ERROR, "out of memory for the picture");
    }
    stats->rays = trace_rays(model.trace);
    stats->triangles = model.triangle_count;
    stats->width = film.width;
    stats->height = film.height;
    film_free(&film);
    fill_free(&fill);
    model_free(&model);
    stats->wall_s = progress_wall() - wall;
    stats->cpu_s = progress_cpu() - cpu;
    stats->peak_bytes = peak_bytes();
    return code;
}

static int command_render(struct options *options)
{
    char error[SCENE_ERROR];
    struct scene scene;
    struct image image = {0};
    struct progress progress = {0};
    if (options->threads) omp_set_num_threads(options->threads);
    struct stats stats = {.threads = omp_get_max_threads()};
    bool save = options->cache && access(options->cache, F_OK) != 0;
    if (!prepare_output(options->output, PICTURE, error) || (save && !prepare_output(options->cache, CACHE, error)))
        return fail(EXIT_OUTPUT, error);
    if (!scene_read(options->scene, &scene, error)) return fail(EXIT_INPUT, error);
    for (int i = 0; i < options->set_count; i++)
        if (!scene_set(&scene, options->sets[i], error)) {
            scene_free(&scene);
            return fail(EXIT_INPUT, error);
        }
    int code = make_picture(&scene, options, &progress, &stats, &image, error);
    if (code == EXIT_DONE && (!write_picture(options, &image, stats.render.spp, error) ||
                              (options->stats && !stats_write(&stats, options, &progress, error))))
        code = EXIT_OUTPUT;
    image_free(&image);
    scene_free(&scene);
    return code == EXIT_DONE ? code : fail(code, error);
}

/* The pictures of a comparison; those not given stay empty. */
enum { IMAGE, IMAGE2, REFERENCE, REFERENCE2, IMAGES };

static int compare_images(const struct options *options, struct image images[static IMAGES],
                          char error[static IMAGE_ERROR])
{
    const char *paths[IMAGES] = {options->image, options->image2, options->reference, options->reference2};
    struct compare_input input = {.layer = options->layer};
    const struct image **slots[IMAGES] = {&input.image, &input.image2, &input.reference, &input.reference2};
    for (int i = 0; i < IMAGES; ++i) {
        if (!paths[i]) continue;
        if (!image_read(paths[i], false, &images[i], error)) return EXIT_INPUT;
        *slots[i] = &images[i];
    }
    struct compare_result result;
    if (!compare(&input, &result, error)) return EXIT_INPUT;
    if (options->difference) {
        if (!prepare_output(options->difference, PICTURE, error)) return EXIT_OUTPUT;
        struct image picture;
        if (!compare_picture(&input, &picture, error)) return EXIT_OUTPUT;
        bool written = image_write(options->difference, &picture, false, NULL, 0, error);
        image_free(&picture);
        if (!written) return EXIT_OUTPUT;
    }
    if (stats_print_compare(stdout, &result, options->json)) return EXIT_DONE;
    snprintf(error, IMAGE_ERROR, "the errors cannot be printed: standard output is full or closed");
    return EXIT_OUTPUT;
}

static int command_compare(const struct options *options)
{
    char error[IMAGE_ERROR];
    struct image images[IMAGES] = {0};
    int code = compare_images(options, images, error);
    for (int i = 0; i < IMAGES; ++i) image_free(&images[i]);
    return code == EXIT_DONE ? code : fail(code, error);
}

int main(int argc, char **argv)
{
    struct options options;
    options_parse(argc, argv, &options);
    return options.command == COMMAND_RENDER ? command_render(&options) : command_compare(&options);
}
