/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers and pipelines that the layer creates for itself on the application's device. */
#ifndef ASSAY_LAYER_OWN_OBJECTS_H
#define ASSAY_LAYER_OWN_OBJECTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vulkan.h>

struct own_device {
    VkDevice handle;
    const VkuDeviceDispatchTable *vk; /* the next layer's commands */
    const VkPhysicalDeviceMemoryProperties *memory;
};

/* A buffer with its own memory. */
struct own_buffer {
    VkBuffer handle;
    VkDeviceMemory memory;
    uint64_t size;
    VkDeviceAddress address; /* 0 without VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT */
    unsigned char *bytes;    /* mapped, coherent; NULL if only the device uses it */
};

/* `size` is in bytes. own_buffer_free() frees what was created, also after a failure. */
VkResult own_buffer_create(const struct own_device *device, VkBufferUsageFlags usage, uint64_t size,
                           bool is_mapped, struct own_buffer *buffer);
void own_buffer_free(const struct own_device *device, struct own_buffer *buffer);

/* Created from SPIR-V, `size` bytes. */
VkResult own_module_create(const struct own_device *device, const uint32_t *words, size_t size,
                           VkShaderModule *module);
VkResult own_compute_create(const struct own_device *device, const uint32_t *words, size_t size,
                            VkPipelineLayout layout, VkPipeline *pipeline);

#endif
