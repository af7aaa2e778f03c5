/* SPDX-License-Identifier: Apache-2.0 */
/* What is kept of the data of a build that may be updated: how many primitives it has, which of
 * them were active, and the indices. Kept at level CONTENT alone: a bit a primitive, and the bytes
 * of the indices.
 *
 * Of a build of the host it is known at the call; of one in a command buffer each execution has its
 * own, which is attached to the live states when its turn comes and filled once it is complete. */
#ifndef ASSAY_STATE_BUILDS_INPUTS_H
#define ASSAY_STATE_BUILDS_INPUTS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

/* NULL where something isn't known, or isn't there. */
struct geometry_inputs {
    bool count_known;
    uint32_t primitive_count;
    uint64_t *inactive; /* bit i of word i / 64: primitive 64 * (i / 64) + i % 64 */
    uint8_t *indices;
    uint64_t indices_size; /* bytes */
};

/* Whoever reads the data fills it, and then says that it is known: from then on it is immutable.
 * Freed with its last reference. */
struct build_inputs {
    atomic_uint references;
    atomic_bool is_known;
    const void *filler; /* what will fill it, for who does; NULL: not known yet */
    uint32_t count;     /* of geometries */
    struct geometry_inputs items[];
};

/* With one reference, all unknown; NULL without memory. */
struct build_inputs *build_inputs_create(uint32_t count);
struct build_inputs *build_inputs_share(struct build_inputs *inputs); /* may be NULL */
void build_inputs_release(struct build_inputs *inputs);               /* may be NULL */

/* The items don't change any more. */
void build_inputs_mark_known(struct build_inputs *inputs); /* may be NULL */
/* Those of a geometry; NULL where they aren't known. `contents` may be NULL. */
const struct geometry_inputs *build_inputs_of(const struct build_inputs *inputs, uint32_t geometry);

#endif
