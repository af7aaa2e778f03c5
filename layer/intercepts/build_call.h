/* SPDX-License-Identifier: Apache-2.0 */
/* State of one call of a build command, shared by the intercepts of these commands. */
#ifndef ASSAY_LAYER_INTERCEPTS_BUILD_CALL_H
#define ASSAY_LAYER_INTERCEPTS_BUILD_CALL_H

#include "layer/intercepts/call_sites.h"
#include "layer/layer.h"
#include "layer/physical_device.h"
#include "src/check/call/check.h"

struct build_call {
    struct layer_device *device;
    struct command_buffer *command_buffer; /* NULL for host builds and if no record exists */
    struct call_view view;
    struct journal *journal;             /* in which the builds are recorded; or NULL */
    const struct execution_point *point; /* of a host build, see struct check_context */
    struct hazard_entry *hazards; /* the call's HAZARD_COMMAND, with setting hazards; or NULL */
    bool skip;                    /* a callback asked to skip the call */
};

void build_call_start(struct build_call *call, struct layer_device *device,
                      enum build_command command);
/* Starts a call that is recorded in a command buffer; the handle may be invalid. */
void build_call_start_recorded(struct build_call *call, struct layer_device *device,
                               enum build_command command, VkCommandBuffer handle);

/* Reports that a build command was given a handle which is no command buffer. The report goes to
 * the device that the handle leads to, or else to any device. */
void build_call_report_command_buffer(enum build_command command, VkCommandBuffer handle);

/* Reports that a host command was given a handle which is no device. The report goes to any device.
 */
void build_call_report_device(enum build_command command, VkDevice handle);

/* For struct check_hooks; `user` is the call. */
bool build_call_found(void *user, enum rule rule, const struct location *location,
                      const struct finding *finding);
bool build_call_of_another_device(void *user, enum resource_kind kind, uint64_t handle);
static inline enum tristate build_call_vertex_format_supported(void *user, VkFormat format)
{
    return layer_vertex_format_supported(((struct build_call *)user)->device, format);
}
static inline enum tristate build_call_radius_format_supported(void *user, VkFormat format)
{
    return layer_radius_format_supported(((struct build_call *)user)->device, format);
}

/* For recorded calls: judges updates whose sources the command buffer has built itself. Then keeps
 * the call's journal entries, or removes them if the call will be skipped. Most journals have no
 * updates to judge. */
void build_call_settle_entries(struct build_call *call);
static inline void build_call_settle_journal(struct build_call *call)
{
    const struct command_buffer *command_buffer = call->command_buffer;
    if (command_buffer && call->journal &&
        (call->journal->has_sources_to_check || call->skip || command_buffer->has_known_states))
        build_call_settle_entries(call);
}

/* Returns the value of journal_entry.origin for the builds of the call. */
static inline uint32_t build_call_origin(const struct build_call *call)
{
    const struct command_buffer *command_buffer = call->command_buffer;
    return journal_note_origin(call->journal, command_buffer ? &command_buffer->labels : NULL,
                               call_site_of_call(call->device));
}

void build_call_count_builds(struct build_call *call, uint32_t count);

#endif
