/* SPDX-License-Identifier: Apache-2.0 */
/* Typed reading of a JSON document over jansson, with the path of each value in every error.
 *
 *     struct json_file file;
 *     struct json_node root = json_open("scene.json", &file, error);
 *     int version = json_get_integer(&root, "version", 1, 1);
 *     struct json_node lights = json_get_list(&root, "lights");
 *     for (size_t i = 0; i < json_length(&lights); i++) {
 *         struct json_node light = json_get_item(&lights, i);
 *         float radius = json_get_number(&light, "radius", 0, HUGE_VAL);
 *         json_end(&light);
 *     }
 *     json_end(&root);
 *     json_close(&file);
 *     return !file.failed;
 *
 * The first error stays in file.failed and `error`, as "scene.json: lights[3].radius: found ..., expected ...";
 * whatever is read after it is zero or empty, so that a caller checks once. A node points at its parent, which must
 * outlive it. A document belongs to one thread.
 */
#ifndef IMPORT_JSON_H
#define IMPORT_JSON_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "import/scene.h"

#define JSON_KEYS 24 /* the most keys that one object may have */

struct json_file {
    const char *path; /* as it stands in errors */
    json_t *root;
    char *error; /* SCENE_ERROR bytes */
    bool failed;
};

struct json_node {
    struct json_file *file;
    json_t *value; /* NULL: reads as absent */
    const struct json_node *parent;
    const char *key; /* in the parent; NULL: item `index` of a list */
    size_t index;
    const char *known[JSON_KEYS]; /* keys that were asked for */
    int known_count;
};

/* Opens a document whose root is an object. Syntax errors and duplicate keys name line and column. */
struct json_node json_open(const char *path, struct json_file *file, char error[static SCENE_ERROR]);
void json_close(struct json_file *file);

/* Refuses all keys of the object that nobody asked for. */
void json_end(struct json_node *at);

/* Records "file: path.key: sentence" unless an error stands already. `key` may be NULL: the node itself. */
void json_fail(const struct json_node *at, const char *key, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* True where the object has `key`; one that is never read is refused by json_end. */
bool json_has(const struct json_node *at, const char *key);
bool json_has_object(const struct json_node *at, const char *key);

/* All of these need the key to be there. Ranges are inclusive. */
struct json_node json_get_object(struct json_node *at, const char *key);
struct json_node json_get_list(struct json_node *at, const char *key);
size_t json_length(const struct json_node *list);
struct json_node json_get_item(const struct json_node *list, size_t i); /* an object */
/* A number that a float can hold; HUGE_VAL, -HUGE_VAL: no bound. */
double json_get_number(struct json_node *at, const char *key, double min, double max);
int json_get_integer(struct json_node *at, const char *key, int min, int max);
bool json_get_bool(struct json_node *at, const char *key);
/* `count` numbers that are at least `min`. */
void json_get_numbers(struct json_node *at, const char *key, double min, int count, float *out);
/* An index of one of `count` things called `what`; SCENE_NONE after an error. */
int json_get_index(struct json_node *at, const char *key, int count, const char *what);
/* A list of such indices, which the caller frees; *length of them. */
int *json_get_indices(struct json_node *at, const char *key, int count, const char *what, uint32_t *length);
/* The place of the text in `words`, which ends in NULL. */
int json_get_word(struct json_node *at, const char *key, const char *const *words);
/* A copy that the caller frees; NULL after an error. */
char *json_get_text(struct json_node *at, const char *key);
/* Zeroed memory for as many things of `size` bytes as the list has, with their count; NULL and 0 after an error. */
void *json_new_array(const struct json_node *list, size_t size, int *count);

#endif
