/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the call as a whole. */
#include "src/rules/predicates.h"

bool acceleration_structure_feature_is_enabled(const struct call_view *call,
                                               struct finding *finding)
{
    return call->device->acceleration_structure ||
           violated_plainly(
               finding, "",
               "requires VkPhysicalDeviceAccelerationStructureFeaturesKHR::accelerationStructure, "
               "which is not enabled for the device");
}

bool indirect_build_feature_is_enabled(const struct call_view *call, struct finding *finding)
{
    return call->device->acceleration_structure_indirect_build ||
           violated_plainly(
               finding, "",
               "requires "
               "VkPhysicalDeviceAccelerationStructureFeaturesKHR::"
               "accelerationStructureIndirectBuild, which is not enabled for the device");
}

bool host_commands_feature_is_enabled(const struct call_view *call, struct finding *finding)
{
    return call->device->acceleration_structure_host_commands ||
           violated_plainly(
               finding, "",
               "requires "
               "VkPhysicalDeviceAccelerationStructureFeaturesKHR::"
               "accelerationStructureHostCommands, which is not enabled for the device");
}

static struct value this_command_buffer(const struct call_view *call)
{
    return object(VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(call->command_buffer.handle));
}

bool command_buffer_is_valid(const struct call_view *call, struct finding *finding)
{
    if (call->command_buffer.alive != NO)
        return true;
    if (!call->command_buffer.handle)
        return violated_plainly(finding, "commandBuffer", "is VK_NULL_HANDLE");
    return violated(finding, "commandBuffer",
                    "{} is not a valid VkCommandBuffer: it was freed or never allocated",
                    this_command_buffer(call));
}

static const char *state_name(enum command_buffer_state state)
{
    switch (state) {
    case COMMAND_BUFFER_INITIAL:
        return "initial";
    case COMMAND_BUFFER_RECORDING:
        return "recording";
    case COMMAND_BUFFER_EXECUTABLE:
        return "executable";
    case COMMAND_BUFFER_INVALID:
        return "invalid";
    case COMMAND_BUFFER_UNKNOWN:
        break;
    }
    return "unknown";
}

bool command_buffer_is_recording(const struct call_view *call, struct finding *finding)
{
    enum command_buffer_state state = call->command_buffer.state;
    return state == COMMAND_BUFFER_UNKNOWN || state == COMMAND_BUFFER_RECORDING ||
           violated(finding, "commandBuffer", "{} is in the {} state, not in the recording state",
                    this_command_buffer(call), phrase(state_name(state)));
}

bool command_pool_supports_compute(const struct call_view *call, struct finding *finding)
{
    VkQueueFlags flags = call->command_buffer.queue_flags;
    return !flags || (flags & VK_QUEUE_COMPUTE_BIT) ||
           violated(finding, "commandBuffer",
                    "{} was allocated from a VkCommandPool whose queue family has flags {}, "
                    "without VK_QUEUE_COMPUTE_BIT",
                    this_command_buffer(call), hex(flags));
}

bool command_buffer_is_not_protected(const struct call_view *call, struct finding *finding)
{
    return call->command_buffer.is_protected != YES ||
           violated(finding, "commandBuffer", "{} is a protected command buffer",
                    this_command_buffer(call));
}

bool build_is_outside_render_pass(const struct call_view *call, struct finding *finding)
{
    return call->command_buffer.in_render_pass != YES ||
           violated(finding, "commandBuffer", "{} is inside a render pass instance",
                    this_command_buffer(call));
}

bool build_is_not_between_suspended_render_passes(const struct call_view *call,
                                                  struct finding *finding)
{
    return call->command_buffer.suspended != YES ||
           violated(finding, "commandBuffer",
                    "{} has a render pass instance that is suspended and not yet resumed",
                    this_command_buffer(call));
}

bool build_is_outside_video_coding(const struct call_view *call, struct finding *finding)
{
    return call->command_buffer.in_video_coding != YES ||
           violated(finding, "commandBuffer", "{} is inside a video coding scope",
                    this_command_buffer(call));
}

bool info_count_is_positive(const struct call_view *call, struct finding *finding)
{
    return call->info_count || violated_plainly(finding, "infoCount", "is 0");
}

static bool array_is_readable(const struct call_view *call, struct finding *finding,
                              const char *field, const void *pointer, bool is_readable)
{
    return !call->info_count || is_readable ||
           violated(finding, field, "{} does not point to a readable array of {}",
                    hex((uint64_t)(uintptr_t)pointer), count_of(call->info_count, "element"));
}

bool infos_are_readable(const struct call_view *call, struct finding *finding)
{
    return array_is_readable(call, finding, "pInfos", call->infos, call->infos_readable);
}

bool build_ranges_are_readable(const struct call_view *call, struct finding *finding)
{
    return array_is_readable(call, finding, "ppBuildRangeInfos", call->build_ranges,
                             call->build_ranges_readable);
}

bool max_primitive_counts_are_readable(const struct call_view *call, struct finding *finding)
{
    return array_is_readable(call, finding, "ppMaxPrimitiveCounts", call->max_primitive_counts,
                             call->max_primitive_counts_readable);
}

bool indirect_addresses_are_readable(const struct call_view *call, struct finding *finding)
{
    return array_is_readable(call, finding, "pIndirectDeviceAddresses", call->indirect_addresses,
                             call->indirect_addresses_readable);
}

bool indirect_strides_are_readable(const struct call_view *call, struct finding *finding)
{
    return array_is_readable(call, finding, "pIndirectStrides", call->indirect_strides,
                             call->indirect_strides_readable);
}
