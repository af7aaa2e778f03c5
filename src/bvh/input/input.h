/* SPDX-License-Identifier: Apache-2.0 */
/* The input of a build as a whole: determines its kind and opens its geometries for reading. */
#ifndef ASSAY_BVH_INPUT_INPUT_H
#define ASSAY_BVH_INPUT_INPUT_H

#include "src/bvh/input/displaced.h"
#include "src/bvh/input/source.h"

/* Returns BUILDER_UNKNOWN_FORMAT if the builder does not support a type or format. */
enum builder_result input_kind(const struct builder_input *input, enum structure_kind *kind);

/* Assigns parts of the scratch. If `base` is 0, only `used`, the size in bytes, is valid. */
struct scratch_cursor {
    uintptr_t base;
    uint64_t used;
};
static inline void *scratch_take(struct scratch_cursor *cursor, uint64_t count, uint64_t size)
{
    uint64_t at = cursor->used;
    cursor->used += (count * size + BUILDER_ALIGNMENT - 1) & ~(uint64_t)(BUILDER_ALIGNMENT - 1);
    return cursor->base ? (void *)(cursor->base + at) : NULL; // NOLINT(performance-no-int-to-ptr)
}

/* Counts from the ranges, or from `counts` for a size query. For displaced triangles the count is
 * the maximum. Primitives are the primitives of the tree. */
struct input_counts {
    uint64_t primitives;
    struct displaced_counts displaced;
};
enum builder_result input_count(const struct builder_input *input, enum structure_kind kind,
                                const uint32_t *counts, struct input_counts *found);

/* The data that is read before the build: one source per geometry, and decoded geometry. */
struct input_tables {
    struct source *sources;
    struct dense_triangle *dense;
    struct displaced_room displaced;
};
/* Lays out the tables in the scratch. Returns the size in bytes. `scratch` may be NULL to query the
 * size. */
uint64_t input_lay_out(const struct builder_input *input, enum structure_kind kind,
                       const struct input_counts *counts, void *scratch,
                       struct input_tables *tables);

/* Opens all geometries. Reports a range that exceeds its data and returns an error. */
enum builder_result input_open(const struct builder_input *input, enum structure_kind kind,
                               const struct input_tables *tables, struct builder_report *report);

/* Returns whether any triangles have opacities; the structure then stores the micromap
 * references. */
bool input_has_micromaps(const struct builder_input *input);
void input_write_micromaps(const struct builder_input *input, struct structure_header *header);

/* ---- decodes dense geometry (VK_AMDX_dense_geometry_format, "Dense Geometry Format Version 1") */

/* Decodes the triangles of the blocks in order into `count` elements. Marks missing and malformed
 * triangles in `found`. */
void dense_decode(const struct builder_dense *dense, uint32_t count, struct dense_triangle *to);

#endif
