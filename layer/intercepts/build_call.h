/* SPDX-License-Identifier: Apache-2.0 */
/* One call of a build command on its way through the checks: what its intercepts share. */
#ifndef ASSAY_LAYER_INTERCEPTS_BUILD_CALL_H
#define ASSAY_LAYER_INTERCEPTS_BUILD_CALL_H

#include "layer/layer.h"
#include "src/check/call/check.h"

struct build_call {
    struct layer_device *device;
    struct command_buffer *command_buffer; /* NULL for host builds, and where it isn't known */
    struct call_view view;
    struct journal *journal;               /* that the call's builds are noted in, or NULL */
    struct previous_shape *previous_shape; /* or NULL */
    const struct execution_point *point;   /* of the host's, see struct check_context */
    struct journal_mark mark;              /* before its entries, of one that is recorded */
    bool skip;                             /* a callback asked to skip the call */
};

void build_call_start(struct build_call *call, struct layer_device *device,
                      enum build_command command);
/* The same of a call that is recorded in a command buffer, whatever the handle is. */
void build_call_start_recorded(struct build_call *call, struct layer_device *device,
                               enum build_command command, VkCommandBuffer handle);

/* Reports a handle that is no command buffer, which a build command was given, in the name of the
 * device that the handle leads to, or of any device. */
void build_call_report_command_buffer(enum build_command command, VkCommandBuffer handle);

/* Reports a handle that leads to no device, which the host command was given, in the name of any
 * device. */
void build_call_report_device(VkDevice handle);

/* For struct check_hooks; `user` is the call. */
bool build_call_found(void *user, enum rule rule, const struct location *location,
                      const struct finding *finding);
bool build_call_of_another_device(void *user, enum resource_kind kind, uint64_t handle);

/* Of what is recorded: judges updates whose sources the command buffer has built itself, and keeps
 * the call's entries, or takes them back if the call will be skipped. */
void build_call_settle_journal(struct build_call *call);

void build_call_count_builds(struct build_call *call, uint32_t count);

#endif
