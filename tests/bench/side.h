/* SPDX-License-Identifier: Apache-2.0 */
/* The two sides of a comparison: a device with the layer above it, and one without. Both live in
 * one process, so that their samples can take turns. */
#ifndef BENCH_SIDE_H
#define BENCH_SIDE_H

#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vulkan.h>

#define BENCH_LAYER "VK_LAYER_ASSAY_validation"

struct side {
    VkInstance instance;
    VkuInstanceDispatchTable instance_calls;
    VkDebugUtilsMessengerEXT messenger;
    VkPhysicalDevice physical;
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits;
    VkDevice device;
    VkuDeviceDispatchTable calls;
    uint32_t queue_family;
    uint32_t *findings; /* messages of the layer: there should be none */
};

/* Makes the loader see only the driver "null" or "lavapipe", and layers only of this build tree, or
 * of VK_LAYER_PATH where the caller has set it. */
void driver_select(const char *name);

/* `layer` may be NULL; `level` is the layer's setting of that name, or NULL for its default. */
void side_open(struct side *side, const char *layer, const char *level);
void side_close(struct side *side);

#endif
