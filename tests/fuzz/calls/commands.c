/* SPDX-License-Identifier: Apache-2.0 */
/* Command pools and command buffers, and what is recorded besides builds. */
#include "calls.h"

/* ---- pools and buffers */

void call_create_pool(struct calls *calls)
{
    struct slot *slot = pick(calls, POOLS);
    const STRUCT(VkCommandPoolCreateInfo, info,
                 .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                 .queueFamilyIndex = take(calls) % 3);
    CREATE(calls, slot, 0, CreateCommandPool, &info);
}

void call_reset_pool(struct calls *calls)
{
    const VkCommandPool pool = PICK(VkCommandPool, calls, POOLS);
    calls->vk.ResetCommandPool(calls->device, pool,
                               take(calls) % 2 ? VK_COMMAND_POOL_RESET_RELEASE_RESOURCES_BIT : 0);
}

void call_allocate_commands(struct calls *calls)
{
    struct slot *slot = pick(calls, COMMAND_BUFFERS);
    const VkCommandPool pool = PICK(VkCommandPool, calls, POOLS);
    const STRUCT(VkCommandBufferAllocateInfo, info, .commandPool = pool,
                 .level = (VkCommandBufferLevel)(take(calls) % 2), .commandBufferCount = 1);
    keep(calls, slot, 0, calls->vk.AllocateCommandBuffers(calls->device, &info, CREATED(calls)));
}

void call_free_commands(struct calls *calls)
{
    VkCommandBuffer commands = pick_commands(calls);
    calls->vk.FreeCommandBuffers(calls->device, PICK(VkCommandPool, calls, POOLS), 1, &commands);
}

void call_begin(struct calls *calls)
{
    const STRUCT(VkCommandBufferInheritanceInfo, inheritance);
    VkCommandBuffer commands = pick_any_commands(calls);
    const STRUCT(VkCommandBufferBeginInfo, info, .flags = take(calls) % 8,
                 .pInheritanceInfo = &inheritance);
    if (commands)
        calls->status = calls->vk.BeginCommandBuffer(commands, &info);
}

void call_end(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    if (commands)
        calls->status = calls->vk.EndCommandBuffer(commands);
}

void call_reset_commands(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    if (commands)
        calls->status = calls->vk.ResetCommandBuffer(
            commands, take(calls) % 2 ? VK_COMMAND_BUFFER_RESET_RELEASE_RESOURCES_BIT : 0);
}

/* Executions multiply with each command buffer between, so few are executed at once. */
void call_execute(struct calls *calls)
{
    VkCommandBuffer primary = pick_commands(calls), secondary = pick_commands(calls);
    if (primary && secondary)
        calls->vk.CmdExecuteCommands(primary, 1, &secondary);
}

/* ---- copies of structures */

VkCopyAccelerationStructureInfoKHR take_copy(struct calls *calls)
{
    STRUCT(VkCopyAccelerationStructureInfoKHR, info);
    info.src = PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    info.dst = PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    info.mode = (VkCopyAccelerationStructureModeKHR)(take(calls) % 2);
    return info;
}

void call_copy_structure(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    const VkCopyAccelerationStructureInfoKHR info = take_copy(calls);
    if (commands)
        calls->vk.CmdCopyAccelerationStructureKHR(commands, &info);
}

void call_serialize(struct calls *calls)
{
    VkCommandBuffer commands = pick_commands(calls);
    STRUCT(VkCopyAccelerationStructureToMemoryInfoKHR, info,
           .src = PICK(VkAccelerationStructureKHR, calls, STRUCTURES),
           .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR);
    info.dst.deviceAddress = take_address(calls, 0);
    if (commands)
        calls->vk.CmdCopyAccelerationStructureToMemoryKHR(commands, &info);
}

void call_deserialize(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    STRUCT(VkCopyMemoryToAccelerationStructureInfoKHR, info,
           .dst = PICK(VkAccelerationStructureKHR, calls, STRUCTURES),
           .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR);
    info.src.deviceAddress = take_address(calls, 0);
    if (commands)
        calls->vk.CmdCopyMemoryToAccelerationStructureKHR(commands, &info);
}

/* ---- queries */

static VkQueryType take_query_type(struct calls *calls)
{
    static const VkQueryType types[] = {VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                                        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR,
                                        VK_QUERY_TYPE_TIMESTAMP,
                                        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV,
                                        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR};
    return TAKE(calls, types);
}

void call_write_properties(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    const VkAccelerationStructureKHR first_structure =
        PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    const VkAccelerationStructureKHR structures[] = {
        first_structure, PICK(VkAccelerationStructureKHR, calls, STRUCTURES)};
    const VkQueryType type = take_query_type(calls);
    const VkQueryPool pool = PICK(VkQueryPool, calls, QUERY_POOLS);
    const uint32_t count = 1u + take(calls) % 2, first = take(calls);
    if (commands)
        calls->vk.CmdWriteAccelerationStructuresPropertiesKHR(commands, count, structures, type,
                                                              pool, first);
}

void call_create_query_pool(struct calls *calls)
{
    struct slot *slot = pick(calls, QUERY_POOLS);
    STRUCT(VkQueryPoolCreateInfo, info, .queryType = take_query_type(calls));
    info.queryCount = 1u + take(calls) % 16;
    CREATE(calls, slot, 0, CreateQueryPool, &info);
}

void call_reset_queries(struct calls *calls)
{
    const VkQueryPool pool = PICK(VkQueryPool, calls, QUERY_POOLS);
    VkCommandBuffer commands = pick_commands(calls);
    const uint32_t first = take(calls), count = take_count(calls);
    if (take(calls) % 2)
        calls->vk.ResetQueryPool(calls->device, pool, first, count);
    else if (commands)
        calls->vk.CmdResetQueryPool(commands, pool, first, count);
}

