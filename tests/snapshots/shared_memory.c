/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers on the same memory. */
#include "shared_memory.h"

#include <string.h>

struct memory memory_allocate(const struct stage *stage)
{
    struct memory memory;
    const VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                       .pNext = &flags,
                                       .allocationSize = MEMORY_SIZE,
                                       .memoryTypeIndex = stage->memory_type};
    GET(stage->vk.AllocateMemory(stage->device, &info, NULL, &memory.handle));
    GET(stage->vk.MapMemory(stage->device, memory.handle, 0, VK_WHOLE_SIZE, 0,
                            (void **)&memory.bytes));
    memset(memory.bytes, 0, MEMORY_SIZE);
    return memory;
}

void memory_free(const struct stage *stage, const struct memory *memory)
{
    stage->vk.FreeMemory(stage->device, memory->handle, NULL);
}

struct placed memory_place(const struct stage *stage, const struct memory *memory,
                           VkDeviceSize size)
{
    struct placed placed;
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = size,
        .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    };
    VkMemoryRequirements requirements;
    GET(stage->vk.CreateBuffer(stage->device, &info, NULL, &placed.handle));
    stage->vk.GetBufferMemoryRequirements(stage->device, placed.handle, &requirements);
    GET(stage->vk.BindBufferMemory(stage->device, placed.handle, memory->handle, 0));
    const VkBufferDeviceAddressInfo address = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = placed.handle};
    placed.address = stage->vk.GetBufferDeviceAddress(stage->device, &address);
    return placed;
}

void memory_destroy(const struct stage *stage, const struct placed *placed)
{
    stage->vk.DestroyBuffer(stage->device, placed->handle, NULL);
}

void lures_lay(const struct stage *stage, struct lures *lures)
{
    for (int i = 0; i < LURES; i++)
        lures->buffers[i] = memory_place(stage, &lures->memory, MEMORY_SIZE);
}

void lures_free(const struct stage *stage, const struct lures *lures)
{
    for (int i = 0; i < LURES; i++)
        memory_destroy(stage, &lures->buffers[i]);
    memory_free(stage, &lures->memory);
}
