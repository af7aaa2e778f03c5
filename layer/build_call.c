/* SPDX-License-Identifier: Apache-2.0 */
/* What the intercepts of the build commands share. */
#include "build_call.h"

#include "check/replay.h"

struct build_call build_call_start(struct layer_device *device, enum build_command command)
{
    return (struct build_call){
        .device = device,
        .origin = {.device = device->handle, .names = device->names},
        .view = {.command = command, .device = &device->facts},
    };
}

void build_call_set_command_buffer(struct build_call *call, VkCommandBuffer handle)
{
    struct layer_device *device = call->device;
    call->command_buffer = command_buffers_find(device->command_buffers, handle);
    call->view.command_buffer =
        command_buffers_facts(device->command_buffers, call->command_buffer, handle);
    call->origin.command_buffer = handle;
    call->origin.build_index = call->view.command_buffer.build_index;
    call->origin.labels = call->command_buffer ? &call->command_buffer->labels : NULL;
    call->recent_sizes = call->command_buffer ? &call->command_buffer->sizes : NULL;
    if (call->command_buffer && device->level >= LEVEL_EXECUTION)
        call->journal = call->command_buffer->journal;
}

bool build_call_found(void *user, enum rule rule, const struct location *location,
                      const struct finding *finding)
{
    struct build_call *call = user;
    struct reporter *reporter = call->device->instance->reporter;
    if (reporter_send(reporter, rule, location, &call->origin, finding))
        call->skip = true;
    return reporter_wants(reporter, rule_infos[rule].vuid[location->command]);
}

bool build_call_of_another_device(void *user, enum resource_kind kind, uint64_t handle)
{
    return layer_other_device_has(((struct build_call *)user)->device, kind, handle);
}

/* ---- the journal */

bool build_call_begin_journal(struct build_call *call)
{
    if (!call->command_buffer || !call->journal)
        return false;
    call->mark = journal_mark(call->journal);
    return true;
}

static void locate(void *user, const struct journal *journal, uint32_t position, uint32_t info)
{
    struct build_call *call = user;
    (void)journal;
    (void)position;
    (void)info;
    call->origin.build_index = call->view.command_buffer.build_index;
}

static struct replay replay_of(struct build_call *call)
{
    return (struct replay){
        .active = call->device->active_rules,
        .resources = call->device->resources,
        .locate = locate,
        .found = build_call_found,
        .user = call,
    };
}

void build_call_settle_journal(struct build_call *call)
{
    struct command_buffer *command_buffer = call->command_buffer;
    if (call->journal->asks) {
        struct replay replay = replay_of(call);
        replay_recorded(&replay, command_buffer, &call->mark);
    }
    if (call->skip)
        journal_take_back(call->journal, &call->mark);
    else
        replay_keep(command_buffer, &call->mark);
}

void build_call_count_builds(struct build_call *call, uint32_t count)
{
    if (call->command_buffer)
        call->command_buffer->build_count += count;
}
