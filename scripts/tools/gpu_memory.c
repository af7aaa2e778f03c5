/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers, the structures that lie in them, and command buffers. */
#include <stdint.h>

#include "scripts/tools/gpu.h"

void gpu_name(struct gpu *gpu, VkObjectType type, uint64_t handle, const char *name)
{
    TOOL_CALL(gpu->calls, SetDebugUtilsObjectNameEXT, gpu->device,
              &MAKE(VkDebugUtilsObjectNameInfoEXT, .objectType = type, .objectHandle = handle,
                    .pObjectName = name));
}

/* ---- buffers */

static uint32_t gpu_memory_type(const struct gpu *gpu, uint32_t allowed, enum gpu_place place)
{
    VkMemoryPropertyFlags wanted = 0;
    if (place == GPU_PLACE_HOST)
        wanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    for (uint32_t i = 0; i < gpu->memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1) && (gpu->memory.memoryTypes[i].propertyFlags & wanted) == wanted)
            return i;
    tool_fail("the device has no memory of the kind that a buffer needs");
}

VkBuffer gpu_make_buffer(const struct gpu *gpu, VkBufferUsageFlags usage, VkDeviceSize size)
{
    VkBuffer buffer;
    TOOL_CALL(gpu->calls, CreateBuffer, gpu->device,
              &MAKE(VkBufferCreateInfo, .size = size, .usage = usage), NULL, &buffer);
    return buffer;
}

VkDeviceMemory gpu_allocate(const struct gpu *gpu, VkDeviceSize size, uint32_t allowed,
                            enum gpu_place place)
{
    VkDeviceMemory memory;
    TOOL_CALL(
        gpu->calls, AllocateMemory, gpu->device,
        &MAKE(VkMemoryAllocateInfo,
              .pNext =
                  &MAKE(VkMemoryAllocateFlagsInfo, .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT),
              .allocationSize = size, .memoryTypeIndex = gpu_memory_type(gpu, allowed, place)),
        NULL, &memory);
    return memory;
}

VkDeviceAddress gpu_buffer_address(const struct gpu *gpu, VkBuffer buffer)
{
    return gpu->calls.GetBufferDeviceAddress(gpu->device,
                                             &MAKE(VkBufferDeviceAddressInfo, .buffer = buffer));
}

struct gpu_buffer gpu_create_buffer(struct gpu *gpu, const char *name, enum gpu_place place,
                                    VkBufferUsageFlags usage, VkDeviceSize size)
{
    struct gpu_buffer buffer = {.handle = gpu_make_buffer(gpu, usage, size), .size = size};
    VkMemoryRequirements needs;
    gpu_name(gpu, VK_OBJECT_TYPE_BUFFER, (uint64_t)buffer.handle, name);
    gpu->calls.GetBufferMemoryRequirements(gpu->device, buffer.handle, &needs);
    buffer.memory = gpu_allocate(gpu, needs.size, needs.memoryTypeBits, place);
    TOOL_CALL(gpu->calls, BindBufferMemory, gpu->device, buffer.handle, buffer.memory, 0);
    if (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)
        buffer.address = gpu_buffer_address(gpu, buffer.handle);
    if (place == GPU_PLACE_HOST)
        TOOL_CALL(gpu->calls, MapMemory, gpu->device, buffer.memory, 0, VK_WHOLE_SIZE, 0,
                  &buffer.data);
    return buffer;
}

void gpu_destroy_buffer(struct gpu *gpu, struct gpu_buffer *buffer)
{
    gpu->calls.DestroyBuffer(gpu->device, buffer->handle, NULL);
    gpu->calls.FreeMemory(gpu->device, buffer->memory, NULL);
    *buffer = (struct gpu_buffer){0};
}

static VkDeviceSize gpu_scratch_alignment(const struct gpu *gpu)
{
    return gpu->limits.minAccelerationStructureScratchOffsetAlignment;
}

