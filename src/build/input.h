/* SPDX-License-Identifier: Apache-2.0 */
/* A build's input as a whole: its kind, and its geometries opened for reading. */
#ifndef ASSAY_BUILD_INPUT_H
#define ASSAY_BUILD_INPUT_H

#include "build/source.h"

/* BUILDER_UNKNOWN_FORMAT where types or formats are none that the builder takes. */
enum builder_result input_kind(const struct builder_input *input, enum structure_kind *kind);

/* What a refit needs: the sources, then what dense geometry has. */
static inline uint64_t refit_scratch(enum structure_kind kind, uint32_t geometries,
                                     uint32_t primitives)
{
    uint64_t dense = kind == STRUCTURE_DENSE ? primitives * sizeof(struct dense_triangle) : 0;
    return (uint64_t)geometries * sizeof(struct source) + dense;
}

/* One source a geometry; of dense geometry, all triangles to `dense`. A range that leads out of its
 * data is reported and an error. */
enum builder_result input_open(const struct builder_input *input, struct source *sources,
                               struct dense_triangle *dense, struct builder_report *report);

/* Whether any triangles have opacities, of which the structure then keeps the references. */
bool input_has_micromaps(const struct builder_input *input);
void input_write_micromaps(const struct builder_input *input, struct structure_header *header);

#endif
