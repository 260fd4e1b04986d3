/* SPDX-License-Identifier: Apache-2.0 */
#include "import/json.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Appends to the text in `buffer`; cuts what doesn't fit. */
static void append(char *buffer, size_t bytes, const char *format, ...) __attribute__((format(printf, 3, 4)));

static void append(char *buffer, size_t bytes, const char *format, ...)
{
    size_t used = strlen(buffer);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(buffer + used, bytes - used, format, arguments);
    va_end(arguments);
}

static void append_path(const struct json_node *at, char *buffer, size_t bytes)
{
    if (!at->parent) return;
    append_path(at->parent, buffer, bytes);
    if (at->key) append(buffer, bytes, at->parent->parent ? ".%s" : "%s", at->key);
    else append(buffer, bytes, "[%zu]", at->index);
}

/* An error is one line, whatever the document has in it. */
static void blank_control_characters(char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < ' ') *text = ' ';
}

void json_fail(const struct json_node *at, const char *key, const char *format, ...)
{
    struct json_file *file = at->file;
    if (file->failed) return;
    file->failed = true;
    snprintf(file->error, SCENE_ERROR, "%s: ", file->path);
    append_path(at, file->error, SCENE_ERROR);
    if (key) append(file->error, SCENE_ERROR, at->parent ? ".%s" : "%s", key);
    if (key || at->parent) append(file->error, SCENE_ERROR, ": ");
    size_t used = strlen(file->error);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(file->error + used, SCENE_ERROR - used, format, arguments);
    va_end(arguments);
    blank_control_characters(file->error);
}

/* What a value is, in a few words. */
static const char *describe(const json_t *value, char text[static 80])
{
    switch (value ? json_typeof(value) : JSON_NULL) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: snprintf(text, 80, "a list of %zu", json_array_size(value)); return text;
    case JSON_STRING: snprintf(text, 80, "\"%.60s\"", json_string_value(value)); return text;
    case JSON_INTEGER: snprintf(text, 80, "%" JSON_INTEGER_FORMAT, json_integer_value(value)); return text;
    case JSON_REAL: snprintf(text, 80, "%.9g", json_real_value(value)); return text;
    case JSON_TRUE: return "true";
    case JSON_FALSE: return "false";
    case JSON_NULL: break;
    }
    return value ? "null" : "nothing";
}

static void fail_expected(const struct json_node *at, const char *key, const json_t *value, const char *expected)
{
    char text[80];
    json_fail(at, key, "found %s, expected %s", describe(value, text), expected);
}

struct json_node json_open(const char *path, struct json_file *file, char error[static SCENE_ERROR])
{
    *file = (struct json_file){.path = path, .error = error};
    struct json_node root = {.file = file};
    FILE *stream = fopen(path, "rb");
    if (!stream) {
        json_fail(&root, NULL, "cannot be opened: %s", strerror(errno));
        return root;
    }
    json_error_t where;
    file->root = json_loadf(stream, JSON_REJECT_DUPLICATES, &where);
    fclose(stream);
    if (!file->root) {
        file->failed = true;
        snprintf(error, SCENE_ERROR, "%s:%d:%d: %s", path, where.line, where.column, where.text);
        blank_control_characters(error);
    } else if (!json_is_object(file->root)) {
        fail_expected(&root, NULL, file->root, "an object");
    } else {
        root.value = file->root;
    }
    return root;
}

void json_close(struct json_file *file)
{
    json_decref(file->root);
    file->root = NULL;
}

void json_end(struct json_node *at)
{
    const char *key;
    json_t *value;
    json_object_foreach(at->value, key, value)
    {
        bool known = false;
        for (int i = 0; i < at->known_count && !known; i++) known = !strcmp(at->known[i], key);
        if (!known) {
            json_fail(at, key, "unknown key");
            return;
        }
    }
}

bool json_has(const struct json_node *at, const char *key) { return json_object_get(at->value, key) != NULL; }

bool json_has_object(const struct json_node *at, const char *key)
{
    return json_is_object(json_object_get(at->value, key));
}

/* The value of a key, noted as known. NULL after an error. */
static json_t *find(struct json_node *at, const char *key)
{
    bool known = false;
    for (int i = 0; i < at->known_count && !known; i++) known = !strcmp(at->known[i], key);
    if (!known && at->known_count < JSON_KEYS) at->known[at->known_count++] = key;
    return at->file->failed ? NULL : json_object_get(at->value, key);
}

struct json_node json_get_object(struct json_node *at, const char *key)
{
    json_t *value = find(at, key);
    if (!json_is_object(value)) {
        fail_expected(at, key, value, "an object");
        value = NULL;
    }
    return (struct json_node){.file = at->file, .value = value, .parent = at, .key = key};
}

struct json_node json_get_list(struct json_node *at, const char *key)
{
    json_t *value = find(at, key);
    if (!json_is_array(value)) {
        fail_expected(at, key, value, "a list");
        value = NULL;
    }
    return (struct json_node){.file = at->file, .value = value, .parent = at, .key = key};
}

