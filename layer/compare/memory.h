/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers for the layer's own builds and traces. */
#ifndef ASSAY_LAYER_COMPARE_MEMORY_H
#define ASSAY_LAYER_COMPARE_MEMORY_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include "layer/own_objects.h"
#include "src/platform/threads.h"

/* The properties of a device that comparing needs. */
struct compare_device {
    VkDevice handle;
    const VkuDeviceDispatchTable *vk;
    const VkPhysicalDeviceMemoryProperties *memory;
    uint32_t scratch_alignment;
    PFN_vkSetDeviceLoaderData set_loader_data; /* for command buffers; may be NULL */
    pthread_mutex_t *queue_lock;               /* held during submissions */
    /* If false, ray-tracing pipelines are used, whose tables need the sizes below. */
    bool has_queries;
    uint32_t group_handle_size, group_handle_alignment, group_base_alignment;
};

static inline struct own_device compare_own_device(const struct compare_device *device)
{
    return (struct own_device){device->handle, device->vk, device->memory};
}

/* Creates a buffer with a device address. The caller calls compare_buffer_free(), also after a
 * failure. */
VkResult compare_buffer_create(const struct compare_device *device, VkBufferUsageFlags usage,
                               uint64_t size, bool is_mapped, struct own_buffer *buffer);
void compare_buffer_free(const struct compare_device *device, struct own_buffer *buffer);

#endif
