/* SPDX-License-Identifier: Apache-2.0 */
/* The input of a build to be compared: the parameters of the application, and the memory that they
 * refer to. */
#ifndef ASSAY_COMPARE_INPUT_H
#define ASSAY_COMPARE_INPUT_H

#include "src/bvh/input/source.h"
#include "src/model/build_parameters.h"
#include "src/snapshots/build_input.h"
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

/* ---- the reference structure of an input, and access to the input's primitives */

/* The reference for an input of triangles or of AABBs. */
struct reference {
    struct build_input input;
    struct source *sources; /* one per geometry; owned */
    uint32_t geometry_count;
    bool is_aabbs;
    uint64_t primitive_count; /* sum over all geometries */
    uint32_t most_primitives; /* maximum over all geometries */
    void *structure;          /* owned */
    struct builder_report report;
};

/* Returns whether inputs of this kind can be compared. */
bool reference_supports(const struct build_parameters *build);

/* Builds the reference of `copy`, which must outlive it. Returns VK_ERROR_FORMAT_NOT_SUPPORTED if
 * the builder rejects the input. The caller calls reference_close(), also after a failure. */
VkResult reference_open(const struct input_copy *copy, struct reference *reference);
void reference_close(struct reference *reference);

/* Read a primitive of the input. */
enum source_state reference_triangle(const struct reference *reference, uint32_t geometry,
                                     uint32_t primitive, struct triangle_record *triangle);
enum source_state reference_aabb(const struct reference *reference, uint32_t geometry,
                                 uint32_t primitive, struct aabb_record *box);

#endif
