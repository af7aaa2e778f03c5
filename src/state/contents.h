/* SPDX-License-Identifier: Apache-2.0 */
/* What is kept of the data of a build that may be updated: which primitives were active, and the
 * indices. Kept at level CONTENT alone: a bit a primitive, and the bytes of the indices. */
#ifndef ASSAY_STATE_CONTENTS_H
#define ASSAY_STATE_CONTENTS_H

#include <stdatomic.h>
#include <stdint.h>

/* NULL where something isn't known, or isn't there. */
struct geometry_contents {
    uint32_t primitive_count;
    uint64_t *inactive; /* bit i of word i / 64: primitive 64 * (i / 64) + i % 64 */
    uint8_t *indices;
    uint64_t indices_size; /* bytes */
};

/* Immutable once the build was seen; freed with its last reference. */
struct build_contents {
    atomic_uint references;
    uint32_t count; /* of geometries */
    struct geometry_contents items[];
};

/* With one reference, all unknown; NULL without memory. */
struct build_contents *build_contents_create(uint32_t count);
struct build_contents *build_contents_share(struct build_contents *contents); /* may be NULL */
void build_contents_release(struct build_contents *contents);                 /* may be NULL */

#endif
