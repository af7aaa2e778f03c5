/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers, each with memory of its own: they live as long as one comparison. */
#include "compare/memory.h"

static uint32_t find_type(const VkPhysicalDeviceMemoryProperties *memory, uint32_t allowed,
                          VkMemoryPropertyFlags wanted)
{
    for (uint32_t i = 0; i < memory->memoryTypeCount; i++)
        if ((allowed >> i & 1) && (memory->memoryTypes[i].propertyFlags & wanted) == wanted)
            return i;
    return UINT32_MAX;
}

static uint32_t memory_type(const struct compare_device *device, uint32_t allowed, bool is_mapped)
{
    const VkMemoryPropertyFlags mapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkMemoryPropertyFlags best = is_mapped ? mapped | VK_MEMORY_PROPERTY_HOST_CACHED_BIT
                                           : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    uint32_t type = find_type(device->memory, allowed, best);
    return type != UINT32_MAX ? type : find_type(device->memory, allowed, is_mapped ? mapped : 0);
}

static VkResult allocate(const struct compare_device *device, bool is_mapped,
                         struct compare_buffer *buffer)
{
    VkMemoryRequirements requirements;
    device->vk->GetBufferMemoryRequirements(device->handle, buffer->handle, &requirements);
    const VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    const VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
        .pNext = &flags,
        .allocationSize = requirements.size,
        .memoryTypeIndex = memory_type(device, requirements.memoryTypeBits, is_mapped),
    };
    if (info.memoryTypeIndex == UINT32_MAX)
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    VkResult result = device->vk->AllocateMemory(device->handle, &info, NULL, &buffer->memory);
    if (result == VK_SUCCESS)
        result = device->vk->BindBufferMemory(device->handle, buffer->handle, buffer->memory, 0);
    if (result == VK_SUCCESS && is_mapped)
        result = device->vk->MapMemory(device->handle, buffer->memory, 0, VK_WHOLE_SIZE, 0,
                                       (void **)&buffer->bytes);
    return result;
}

static VkDeviceAddress address_of(const struct compare_device *device, VkBuffer buffer)
{
    const VkBufferDeviceAddressInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                            .buffer = buffer};
    PFN_vkGetBufferDeviceAddress get = device->vk->GetBufferDeviceAddress
                                           ? device->vk->GetBufferDeviceAddress
                                           : device->vk->GetBufferDeviceAddressKHR;
    return get(device->handle, &info);
}

VkResult compare_buffer_create(const struct compare_device *device, VkBufferUsageFlags usage,
                               uint64_t size, bool is_mapped, struct compare_buffer *buffer)
{
    *buffer = (struct compare_buffer){0};
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = size,
        .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    };
    VkResult result = device->vk->CreateBuffer(device->handle, &info, NULL, &buffer->handle);
    if (result == VK_SUCCESS)
        result = allocate(device, is_mapped, buffer);
    if (result == VK_SUCCESS)
        buffer->address = address_of(device, buffer->handle);
    return result;
}

void compare_buffer_free(const struct compare_device *device, struct compare_buffer *buffer)
{
    if (buffer->handle)
        device->vk->DestroyBuffer(device->handle, buffer->handle, NULL);
    if (buffer->memory)
        device->vk->FreeMemory(device->handle, buffer->memory, NULL);
    *buffer = (struct compare_buffer){0};
}
