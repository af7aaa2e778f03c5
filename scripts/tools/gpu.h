/* SPDX-License-Identifier: Apache-2.0 */
/* A Vulkan device with acceleration structures, and the objects made on it. */
#ifndef TOOLS_GPU_H
#define TOOLS_GPU_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vulkan.h>

#include "scripts/tools/fail.h"
#include "tests/fixture/make.h"

#define GPU_LAYER "VK_LAYER_ASSAY_validation"
#define GPU_LAYER_LIBRARY "libVkLayer_assay"

struct gpu {
    void *library; /* libvulkan.so.1 */
    VkuInstanceDispatchTable instance_calls;
    PFN_vkGetDeviceProcAddr get_device_command;
    VkuDeviceDispatchTable calls;
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkPhysicalDevice physical;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits;
    VkPhysicalDeviceMemoryProperties memory;
    VkDevice device;
    uint32_t queue_family;
    VkQueueFlags queue_flags;
    VkQueue queue;
    bool wants_queries, has_host; /* rays; builds by the host, which are enabled if there are any */
    VkCommandPool pool;
};

/* Opens the first device with acceleration structures, and with ray queries if they are wanted,
 * below `layer`, which may be NULL. What is chained to `messenger` goes to the instance.
 * Ends the process with one line on stderr where there is no such device, driver, loader or layer.
 */
void gpu_open(struct gpu *gpu, const char *layer,
              const VkDebugUtilsMessengerCreateInfoEXT *messenger, bool wants_queries);
void gpu_close(struct gpu *gpu);

/* ---- objects (gpu_memory.c) */

static inline VkDeviceSize gpu_align(VkDeviceSize size, VkDeviceSize alignment)
{
    return (size + alignment - 1) / alignment * alignment;
}

enum gpu_place {
    GPU_PLACE_HOST,   /* mapped for as long as the buffer lives, coherent */
    GPU_PLACE_DEVICE, /* wherever the device likes it */
};

struct gpu_buffer {
    VkBuffer handle;
    VkDeviceMemory memory;
    VkDeviceSize size;
    VkDeviceAddress address; /* 0 unless made with SHADER_DEVICE_ADDRESS usage */
    void *data;              /* null unless in GPU_PLACE_HOST */
};

struct gpu_structure {
    VkAccelerationStructureKHR handle;
    VkAccelerationStructureTypeKHR type;
    VkDeviceSize size;
    struct gpu_buffer buffer; /* its own; all null where it lies in another's */
};

/* Names show in messages. */
void gpu_name(struct gpu *gpu, VkObjectType type, uint64_t handle, const char *name);

/* Only the buffer; memory for buffers of these types, which may have addresses; a buffer's address.
 */
VkBuffer gpu_make_buffer(const struct gpu *gpu, VkBufferUsageFlags usage, VkDeviceSize size);
VkDeviceMemory gpu_allocate(const struct gpu *gpu, VkDeviceSize size, uint32_t allowed,
                            enum gpu_place place);
VkDeviceAddress gpu_buffer_address(const struct gpu *gpu, VkBuffer buffer);

/* All of these. */
struct gpu_buffer gpu_create_buffer(struct gpu *gpu, const char *name, enum gpu_place place,
                                    VkBufferUsageFlags usage, VkDeviceSize size);
void gpu_destroy_buffer(struct gpu *gpu, struct gpu_buffer *buffer);

/* Room to find `size` bytes at an address aligned as scratch has to be: gpu_scratch_address(). */
struct gpu_buffer gpu_create_scratch(struct gpu *gpu, const char *name, VkDeviceSize size);
VkDeviceAddress gpu_scratch_address(const struct gpu *gpu, const struct gpu_buffer *buffer);

struct gpu_structure gpu_create_structure(struct gpu *gpu, const char *name,
                                          VkAccelerationStructureTypeKHR type, VkDeviceSize size);
struct gpu_structure gpu_create_structure_in(struct gpu *gpu, const char *name,
                                             VkAccelerationStructureTypeKHR type, VkBuffer buffer,
                                             VkDeviceSize offset, VkDeviceSize size);
void gpu_destroy_structure(struct gpu *gpu, struct gpu_structure *structure);
VkDeviceAddress gpu_structure_address(struct gpu *gpu, const struct gpu_structure *structure);

/* A command buffer in the recording state, to be submitted and waited for, or to be dropped. */
VkCommandBuffer gpu_begin(struct gpu *gpu);
void gpu_submit(struct gpu *gpu, VkCommandBuffer commands);
void gpu_drop(struct gpu *gpu, VkCommandBuffer commands);

/* What the stages and accesses before have written is there for those after. */
void gpu_barrier(struct gpu *gpu, VkCommandBuffer commands, VkPipelineStageFlags before,
                 VkAccessFlags written, VkPipelineStageFlags after, VkAccessFlags wanted);

#endif
