/* SPDX-License-Identifier: Apache-2.0 */
/* The input of a build that is compared: what the application asked for, and the bytes that it
 * named. */
#ifndef ASSAY_COMPARE_INPUT_H
#define ASSAY_COMPARE_INPUT_H

#include "src/snapshots/build_parameters.h"
#include "src/snapshots/memory.h"

/* The parameters are as the application gave them, ranges not added to addresses; `memory` has the
 * bytes at the addresses that the build reads. */
struct compare_input {
    const struct build_parameters *parameters;
    const struct input_memory *memory;
};

/* The same input at other addresses: the arrays one after the other, each as far from a multiple of
 * COMPARE_ALIGNMENT as before, the bytes before and after what is read zero. */
#define COMPARE_ALIGNMENT 256u

/* How many bytes that takes; UINT64_MAX where some of the input isn't known, or is more than
 * COMPARE_INPUT_MAX. */
#define COMPARE_INPUT_MAX ((uint64_t)256 << 20)
uint64_t compare_input_size(const struct compare_input *input);

/* Fills `bytes`, which are zero and at `address`, a multiple of COMPARE_ALIGNMENT, and `geometries`
 * (as many as the build has) with where everything is. */
void compare_input_place(const struct compare_input *input, uint64_t address, unsigned char *bytes,
                         VkAccelerationStructureGeometryKHR *geometries);

/* An input that was placed in memory of its own, and stays where it is. */
struct input_copy {
    struct compare_input input; /* of what follows */
    struct build_parameters parameters;
    struct input_memory memory;
    unsigned char *bytes;
    uint64_t size;
};
/* NULL without memory, or where compare_input_size() is UINT64_MAX. */
struct input_copy *input_copy_create(const struct compare_input *input);
void input_copy_free(struct input_copy *copy); /* NULL: nothing */

#endif
