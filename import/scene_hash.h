/* SPDX-License-Identifier: Apache-2.0 */
/* One number for all of a scene that a cache of its light depends on and can't outlive a change of. */
#ifndef IMPORT_SCENE_HASH_H
#define IMPORT_SCENE_HASH_H

#include <string.h>

#include "import/scene.h"

/* Takes so many bytes into a hash, eight at a time: any change within one such word changes the result. */
static inline uint64_t scene_hash_bytes(uint64_t hash, const void *bytes, size_t count)
{
    hash ^= count;
    for (size_t i = 0; i < count; i += 8) {
        uint64_t word = 0;
        memcpy(&word, (const char *)bytes + i, count - i < 8 ? count - i : 8);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return hash;
}

/* Hashes the folder's scene.json, the buffer of the scene that was read from it, and the bytes of its images. Left out:
 * the camera, notes and generator, the order of keys, and the exponent and roughness of materials, with which a cache
 * may be used again (render/cache_file.h). False and a sentence where a file can't be read. */
bool scene_hash(const char *folder, const struct scene *scene, uint64_t *hash, char error[SCENE_ERROR]);

#endif
