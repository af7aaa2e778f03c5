/* SPDX-License-Identifier: Apache-2.0 */
/* The structures and memory ranges that a build call uses. */
#ifndef ASSAY_STATE_COMMANDS_USED_RANGE_H
#define ASSAY_STATE_COMMANDS_USED_RANGE_H

#include "src/state/facts.h"

/* What a range of memory is to the call. */
enum range_role { ROLE_DST, ROLE_SRC, ROLE_SCRATCH };

struct used_range {
    enum range_role role;
    uint32_t build;
    bool is_update;                    /* mode of that build */
    bool is_micromap;                  /* ROLE_SRC: what triangles use, not what is updated, */
    bool is_instance;                  /* or what an instance refers to */
    bool is_sparse;                    /* `span` is a piece of a sparse buffer */
    VkAccelerationStructureKHR handle; /* not for ROLE_SCRATCH */
    struct memory_span span;           /* memory null: compared by handle only */
};

/* A range as it was recorded; of a sparse buffer only its bytes are known by then. */
struct noted_range {
    struct used_range range;
    struct sparse_bytes bytes; /* range.is_sparse */
};

/* All of a call. */
struct noted_ranges {
    uint32_t count;
    uint32_t position; /* of the call's first build in the command buffer */
    struct noted_range items[];
};

#endif