void call_copy_queries(struct calls *calls)
{
    VkCommandBuffer commands = pick_commands(calls);
    const VkQueryPool pool = PICK(VkQueryPool, calls, QUERY_POOLS);
    const VkBuffer dst = PICK(VkBuffer, calls, BUFFERS);
    const uint32_t first = take(calls) % 8, count = take(calls) % 8;
    const VkDeviceSize offset = take_offset(calls), stride = take_offset(calls);
    if (commands)
        calls->vk.CmdCopyQueryPoolResults(commands, pool, first, count, dst, offset, stride,
                                          take(calls) % 16);
}

void call_get_queries(struct calls *calls)
{
    const VkQueryPool pool = PICK(VkQueryPool, calls, QUERY_POOLS);
    const uint32_t first = take(calls) % 16, count = 1u + take(calls) % 8;
    uint64_t values[32];
    calls->vk.GetQueryPoolResults(calls->device, pool, first, count, sizeof(values), values, 16,
                                  take(calls) % 16 & ~VK_QUERY_RESULT_WAIT_BIT);
}

/* ---- transfers and barriers */

void call_copy_buffer(struct calls *calls)
{
    VkCommandBuffer commands = pick_commands(calls);
    const VkBuffer src = PICK(VkBuffer, calls, BUFFERS), dst = PICK(VkBuffer, calls, BUFFERS);
    VkBufferCopy region = {.srcOffset = take_offset(calls)};
    region.dstOffset = take_offset(calls);
    region.size = 1u + take(calls);
    if (commands)
        calls->vk.CmdCopyBuffer(commands, src, dst, 1, &region);
}

void call_fill_buffer(struct calls *calls)
{
    VkCommandBuffer commands = pick_commands(calls);
    const VkBuffer dst = PICK(VkBuffer, calls, BUFFERS);
    const VkDeviceSize offset = take_offset(calls), size = 4u * (1u + take(calls));
    if (commands)
        calls->vk.CmdFillBuffer(commands, dst, offset, size, take_word(calls));
}

void call_barrier(struct calls *calls)
{
    VkCommandBuffer commands = pick_commands(calls);
    const STRUCT(VkMemoryBarrier, memory,
                 .srcAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
                 .dstAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR);
    const STRUCT(VkMemoryBarrier2, memory_2,
                 .srcStageMask = VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                 .srcAccessMask = VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR);
    if (commands && take(calls) % 2)
        calls->vk.CmdPipelineBarrier2(commands, &MAKE(VkDependencyInfo, .memoryBarrierCount = 1,
                                                      .pMemoryBarriers = &memory_2));
    else if (commands)
        calls->vk.CmdPipelineBarrier(commands,
                                     VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                                     VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, 0, 1,
                                     &memory, 0, NULL, 0, NULL);
}

/* ---- labels, scopes, and what is bound */

void call_label(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    const uint8_t kind = take(calls);
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = kind & 4 ? "frame" : "");
    if (commands && kind % 4 == 1)
        calls->vk.CmdEndDebugUtilsLabelEXT(commands);
    else if (commands && kind % 4 == 2)
        calls->vk.CmdInsertDebugUtilsLabelEXT(commands, &label);
    else if (commands)
        calls->vk.CmdBeginDebugUtilsLabelEXT(commands, &label);
}

void call_scope(struct calls *calls)
{
    VkCommandBuffer commands = pick_commands(calls);
    const uint8_t kind = take(calls);
    const STRUCT(VkRenderingInfo, info, .flags = kind >> 2, .layerCount = 1);
    const VkQueryPool pool = PICK(VkQueryPool, calls, QUERY_POOLS);
    if (!commands)
        return;
    if (kind % 4 == 0)
        calls->vk.CmdBeginRendering(commands, &info);
    else if (kind % 4 == 1)
        calls->vk.CmdEndRendering(commands);
    else if (kind % 4 == 2)
        calls->vk.CmdBeginQuery(commands, pool, 0, 0);
    else
        calls->vk.CmdEndQuery(commands, pool, 0);
}

void call_compute(struct calls *calls)
{
    static const uint32_t constants[64] = {0};
    VkCommandBuffer commands = pick_commands(calls);
    const VkPipelineLayout layout = (VkPipelineLayout)(uintptr_t)0x123450;
    const uint32_t offset = 4u * (take(calls) % 80), size = 4u * (1u + take(calls) % 64);
    if (!commands)
        return;
    if (take(calls) % 2)
        calls->vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE,
                                  (VkPipeline)(uintptr_t)0x123460);
    else
        calls->vk.CmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, offset, size,
                                   constants);
}

void call_event(struct calls *calls)
{
    VkCommandBuffer commands = pick_any_commands(calls);
    const VkEvent event = PICK(VkEvent, calls, EVENTS);
    const uint8_t kind = take(calls);
    const VkPipelineStageFlags stages =
        kind & 8 ? VK_PIPELINE_STAGE_HOST_BIT : VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    if (kind % 8 == 0)
        calls->vk.SetEvent(calls->device, event);
    else if (kind % 8 == 1)
        calls->vk.ResetEvent(calls->device, event);
    else if (commands && kind % 8 < 4)
        calls->vk.CmdSetEvent(commands, event, stages);
    else if (commands && kind % 8 < 5)
        calls->vk.CmdResetEvent(commands, event, stages);
    else if (commands)
        calls->vk.CmdWaitEvents(commands, 1, &event, stages, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0,
                                NULL, 0, NULL, 0, NULL);
}
