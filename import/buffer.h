/* SPDX-License-Identifier: Apache-2.0 */
/* scene.bin and the views into it: typed spans that were checked to lie inside. */
#ifndef IMPORT_BUFFER_H
#define IMPORT_BUFFER_H

#include <stdint.h>

#include "import/json.h"
#include "import/scene.h"

enum buffer_type { BUFFER_FLOAT, BUFFER_FLOAT2, BUFFER_FLOAT3, BUFFER_UINT, BUFFER_UINT2 };

struct buffer_view {
    size_t offset;  /* bytes, a multiple of 4 */
    uint32_t count; /* elements */
    enum buffer_type type;
};

struct buffer {
    const unsigned char *bytes; /* scene.buffer; 16-byte aligned */
    struct buffer_view *views;
    int view_count;
};

/* Reads the document's `buffer` into scene->buffer, which the scene owns, and its `views`. Errors go to the document.
 */
void buffer_read(struct json_node *root, const char *folder, struct scene *scene, struct buffer *buffer);
void buffer_free(struct buffer *buffer);

/* The span that at[key] names and the count of its elements; NULL and 0 after an error. Floats were checked to be
 * finite. `mesh` is a name for errors, or NULL. */
const void *buffer_span(const struct buffer *buffer, struct json_node *at, const char *key, enum buffer_type type,
                        const char *mesh, uint32_t *count);

#endif
