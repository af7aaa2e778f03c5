/* SPDX-License-Identifier: Apache-2.0 */
/* The structures and memory ranges that a build call uses. */
#ifndef ASSAY_STATE_COMMANDS_USED_RANGE_H
#define ASSAY_STATE_COMMANDS_USED_RANGE_H

#include "src/state/facts.h"

/* The use that a call makes of a range. */
enum range_role { ROLE_DST, ROLE_SRC, ROLE_SCRATCH };

struct used_range {
    enum range_role role;
    uint32_t build;
    bool is_in_place;                  /* that build updates its dst in place */
    bool is_micromap;                  /* ROLE_SRC: a micromap that triangles use */
    bool is_instance;                  /* ROLE_SRC: a structure that an instance refers to */
    bool is_sparse;                    /* `span` is a piece of a sparse buffer */
    VkAccelerationStructureKHR handle; /* not for ROLE_SCRATCH */
    struct memory_span span;           /* memory null: compared by handle only */
};

/* A recorded range. The memory of a sparse buffer is only known at execution, so its bytes within
 * the buffer are recorded. */
struct noted_range {
    struct used_range range;
    struct sparse_bytes bytes; /* range.is_sparse */
};

/* All ranges of a call. */
struct noted_ranges {
    uint32_t count;
    uint32_t position; /* of the call's first build in the command buffer */
    struct noted_range items[];
};

#endif
