/* SPDX-License-Identifier: Apache-2.0 */
/* The caches of a picture as a file, to be used again: for the same picture, from another camera, with other exponents.
 *
 *     header | exponents and roughness they were made with | arrays of struct fill | checksum
 *
 * Native byte order and layout; the same caches give the same bytes. A file of another scene, other options, another
 * byte order or version of the format, and one that was damaged, is refused. Whatever its bytes, none is used before it
 * was checked: indices lie within their arrays, numbers are finite, normals unit.
 */
#ifndef RENDER_CACHE_FILE_H
#define RENDER_CACHE_FILE_H

#include "render/fill.h"

/* Writes under image_temporary's name, then renames. `hash`: scene_hash's. False and a sentence on failure; nothing is
 * left behind then. */
bool cache_file_write(const char *path, uint64_t hash, const struct scene *scene, const struct fill *fill,
                      char error[static SCENE_ERROR]);

/* How the scene differs from the one that the caches were made for. */
struct cache_file_change {
    bool camera, materials;
    char stale[SCENE_ERROR]; /* where materials: a sentence that says what is not right any more, without the path */
};

/* Reads what a scene of this hash can use under these options. False and one sentence that names what is wrong; *fill
 * is then empty. The caller frees *fill. */
bool cache_file_read(const char *path, uint64_t hash, const struct scene *scene, const struct fill_options *options,
                     struct fill *fill, struct cache_file_change *change, char error[static SCENE_ERROR]);

#endif
