/* SPDX-License-Identifier: Apache-2.0 */
/* A build's input as a whole: its kind, and its geometries opened for reading. */
#ifndef ASSAY_BVH_INPUT_INPUT_H
#define ASSAY_BVH_INPUT_INPUT_H

#include "src/bvh/input/displaced.h"

/* BUILDER_UNKNOWN_FORMAT where types or formats are none that the builder takes. */
enum builder_result input_kind(const struct builder_input *input, enum structure_kind *kind);

/* What each part of the scratch takes; `base` may be 0 to learn the size alone. */
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

/* By the ranges, or by `counts` where sizes are asked for; of displaced triangles, the most that
 * there may be. Primitives are what trees are made of. */
struct input_counts {
    uint64_t primitives;
    struct displaced_counts displaced;
};
enum builder_result input_count(const struct builder_input *input, enum structure_kind kind,
                                const uint32_t *counts, struct input_counts *found);

/* What is read before the build: one source a geometry, and what geometry that has to be decoded is
 * decoded to. */
struct input_tables {
    struct source *sources;
    struct dense_triangle *dense;
    struct displaced_room displaced;
};
/* Returns the bytes; `scratch` may be NULL to learn them alone. */
uint64_t input_lay_out(const struct builder_input *input, enum structure_kind kind,
                       const struct input_counts *counts, void *scratch,
                       struct input_tables *tables);

/* A range that leads out of its data is reported and an error. */
enum builder_result input_open(const struct builder_input *input, enum structure_kind kind,
                               const struct input_tables *tables, struct builder_report *report);

/* Whether any triangles have opacities, of which the structure then keeps the references. */
bool input_has_micromaps(const struct builder_input *input);
void input_write_micromaps(const struct builder_input *input, struct structure_header *header);

#endif
