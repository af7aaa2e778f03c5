/* SPDX-License-Identifier: Apache-2.0 */
/* Checking what builds of command buffers have read, once they have executed. */
#ifndef ASSAY_CHECK_CONTENT_EXECUTED_H
#define ASSAY_CHECK_CONTENT_EXECUTED_H

#include "src/check/call/check.h"
#include "src/check/replay/update_inputs.h"
#include "src/snapshots/recorded_build.h"

/* One build of an execution. */
struct executed_build {
    const struct recorded_build *build;
    uint64_t dst_id;                       /* of its structure; 0 where it isn't known */
    struct input_memory memory;            /* what it read */
    struct build_inputs *inputs;           /* to be filled; NULL: nobody will ask */
    const struct used_micromap_note *used; /* the micromaps that its geometries use: */
    uint32_t used_count;
    const struct execution_point *point; /* of a build of instances; NULL: it isn't known */
};

/* The builds of one call, in the call's order; those of which nothing is known may be missing. */
struct executed_call;
struct executed_call *executed_call_begin(struct check_context *context,
                                          const struct device_facts *device,
                                          enum build_command command); /* NULL without memory */
void executed_call_read(struct executed_call *call, const struct executed_build *build);
/* Whether the end has more to do than to free it: it then calls down. */
bool executed_call_has_instances(const struct executed_call *call);
void executed_call_end(struct executed_call *call);

#endif
