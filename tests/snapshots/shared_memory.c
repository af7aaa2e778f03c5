/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers on the same memory. */
#include "shared_memory.h"

#include <string.h>

struct memory memory_allocate(const struct fixture *fixture)
{
    struct memory memory = {
        memory_create(&fixture->vk, fixture->device, fixture->memory_type, MEMORY_SIZE), NULL};
    GET(fixture->vk.MapMemory(fixture->device, memory.handle, 0, VK_WHOLE_SIZE, 0,
                              (void **)&memory.bytes));
    memset(memory.bytes, 0, MEMORY_SIZE);
    return memory;
}

void memory_free(const struct fixture *fixture, const struct memory *memory)
{
    fixture->vk.FreeMemory(fixture->device, memory->handle, NULL);
}

struct placed memory_place(const struct fixture *fixture, const struct memory *memory,
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
    GET(fixture->vk.CreateBuffer(fixture->device, &info, NULL, &placed.handle));
    fixture->vk.GetBufferMemoryRequirements(fixture->device, placed.handle, &requirements);
    GET(fixture->vk.BindBufferMemory(fixture->device, placed.handle, memory->handle, 0));
    placed.address = buffer_address(&fixture->vk, fixture->device, placed.handle);
    return placed;
}

void memory_destroy(const struct fixture *fixture, const struct placed *placed)
{
    fixture->vk.DestroyBuffer(fixture->device, placed->handle, NULL);
}

void lures_lay(const struct fixture *fixture, struct lures *lures)
{
    for (int i = 0; i < LURES; i++)
        lures->buffers[i] = memory_place(fixture, &lures->memory, MEMORY_SIZE);
}

void lures_free(const struct fixture *fixture, const struct lures *lures)
{
    for (int i = 0; i < LURES; i++)
        memory_destroy(fixture, &lures->buffers[i]);
    memory_free(fixture, &lures->memory);
}
