/* SPDX-License-Identifier: Apache-2.0 */
/* Shared by the intercepts of the build commands. */
#include "layer/intercepts/intercepts.h"

#include "src/base/clear.h"
#include "src/check/replay/replay.h"

void build_call_start(struct build_call *call, struct layer_device *device,
                      enum build_command command)
{
    clear_words(call, sizeof(*call));
    call->device = device;
    call->view.command = command;
    call->view.device = &device->facts;
}

void build_call_start_recorded(struct build_call *call, struct layer_device *device,
                               enum build_command command, VkCommandBuffer handle)
{
    struct command_buffers *all = device->command_buffers;
    struct command_buffer *command_buffer = command_buffers_find(all, handle);
    build_call_start(call, device, command);
    command_buffers_facts(all, command_buffer, handle, &call->view.command_buffer);
    if (!command_buffer)
        return;
    call->command_buffer = command_buffer;
    if (!command_buffer->journal)
        return;
    journal_begin_call(command_buffer->journal);
    if (device->level >= LEVEL_EXECUTION)
        call->journal = command_buffer->journal;
}

static struct call_origin origin_of(const struct build_call *call)
{
    struct call_origin origin = layer_origin(call->device);
    origin.command_buffer = call->view.command_buffer.handle;
    origin.build_index = call->view.command_buffer.build_index;
    origin.labels = call->command_buffer ? &call->command_buffer->labels : NULL;
    origin.call_site = call_site_of_thread();
    return origin;
}

/* Reports a finding. Returns whether a callback asks to skip the call. */
static bool send_finding(const struct build_call *call, enum rule rule,
                         const struct location *location, const struct finding *finding)
{
    const struct call_origin origin = origin_of(call);
    return reporter_send(call->device->instance->reporter, rule, location, &origin, finding);
}

/* The same for a query of sizes that another layer may have made. What was reported lately is not
 * repeated. */
static bool send_about_query(const struct build_call *call, enum rule rule,
                             const struct location *location, const struct finding *finding)
{
    struct reported_queries *told = &call->device->reported_queries;
    const uint64_t query = reported_query(rule, location, finding, call_site_of_thread()),
                   known = reported_queries_find(told, query);
    if (known)
        return known & REPORTED_SKIPS;
    const bool skips = send_finding(call, rule, location, finding);
    reported_queries_add(told, query | (skips ? REPORTED_SKIPS : 0));
    return skips;
}

bool build_call_found(void *user, enum rule rule, const struct location *location,
                      const struct finding *finding)
{
    struct build_call *call = user;
    const bool may_repeat = location->command == COMMAND_GetAccelerationStructureBuildSizesKHR &&
                            call->device->instance->is_below_layer;
    call->has_found = true;
    call->skip |= (may_repeat ? send_about_query : send_finding)(call, rule, location, finding);
    return reporter_wants(call->device->instance->reporter,
                          rule_infos[rule].vuid[location->command]);
}

/* Evaluates one rule of the call alone. */
static void check_one_rule(struct build_call *call, enum rule rule)
{
    static const struct check_hooks hooks = {.found = build_call_found};
    bool active[RULE_COUNT] = {false};
    active[rule] = call->device->active_rules[call->view.command][rule];
    struct check_context context = {.hooks = &hooks, .user = call, .active = active};
    check_call(&context, &call->view);
}

void build_call_report_command_buffer(enum build_command command, VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_reporting_device(handle);
    struct build_call call;
    if (!device)
        return;
    build_call_start(&call, device, command);
    call.view.command_buffer = (struct command_buffer_facts){.handle = handle, .alive = NO};
    check_one_rule(&call, RULE_command_buffer_is_valid);
}

void build_call_report_device(enum build_command command, VkDevice handle)
{
    struct layer_device *device = layer_find_reporting_device(handle);
    struct build_call call;
    if (!device)
        return;
    build_call_start(&call, device, command);
    call.view.device_argument = handle;
    check_one_rule(&call, RULE_device_is_valid);
}

bool build_call_of_another_device(void *user, enum resource_kind kind, uint64_t handle)
{
    return layer_other_device_has(((struct build_call *)user)->device, kind, handle);
}

/* ---- the journal */

/* Reports a finding about an entry that this call records. */
static bool found_in_journal(void *user, const struct journal *journal, uint32_t first_build,
                             uint32_t origin, enum rule rule, const struct location *location,
                             const struct finding *finding)
{
    (void)journal;
    (void)first_build;
    (void)origin;
    return build_call_found(user, rule, location, finding);
}

static struct replay replay_of(struct build_call *call)
{
    return (struct replay){
        .active = call->device->active_rules,
        .resources = call->device->resources,
        .found = found_in_journal,
        .user = call,
    };
}

__attribute__((cold)) void build_call_settle_entries(struct build_call *call)
{
    if (call->journal->has_sources_to_check) {
        struct replay replay = replay_of(call);
        replay_recorded(&replay, call->command_buffer);
    }
    if (call->skip)
        journal_take_back(call->journal, call->journal->call);
    else
        replay_keep(call->command_buffer);
}

void build_call_count_builds(struct build_call *call, uint32_t count)
{
    if (call->command_buffer)
        call->command_buffer->facts.build_index += count;
}
