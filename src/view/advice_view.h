/* SPDX-License-Identifier: Apache-2.0 */
/* What the predicates about advice get (vuid-tables/advice.def). */
#ifndef ASSAY_VIEW_ADVICE_VIEW_H
#define ASSAY_VIEW_ADVICE_VIEW_H

#include "src/state/builds/structures.h"
#include "src/state/facts.h"
#include "src/view/figures_view.h"
#include "vuid-tables/advice.h"

/* A structure at the end of its life, or of the run. */
struct use_view {
    const struct accel_facts *accel;
    const struct structure_uses *uses;
    /* Number of submissions after the one of its first build, or of its copy; 0 if it has neither.
     */
    uint32_t lived;
    bool is_old;            /* it was there during the last `submissions` (a limit) submissions */
    bool is_left;           /* the device is destroyed before it */
    bool may_know_its_size; /* the application may have read compacted sizes unseen */
    bool knows_references;  /* all instances of all builds were read, and there are such builds */
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

#endif
