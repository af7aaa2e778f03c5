/* SPDX-License-Identifier: Apache-2.0 */
/* What the reference builder makes of an input, and its primitives one by one. */
#ifndef ASSAY_COMPARE_REFERENCE_H
#define ASSAY_COMPARE_REFERENCE_H

#include "src/bvh/input/source.h"
#include "src/compare/input.h"
#include "src/snapshots/build_input.h"

/* Of triangles or of AABBs. */
struct reference {
    struct build_input input;
    struct source *sources; /* one a geometry; owned */
    uint32_t geometry_count;
    bool is_aabbs;
    uint64_t primitive_count; /* of all geometries */
    uint32_t most_primitives; /* of one geometry */
    void *structure;          /* owned */
    struct builder_report report;
};

/* Whether an input is of a kind that can be compared. */
bool reference_takes(const struct build_parameters *build);

/* VK_ERROR_FORMAT_NOT_SUPPORTED where the builder finds that it isn't whole. The copy must live as
 * long. Whatever was made is freed by reference_close(), also after a failure. */
VkResult reference_open(const struct input_copy *copy, struct reference *reference);
void reference_close(struct reference *reference);

enum source_state reference_triangle(const struct reference *reference, uint32_t geometry,
                                     uint32_t primitive, struct triangle_record *triangle);
enum source_state reference_aabb(const struct reference *reference, uint32_t geometry,
                                 uint32_t primitive, struct aabb_record *box);

#endif