size_t json_length(const struct json_node *list) { return list->file->failed ? 0 : json_array_size(list->value); }

struct json_node json_get_item(const struct json_node *list, size_t i)
{
    struct json_node item = {.file = list->file, .value = json_array_get(list->value, i), .parent = list, .index = i};
    if (!json_is_object(item.value)) {
        fail_expected(&item, NULL, item.value, "an object");
        item.value = NULL;
    }
    return item;
}

double json_get_number(struct json_node *at, const char *key, double min, double max)
{
    json_t *value = find(at, key);
    double number = json_number_value(value);
    if (json_is_number(value) && isfinite((float)number) && number >= min && number <= max) return number;
    char expected[120];
    if (min == -HUGE_VAL) snprintf(expected, sizeof expected, "a number");
    else if (max == HUGE_VAL) snprintf(expected, sizeof expected, "a number of at least %g", min);
    else snprintf(expected, sizeof expected, "a number from %g to %g", min, max);
    fail_expected(at, key, value, expected);
    return 0;
}

int json_get_integer(struct json_node *at, const char *key, int min, int max)
{
    json_t *value = find(at, key);
    json_int_t number = json_integer_value(value);
    if (json_is_integer(value) && number >= min && number <= max) return (int)number;
    char expected[120];
    snprintf(expected, sizeof expected, min == max ? "%d" : "a whole number from %d to %d", min, max);
    fail_expected(at, key, value, expected);
    return 0;
}

bool json_get_bool(struct json_node *at, const char *key)
{
    json_t *value = find(at, key);
    if (!json_is_boolean(value)) fail_expected(at, key, value, "true or false");
    return json_is_true(value);
}

void json_get_numbers(struct json_node *at, const char *key, double min, int count, float *out)
{
    memset(out, 0, count * sizeof *out);
    json_t *value = find(at, key);
    char expected[120];
    if (min == -HUGE_VAL) snprintf(expected, sizeof expected, "%d numbers", count);
    else snprintf(expected, sizeof expected, "%d numbers of at least %g", count, min);
    if (!json_is_array(value) || json_array_size(value) != (size_t)count) {
        fail_expected(at, key, value, expected);
        return;
    }
    for (int i = 0; i < count && !at->file->failed; i++) {
        json_t *item = json_array_get(value, i);
        char text[80];
        out[i] = (float)json_number_value(item);
        if (!json_is_number(item) || !isfinite(out[i]) || json_number_value(item) < min)
            json_fail(at, key, "number %d is %s, expected %s", i, describe(item, text), expected);
    }
}

static int checked_index(const struct json_node *at, const char *key, const json_t *value, int count, const char *what)
{
    json_int_t number = json_integer_value(value);
    if (json_is_integer(value) && number >= 0 && number < count) return (int)number;
    char text[80];
    json_fail(at, key, "found %s, expected the index of one of %d %s", describe(value, text), count, what);
    return SCENE_NONE;
}

int json_get_index(struct json_node *at, const char *key, int count, const char *what)
{
    return checked_index(at, key, find(at, key), count, what);
}

int *json_get_indices(struct json_node *at, const char *key, int count, const char *what, uint32_t *length)
{
    *length = 0;
    struct json_node list = json_get_list(at, key);
    int n = 0;
    int *indices = json_new_array(&list, sizeof *indices, &n);
    for (int i = 0; i < n; i++) {
        struct json_node item = {.file = at->file, .parent = &list, .index = i};
        indices[i] = checked_index(&item, NULL, json_array_get(list.value, i), count, what);
    }
    *length = n;
    return indices;
}

int json_get_word(struct json_node *at, const char *key, const char *const *words)
{
    json_t *value = find(at, key);
    char expected[200] = "";
    for (int i = 0; words[i]; i++) {
        if (json_is_string(value) && !strcmp(json_string_value(value), words[i])) return i;
        append(expected, sizeof expected, "%s\"%s\"", !i ? "" : words[i + 1] ? ", " : " or ", words[i]);
    }
    fail_expected(at, key, value, expected);
    return 0;
}

char *json_get_text(struct json_node *at, const char *key)
{
    json_t *value = find(at, key);
    if (!json_is_string(value)) {
        fail_expected(at, key, value, "a text");
        return NULL;
    }
    char *copy = strdup(json_string_value(value));
    if (!copy) json_fail(at, key, "out of memory");
    return copy;
}

void *json_new_array(const struct json_node *list, size_t size, int *count)
{
    size_t length = json_length(list);
    *count = 0;
    if (length > INT_MAX) {
        json_fail(list, NULL, "found %zu things, expected at most %d", length, INT_MAX);
        return NULL;
    }
    void *array = calloc(length + 1, size);
    if (array) *count = (int)length;
    else json_fail(list, NULL, "out of memory");
    return array;
}