struct gpu_buffer gpu_create_scratch(struct gpu *gpu, const char *name, VkDeviceSize size)
{
    return gpu_create_buffer(gpu, name, GPU_PLACE_DEVICE,
                             VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                             size + gpu_scratch_alignment(gpu));
}

VkDeviceAddress gpu_scratch_address(const struct gpu *gpu, const struct gpu_buffer *buffer)
{
    return gpu_align(buffer->address, gpu_scratch_alignment(gpu));
}

/* ---- acceleration structures */

struct gpu_structure gpu_create_structure_in(struct gpu *gpu, const char *name,
                                             VkAccelerationStructureTypeKHR type, VkBuffer buffer,
                                             VkDeviceSize offset, VkDeviceSize size)
{
    struct gpu_structure structure = {.type = type, .size = size};
    TOOL_CALL(gpu->calls, CreateAccelerationStructureKHR, gpu->device,
              &MAKE(VkAccelerationStructureCreateInfoKHR, .buffer = buffer, .offset = offset,
                    .size = size, .type = type),
              NULL, &structure.handle);
    gpu_name(gpu, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)structure.handle, name);
    return structure;
}

struct gpu_structure gpu_create_structure(struct gpu *gpu, const char *name,
                                          VkAccelerationStructureTypeKHR type, VkDeviceSize size)
{
    struct gpu_buffer buffer =
        gpu_create_buffer(gpu, name, GPU_PLACE_DEVICE,
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                              VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                          size);
    struct gpu_structure structure =
        gpu_create_structure_in(gpu, name, type, buffer.handle, 0, size);
    structure.buffer = buffer;
    return structure;
}

void gpu_destroy_structure(struct gpu *gpu, struct gpu_structure *structure)
{
    gpu->calls.DestroyAccelerationStructureKHR(gpu->device, structure->handle, NULL);
    gpu_destroy_buffer(gpu, &structure->buffer);
    *structure = (struct gpu_structure){0};
}

VkDeviceAddress gpu_structure_address(struct gpu *gpu, const struct gpu_structure *structure)
{
    return gpu->calls.GetAccelerationStructureDeviceAddressKHR(
        gpu->device, &MAKE(VkAccelerationStructureDeviceAddressInfoKHR,
                           .accelerationStructure = structure->handle));
}

/* ---- command buffers */

VkCommandBuffer gpu_begin(struct gpu *gpu)
{
    VkCommandBuffer commands;
    TOOL_CALL(gpu->calls, AllocateCommandBuffers, gpu->device,
              &MAKE(VkCommandBufferAllocateInfo, .commandPool = gpu->pool,
                    .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY, .commandBufferCount = 1),
              &commands);
    TOOL_CALL(
        gpu->calls, BeginCommandBuffer, commands,
        &MAKE(VkCommandBufferBeginInfo, .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT));
    return commands;
}

void gpu_submit(struct gpu *gpu, VkCommandBuffer commands)
{
    TOOL_CALL(gpu->calls, EndCommandBuffer, commands);
    TOOL_CALL(gpu->calls, QueueSubmit, gpu->queue, 1,
              &MAKE(VkSubmitInfo, .commandBufferCount = 1, .pCommandBuffers = &commands),
              VK_NULL_HANDLE);
    TOOL_CALL(gpu->calls, QueueWaitIdle, gpu->queue);
    gpu_drop(gpu, commands);
}

void gpu_drop(struct gpu *gpu, VkCommandBuffer commands)
{
    gpu->calls.FreeCommandBuffers(gpu->device, gpu->pool, 1, &commands);
}

void gpu_barrier(struct gpu *gpu, VkCommandBuffer commands, VkPipelineStageFlags before,
                 VkAccessFlags written, VkPipelineStageFlags after, VkAccessFlags wanted)
{
    const STRUCT(VkMemoryBarrier, barrier, .srcAccessMask = written, .dstAccessMask = wanted);
    gpu->calls.CmdPipelineBarrier(commands, before, after, 0, 1, &barrier, 0, NULL, 0, NULL);
}
