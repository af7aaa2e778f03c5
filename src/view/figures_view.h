/* SPDX-License-Identifier: Apache-2.0 */
/* What the predicates about input data get (vuid-tables/advice.def). */
#ifndef ASSAY_VIEW_FIGURES_VIEW_H
#define ASSAY_VIEW_FIGURES_VIEW_H

#include "src/figures/indices.h"
#include "src/figures/instances.h"
#include "src/figures/layouts.h"
#include "src/figures/triangles.h"
#include "src/view/view.h"
#include "vuid-tables/advice.h"

/* A geometry of triangles that has been read. */
struct mesh_view {
    const struct geometry_view *geometry;
    const struct advice_limits *limits;
    const struct triangle_figures *figures;
    uint32_t index_size;               /* in bytes; 0: no indices */
    const struct other_indices *other; /* another size suits the indices; or NULL */
    const struct stray_vertex *stray;  /* or NULL */
    const struct other_stride *smooth; /* or NULL */
    const struct vertex_layout *layout, *contradicting; /* its own, and one before; or both NULL */
};

/* The instances of a build without motion. */
struct placing_view {
    const struct geometry_view *geometry;
    const struct advice_limits *limits;
    const struct instance_figures *figures;
};

#endif
