/* SPDX-License-Identifier: Apache-2.0 */
/* A device with acceleration structures, at level content on backend driver or without the layer.
 * What fails though it should not ends the test. */
#ifndef SNAPSHOTS_STAGE_H
#define SNAPSHOTS_STAGE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "messages.h"
#include "platform.h"

#define GET(call) assert_int_equal(call, VK_SUCCESS)

struct stage {
    const struct platform *platform;
    struct messages messages;
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger; /* null without the layer */
    VkuInstanceDispatchTable instance_vk;
    PFN_vkGetDeviceProcAddr get_device_proc_addr;
    VkPhysicalDevice physical;
    VkDevice device;
    VkuDeviceDispatchTable vk;
    VkQueue queue;
    VkCommandPool pool;
    uint32_t memory_type; /* mapped and coherent */
    bool has_conditional_rendering;
};

struct stage_setup {
    bool has_layer;
    const char *level;                  /* NULL: content */
    const char *budget_mib, *when_full; /* settings; NULL: the default */
};

void stage_open(struct stage *stage, const struct platform *platform,
                const struct stage_setup *setup);
void stage_close(struct stage *stage);

/* Mapped, and all zeros. */
struct stage_buffer {
    VkBuffer handle;
    VkDeviceMemory memory;
    VkDeviceSize size;
    VkDeviceAddress address;
    unsigned char *bytes;
};
struct stage_buffer stage_buffer(struct stage *stage, VkDeviceSize size, VkBufferUsageFlags usage);
void stage_destroy_buffer(struct stage *stage, struct stage_buffer *buffer);

VkAccelerationStructureKHR stage_structure(struct stage *stage, const struct stage_buffer *buffer,
                                           VkDeviceSize offset, VkDeviceSize size,
                                           VkAccelerationStructureTypeKHR type);

VkCommandBuffer stage_begin(struct stage *stage, VkCommandBufferUsageFlags flags);
/* Ends and submits it, and waits. */
void stage_finish(struct stage *stage, VkCommandBuffer commands);
VkResult stage_submit(struct stage *stage, VkCommandBuffer commands, VkFence fence);
VkFence stage_fence(struct stage *stage);
/* A timeline semaphore, and a submission that waits for its value 1; `fence` may be null. */
VkSemaphore stage_timeline(struct stage *stage);
void stage_submit_waiting(struct stage *stage, VkCommandBuffer commands, VkSemaphore timeline,
                          VkFence fence);

/* All that was written before is seen by all that comes behind. */
void stage_barrier(struct stage *stage, VkCommandBuffer commands);

/* A build of `count` AABBs, with scratch memory. */
void stage_build_boxes(struct stage *stage, VkCommandBuffer commands,
                       VkAccelerationStructureKHR dst, VkDeviceAddress boxes, uint32_t count,
                       VkDeviceAddress scratch);

void stage_expect_silence(const struct stage *stage);

#endif
