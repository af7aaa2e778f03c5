/* SPDX-License-Identifier: Apache-2.0 */
/* What the predicates about advice get (vuid-tables/advice.def). */
#ifndef ASSAY_ADVICE_VIEWS_H
#define ASSAY_ADVICE_VIEWS_H

#include "src/advice/figures/indices.h"
#include "src/advice/figures/instances.h"
#include "src/advice/figures/layouts.h"
#include "src/advice/figures/triangles.h"
#include "src/advice/uses.h"
#include "src/state/facts.h"
#include "src/view/view.h"
#include "vuid-tables/advice.h"

/* A structure at the end of its life, or of the run. */
struct use_view {
    const struct accel_facts *accel;
    const struct structure_uses *uses;
    /* Number of submissions after the one of its first build, or of its copy; 0 if it has neither.
     */
    uint32_t lived;
    bool is_old;              /* it was there during the last `submissions` (a limit) submissions */
    bool is_left;             /* the device is destroyed before it */
    bool size_may_be_unknown; /* the application may have read compacted sizes unseen */
    bool
        references_are_known; /* all instances of all builds were read, and there are such builds */
    const struct advice_limits *limits;
};

/* A top-level structure when a command traces it. */
struct traced_view {
    uint64_t changed; /* handle of what an instance refers to and was written since; 0: none */
};

/* The tree of a structure after an update. */
struct tree_view {
    uint32_t geometry;  /* index of the one that was judged */
    uint32_t triangles; /* of it */
    double refit_cost;  /* compared with a new tree; 0: unknown */
    const struct advice_limits *limits;
};

/* All structures of a device. */
struct crowd_view {
    /* The most structures with few primitives (a limit) that were there at a time. */
    uint32_t tiny;
    uint32_t single_calls; /* the most that journal_find_single_calls() found */
    const struct advice_limits *limits;
};

/* ---- input data */

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
