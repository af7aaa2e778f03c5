/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the checks of commands that build no structures. */
#include "layer/intercepts/checks.h"

#include "layer/execution/submitted_builds.h"
#include "layer/intercepts/build_call.h"
#include "layer/intercepts/host_work.h"
#include "src/base/readable.h"
#include "src/check/life/life.h"

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

bool check_command(struct layer_device *device, enum build_command command, const void *arguments)
{
    static const struct check_hooks hooks = {
        .found = build_call_found,
        .find_micromap_sizes = find_micromap_sizes,
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
        .structures = device->structures,
    };
    check_life(&context, &call.view);
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
