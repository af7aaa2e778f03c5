/* SPDX-License-Identifier: Apache-2.0 */
/* The reference structure of an input, and access to the input's primitives. */
#ifndef ASSAY_COMPARE_REFERENCE_H
#define ASSAY_COMPARE_REFERENCE_H

#include "src/bvh/input/source.h"
#include "src/compare/input.h"
#include "src/snapshots/build_input.h"

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
