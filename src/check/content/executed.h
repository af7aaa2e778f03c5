/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the input data of device builds after they have executed. */
#ifndef ASSAY_CHECK_CONTENT_EXECUTED_H
#define ASSAY_CHECK_CONTENT_EXECUTED_H

#include "src/check/call/check.h"
#include "src/check/replay/update_inputs.h"
#include "src/snapshots/recorded_build.h"

/* One build of one execution. */
struct executed_build {
    const struct recorded_build *build;
    uint64_t dst_id;                          /* of the dst structure; 0 if unknown */
    struct input_memory memory;               /* the input data it read */
    struct build_inputs *inputs;              /* filled for later updates; NULL: not needed */
    const struct build_inputs *source_inputs; /* of an update; NULL: not needed, or unknown */
    const struct used_micromap_note *used;    /* the micromaps that its geometries use */
    uint32_t used_count;
    uint64_t place;                      /* of a build at addresses: see places_execute() */
    uint32_t number;                     /* of such a build in its command buffer */
    struct build_reader *readers;        /* the caller ends them; NULL: none */
    const struct execution_point *point; /* of a build of instances; NULL: unknown */
};

/* The builds of one call, in the call's order. Builds of unknown structures may be missing. */
struct executed_call;
/* Begins a call. The caller ends it with executed_call_end(). Returns NULL if there is no
 * memory. */
struct executed_call *executed_call_begin(struct check_context *context,
                                          const struct device_facts *device,
                                          enum build_command command);
/* Validates the input data of one build of the call. */
void executed_call_read(struct executed_call *call, const struct executed_build *build);
/* Returns whether executed_call_end() calls down, so that the caller may hold no lock. */
bool executed_call_ends_unlocked(const struct executed_call *call);
/* Validates the pairs of builds and instances, and serialized data, then frees the call. */
void executed_call_end(struct executed_call *call);

#endif
