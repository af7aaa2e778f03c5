/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the checks of commands that build no structures, and finds the callers of commands. */
#include "layer/intercepts/intercepts.h"

#include <string.h>

#include "layer/execution/submitted_builds.h"
#include "src/base/readable.h"
#include "src/check/life/life.h"
#include "src/state/commands/call_sites.h"

bool checks_are_active(const struct layer_device *device, enum build_command command)
{
    for (int rule = 0; rule < RULE_COUNT; rule++)
        if (device->active_rules[command][rule])
            return true;
    return false;
}

static bool is_deferrable(enum build_command command)
{
    return rule_infos[RULE_deferred_operation_is_valid].vuid[command] != VUID_NONE;
}

static void start_hosted(struct build_call *call, struct layer_device *device,
                         enum build_command command, const VkDevice *arguments)
{
    build_call_start(call, device, command);
    reporter_begin_call();
    call->view.device_argument = arguments[0];
    if (is_deferrable(command)) {
        const struct {
            VkDevice device;
            VkDeferredOperationKHR operation;
        } *deferrable = (const void *)arguments;
        call->view.deferred = host_work_operation_facts(device, deferrable->operation);
    }
}

static bool find_use(void *user, const struct used_object *object, struct pending_use *use)
{
    const struct build_call *call = user;
    return submitted_builds_find_use(call->device->submitted_builds, object, use);
}

static enum tristate is_compatible(void *user, bool is_micromap,
                                   const uint8_t version[2 * VK_UUID_SIZE])
{
    const struct build_call *call = user;
    return layer_find_compatibility(call->device, is_micromap, version);
}

/* The query is a call of the layer's own, and needs what one of the application would need. */
static void find_micromap_sizes(void *user, const VkMicromapBuildInfoEXT *info,
                                VkAccelerationStructureBuildTypeKHR build_type,
                                struct micromap_size_facts *sizes)
{
    const struct layer_device *device = ((struct build_call *)user)->device;
    const struct device_facts *facts = &device->facts;
    VkMicromapBuildSizesInfoEXT found = {.sType = VK_STRUCTURE_TYPE_MICROMAP_BUILD_SIZES_INFO_EXT};
    if (!device->vk.GetMicromapBuildSizesEXT || !facts->micromap.ext ||
        (facts->is_group && !facts->buffer_device_address_multi_device))
        return;
    device->vk.GetMicromapBuildSizesEXT(device->handle, build_type, info, &found);
    *sizes = (struct micromap_size_facts){
        .known = true, .micromap = found.micromapSize, .build_scratch = found.buildScratchSize};
}

static void find_input_sizes(void *user, const void *input, struct size_facts *sizes)
{
    *sizes = find_addressed_sizes(((const struct build_call *)user)->device, input);
}

/* Noinline, so that the thread-local variable is located once per call. */
__attribute__((noinline)) static bool *found_by_thread(void)
{
    static _Thread_local bool has_found;
    return &has_found;
}

bool check_has_found(void)
{
    return *found_by_thread();
}

bool check_command(struct layer_device *device, enum build_command command, const void *arguments)
{
    static const struct check_hooks hooks = {
        .found = build_call_found,
        .find_micromap_sizes = find_micromap_sizes,
        .find_input_sizes = find_input_sizes,
        .vertex_format_supported = build_call_vertex_format_supported,
        .radius_format_supported = build_call_radius_format_supported,
        .of_another_device = build_call_of_another_device,
        .is_compatible = is_compatible,
        .find_use = find_use};
    struct build_call call;
    if (command_is_recorded(command))
        build_call_start_recorded(&call, device, command, *(const VkCommandBuffer *)arguments);
    else
        start_hosted(&call, device, command, arguments);
    call.view.arguments = arguments;
    struct check_context context = {
        .hooks = &hooks,
        .user = &call,
        .level = device->level,
        .active = device->active_rules[command],
        .readable = readable_cache_of_thread(),
        .resources = device->resources,
        .query_pools = device->query_pools,
        .templates = device->update_templates,
        .structures = device->structures,
        .size_queries = device->size_queries,
    };
    check_life(&context, &call.view);
    *found_by_thread() = call.has_found;
    return call.skip;
}

struct geometry_shapes *find_referenced_micromaps(struct layer_device *device, const void *bytes)
{
    static const struct check_hooks hooks = {.is_compatible = is_compatible};
    struct build_call call = {.device = device};
    struct check_context context = {.hooks = &hooks,
                                    .user = &call,
                                    .level = device->level,
                                    .readable = readable_cache_of_thread(),
                                    .resources = device->resources};
    return device->level < LEVEL_CONTENT || !device->facts.micromap.khr
               ? NULL
               : check_referenced_micromaps(&context, bytes);
}

void check_invalid_handle(enum build_command command, const void *handle)
{
    if (command_is_recorded(command))
        build_call_report_command_buffer(command, (VkCommandBuffer)(uintptr_t)handle);
    else
        build_call_report_device(command, (VkDevice)(uintptr_t)handle);
}

/* ---- Call sites of commands that are validated. A finding at the call takes the call site from
 * the thread. A finding at submission or completion takes it from the journal, whose entries have
 * taken it from the thread. */

/* Noinline, so that the thread-local variable is located once per call. */
__attribute__((noinline)) static const struct call_site **site_of_thread(void)
{
    static _Thread_local const struct call_site *of_thread;
    return &of_thread;
}

const struct call_site *call_site_of_thread(void)
{
    return *site_of_thread();
}

void call_sites_enable(struct layer_device *device)
{
    switch (reporter_settings(device->instance->reporter)->call_sites) {
    case CALL_SITES_OFF:
        break;
    case CALL_SITES_FRAMES:
        device->call_sites = call_sites_create(CALL_STACK_BY_FRAMES);
        break;
    case CALL_SITES_FULL:
        device->call_sites = call_sites_create(CALL_STACK_BY_TABLES);
        break;
    }
}

static const struct call_site *find_site(const struct layer_device *device, const void *frame,
                                         const void *first, bool is_quick)
{
    struct call_stack stack;
    if (!device || !device->call_sites)
        return NULL;
    if (call_sites_kind(device->call_sites) == CALL_STACK_BY_FRAMES)
        call_stack_walk_frames(frame, first, &stack);
    else if (is_quick)
        stack = (struct call_stack){1, {(uintptr_t)first}};
    else
        call_stack_walk_tables(frame, first, &stack);
    return call_sites_find(device->call_sites, &stack);
}

const struct call_site *call_site_enter(const struct layer_device *device, const void *dispatchable,
                                        const void *frame, const void *first, bool is_quick)
{
    const struct call_site **of_thread = site_of_thread(), *outer = *of_thread;
    /* An invalid handle is reported on another device. */
    *of_thread = find_site(device ? device : layer_find_reporting_device(dispatchable), frame,
                           first, is_quick);
    return outer;
}

void call_site_leave(const struct call_site *outer)
{
    *site_of_thread() = outer;
}
