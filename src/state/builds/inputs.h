/* SPDX-License-Identifier: Apache-2.0 */
/* The inputs of a build that are kept for later updates: for each geometry the number of
 * primitives, which of them were inactive, and the indices. Kept at level CONTENT only. Takes one
 * bit for each primitive, and the bytes of the indices.
 *
 * The inputs of a host build are known during the call. For a device build, each execution has its
 * own inputs, which are attached to the live states when the build executes, and filled when the
 * execution has completed. */
#ifndef ASSAY_STATE_BUILDS_INPUTS_H
#define ASSAY_STATE_BUILDS_INPUTS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

/* The indices of a geometry. An update with the same indices shares those of its source. */
struct kept_indices {
    atomic_uint references;
    uint32_t max;  /* the largest index */
    uint64_t size; /* in bytes */
    uint8_t bytes[];
};

/* Members are NULL if unknown or absent. */
struct geometry_inputs {
    bool count_known;
    uint32_t primitive_count;
    uint64_t *inactive; /* bit i of word i / 64: primitive 64 * (i / 64) + i % 64 */
    struct kept_indices *indices;
};

/* The reader of the data fills the items and then calls build_inputs_mark_known(); from then on
 * they are immutable. Freed with the last reference. */
struct build_inputs {
    atomic_uint references;
    atomic_bool is_known;
    const void *filler; /* the object that will fill the items, set and compared by the filler only;
                         * NULL: not known yet */
    uint32_t count;     /* number of geometries */
    struct geometry_inputs items[];
};

/* Returns unknown inputs with one reference, or NULL if there is no memory. */
struct build_inputs *build_inputs_create(uint32_t count);
struct build_inputs *build_inputs_share(struct build_inputs *inputs); /* may be NULL */
void build_inputs_release(struct build_inputs *inputs);               /* may be NULL */

/* Returns a copy with one reference, or NULL if there is no memory. */
struct kept_indices *kept_indices_create(const void *bytes, uint64_t size, uint32_t max);
struct kept_indices *kept_indices_share(struct kept_indices *indices);

/* Called when the items are complete and will not change. */
void build_inputs_mark_known(struct build_inputs *inputs); /* may be NULL */
/* Returns the inputs of a geometry, or NULL if they are unknown. `inputs` may be NULL. */
const struct geometry_inputs *build_inputs_of(const struct build_inputs *inputs, uint32_t geometry);

#endif
