/* SPDX-License-Identifier: Apache-2.0 */
/* The input of a build to be compared: the parameters of the application, and the memory that they
 * refer to. */
#ifndef ASSAY_COMPARE_INPUT_H
#define ASSAY_COMPARE_INPUT_H

#include "src/snapshots/build_parameters.h"
#include "src/snapshots/memory.h"

/* `parameters` are the application's; addresses do not include the ranges. `memory` provides the
 * bytes that the build reads at those addresses. */
struct compare_input {
    const struct build_parameters *parameters;
    const struct input_memory *memory;
};

/* The layout of a moved input: the arrays in sequence. Each array keeps its offset from a multiple
 * of COMPARE_ALIGNMENT. The bytes around the data that the build reads are zero. */
#define COMPARE_ALIGNMENT 256u

/* Returns the size of the moved input in bytes. Returns UINT64_MAX if some of the input is unknown
 * or the size exceeds COMPARE_INPUT_MAX. */
#define COMPARE_INPUT_MAX ((uint64_t)256 << 20)
uint64_t compare_input_size(const struct compare_input *input);

/* Moves the input to `bytes`, which must be zero and whose address `address` must be a multiple of
 * COMPARE_ALIGNMENT. Fills `geometries`, one per geometry of the build, with the new addresses. */
void compare_input_place(const struct compare_input *input, uint64_t address, unsigned char *bytes,
                         VkAccelerationStructureGeometryKHR *geometries);

/* A moved input with memory of its own. It must not be moved in memory. */
struct input_copy {
    struct compare_input input; /* refers to the members below */
    struct build_parameters parameters;
    struct input_memory memory;
    unsigned char *bytes;
    uint64_t size;
};
/* Returns NULL if memory runs out or compare_input_size() returns UINT64_MAX. The caller frees the
 * copy with input_copy_free(). */
struct input_copy *input_copy_create(const struct compare_input *input);
void input_copy_free(struct input_copy *copy); /* `copy` may be NULL */

#endif
