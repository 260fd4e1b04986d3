/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stats.h"

#include <errno.h>
#include <jansson.h>
#include <string.h>

const char *stats_method(enum render_method method)
{
    static const char *const names[] = {[RENDER_PATH] = "path",
                                        [RENDER_GATHER] = "gather",
                                        [RENDER_HYBRID] = "hybrid",
                                        [RENDER_EAS] = "eas",
                                        [RENDER_HSH] = "hsh"};
    return names[method];
}

static json_t *stage_list(const struct progress *progress)
{
    json_t *list = json_array();
    for (int i = 0; i < progress->stage_count; ++i) {
        const struct progress_stage *stage = &progress->stages[i];
        json_array_append_new(list, json_pack("{s:s, s:f, s:f, s:I}", "name", stage->name, "wall_s", stage->wall_s,
                                              "cpu_s", stage->cpu_s, "rays", (json_int_t)stage->rays));
    }
    return list;
}

/* json_pack frees what it was given where it fails, so one check at the end is enough. */
static bool dump(json_t *root, FILE *file)
{
    bool good = root && json_dumpf(root, file, JSON_INDENT(2)) == 0 && fputc('\n', file) != EOF;
    json_decref(root);
    return good;
}

bool stats_write(const struct stats *stats, const struct options *options, const struct progress *progress,
                 char error[static IMAGE_ERROR])
{
    const struct render_stats *render = &stats->render;
    json_t *root = json_pack(
        "{s:s, s:s, s:i, s:f, s:I, s:[ii], s:i, s:f, s:f, s:I, s:I, s:I, s:I, s:I, s:f, s:f, s:I, s:I, s:{s:I, s:f}, "
        "s:o}",
        "scene", options->scene, "method", stats_method(options->render.method), "spp", render->spp, "error",
        render->error, "seed", (json_int_t)options->render.seed, "size", stats->width, stats->height, "threads",
        stats->threads, "cpu_s", stats->cpu_s, "wall_s", stats->wall_s, "rays", (json_int_t)stats->rays, "triangles",
        (json_int_t)stats->triangles, "records", (json_int_t)render->records, "loaded_records",
        (json_int_t)stats->loaded_records, "glossy_records", (json_int_t)render->glossy_records, "eas_per_record",
        render->eas_per_record, "bytes_per_record", render->bytes_per_record, "cache_bytes",
        (json_int_t)render->cache_bytes, "peak_bytes", (json_int_t)stats->peak_bytes, "diffuse_cache", "records",
        (json_int_t)render->diffuse_records, "cv", render->diffuse_cv, "stages", stage_list(progress));
    errno = 0;
    FILE *file = fopen(options->stats, "w");
    bool good = file && dump(root, file);
    if (file && fclose(file) != 0) good = false;
    if (!file) json_decref(root);
    if (!good)
        snprintf(error, IMAGE_ERROR, "%s: cannot be written: %s", options->stats,
                 errno ? strerror(errno) : "out of memory");
    return good;
}

static json_t *errors_json(const struct compare_errors *e)
{
    return json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:I}", "rmse", e->rmse, "cv_rmse", e->cv_rmse, "relmse",
                     e->relmse, "mean_ratio", e->mean_ratio, "block_cv", e->block_cv, "block_sigma", e->block_sigma,
                     "reference_cv", e->reference_cv, "pixels", (json_int_t)e->pixels);
}

static bool print_row(FILE *file, const char *name, const struct compare_errors *e)
{
    return fprintf(file, "%-17s %9ld %10.5g %9.5f %9.5f %10.5f %9.5f %11.5f %12.5f\n", name, e->pixels, e->rmse,
                   e->cv_rmse, e->relmse, e->mean_ratio, e->block_cv, e->block_sigma, e->reference_cv) > 0;
}

bool stats_print_compare(FILE *file, const struct compare_result *result, bool json)
{
    if (json) {
        json_t *root = errors_json(&result->masked);
        if (root && json_object_set_new(root, "all", errors_json(&result->all)) != 0) {
            json_decref(root);
            root = NULL;
        }
        return dump(root, file) && fflush(file) == 0;
    }
    fprintf(file, "%-17s %9s %10s %9s %9s %10s %9s %11s %12s\n", "", "pixels", "RMSE", "CV(RMSE)", "relMSE",
            "mean ratio", "block CV", "block sigma", "reference CV");
    return print_row(file, "without emitters", &result->masked) && print_row(file, "all", &result->all) &&
           fflush(file) == 0;
}
