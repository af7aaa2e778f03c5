/* SPDX-License-Identifier: Apache-2.0 */
/* What the reference builder makes of an input, and its primitives one by one. */
#ifndef ASSAY_COMPARE_REFERENCE_H
#define ASSAY_COMPARE_REFERENCE_H

#include "build/source.h"
#include "compare/input.h"
#include "snapshots/build_input.h"

/* Of triangles or of AABBs. */
struct reference {
    unsigned char *bytes; /* a copy of the input's, and where it is; owned */
    uint64_t size;
    struct build_parameters placed;
    struct input_memory memory;
    struct build_input input;
    struct source *sources; /* one a geometry; owned */
    uint32_t geometry_count;
    bool is_aabbs;
    uint64_t primitive_count; /* of all geometries */
    uint32_t most_primitives; /* of one geometry */
    void *structure;          /* owned */
    struct builder_report report;
};

/* VK_ERROR_FORMAT_NOT_SUPPORTED: an input of another kind, or of which not all is known. The
 * reference stays where it is. Whatever was made is freed by reference_close(), also after a
 * failure. */
VkResult reference_open(const struct compare_input *input, struct reference *reference);
void reference_close(struct reference *reference);

enum source_state reference_triangle(const struct reference *reference, uint32_t geometry,
                                     uint32_t primitive, struct triangle_record *triangle);
enum source_state reference_aabb(const struct reference *reference, uint32_t geometry,
                                 uint32_t primitive, struct aabb_record *box);

#endif
