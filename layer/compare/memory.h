/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers of the layer's own for what it builds and traces. */
#ifndef ASSAY_LAYER_COMPARE_MEMORY_H
#define ASSAY_LAYER_COMPARE_MEMORY_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

/* What comparing needs of a device. */
struct compare_device {
    VkDevice handle;
    const VkuDeviceDispatchTable *vk;
    const VkPhysicalDeviceMemoryProperties *memory;
    uint32_t scratch_alignment;
    PFN_vkSetDeviceLoaderData set_loader_data; /* for command buffers; NULL: none */
    pthread_mutex_t *queue_lock;               /* held while something is submitted */
    bool has_queries; /* else ray-tracing pipelines, and what their tables need: */
    uint32_t group_handle_size, group_handle_alignment, group_base_alignment;
};

struct compare_buffer {
    VkBuffer handle;
    VkDeviceMemory memory;
    VkDeviceAddress address;
    unsigned char *bytes; /* mapped, coherent; NULL where the device alone uses it */
};

/* Whatever was made is freed by compare_buffer_free(), also after a failure. */
VkResult compare_buffer_create(const struct compare_device *device, VkBufferUsageFlags usage,
                               uint64_t size, bool is_mapped, struct compare_buffer *buffer);
void compare_buffer_free(const struct compare_device *device, struct compare_buffer *buffer);

#endif
