/* SPDX-License-Identifier: Apache-2.0 */
/* Creates the layer's own buffers and pipelines. */
#include "layer/own_objects.h"

/* ---- buffers */

static const VkMemoryPropertyFlags MAPPED =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

static uint32_t find_type(const VkPhysicalDeviceMemoryProperties *memory, uint32_t allowed,
                          VkMemoryPropertyFlags wanted)
{
    /* Other bits belong to extensions whose features the application may not have enabled. */
    const VkMemoryPropertyFlags known =
        MAPPED | VK_MEMORY_PROPERTY_HOST_CACHED_BIT | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    for (uint32_t i = 0; i < memory->memoryTypeCount; i++) {
        VkMemoryPropertyFlags flags = memory->memoryTypes[i].propertyFlags;
        if ((allowed >> i & 1) && (flags & wanted) == wanted && !(flags & ~known))
            return i;
    }
    return UINT32_MAX;
}

/* A memory type that is fast to read, if there is one. A coherent type always exists. */
static uint32_t memory_type(const struct own_device *device, uint32_t allowed, bool is_mapped)
{
    VkMemoryPropertyFlags best = is_mapped ? MAPPED | VK_MEMORY_PROPERTY_HOST_CACHED_BIT
                                           : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    uint32_t type = find_type(device->memory, allowed, best);
    return type != UINT32_MAX ? type : find_type(device->memory, allowed, is_mapped ? MAPPED : 0);
}

static VkResult allocate_memory(const struct own_device *device, bool has_address, bool is_mapped,
                                struct own_buffer *buffer)
{
    VkMemoryRequirements requirements;
    device->vk->GetBufferMemoryRequirements(device->handle, buffer->handle, &requirements);
    const VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    const VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
        .pNext = has_address ? &flags : NULL,
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

static VkDeviceAddress address_of(const struct own_device *device, VkBuffer buffer)
{
    const VkBufferDeviceAddressInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                            .buffer = buffer};
    /* The extension's command is NULL unless the application enables it. A layer below may return a
     * core command that the application's version lacks, so it comes second. */
    PFN_vkGetBufferDeviceAddress get = device->vk->GetBufferDeviceAddressKHR
                                           ? device->vk->GetBufferDeviceAddressKHR
                                           : device->vk->GetBufferDeviceAddress;
    return get(device->handle, &info);
}

VkResult own_buffer_create(const struct own_device *device, VkBufferUsageFlags usage, uint64_t size,
                           bool is_mapped, struct own_buffer *buffer)
{
    bool has_address = usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    *buffer = (struct own_buffer){.size = size};
    VkResult result = device->vk->CreateBuffer(device->handle, &info, NULL, &buffer->handle);
    if (result == VK_SUCCESS)
        result = allocate_memory(device, has_address, is_mapped, buffer);
    if (result == VK_SUCCESS && has_address)
        buffer->address = address_of(device, buffer->handle);
    return result;
}

void own_buffer_free(const struct own_device *device, struct own_buffer *buffer)
{
    if (buffer->handle)
        device->vk->DestroyBuffer(device->handle, buffer->handle, NULL);
    if (buffer->memory)
        device->vk->FreeMemory(device->handle, buffer->memory, NULL);
    *buffer = (struct own_buffer){0};
}

/* ---- pipelines */

VkResult own_module_create(const struct own_device *device, const uint32_t *words, size_t size,
                           VkShaderModule *module)
{
    const VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = size,
        .pCode = words,
    };
    return device->vk->CreateShaderModule(device->handle, &info, NULL, module);
}

VkResult own_compute_create(const struct own_device *device, const uint32_t *words, size_t size,
                            VkPipelineLayout layout, VkPipeline *pipeline)
{
    VkShaderModule module;
    VkResult result = own_module_create(device, words, size, &module);
    if (result != VK_SUCCESS)
        return result;
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main"},
        .layout = layout,
    };
    result = device->vk->CreateComputePipelines(device->handle, VK_NULL_HANDLE, 1, &info, NULL,
                                                pipeline);
    device->vk->DestroyShaderModule(device->handle, module, NULL);
    return result;
}
