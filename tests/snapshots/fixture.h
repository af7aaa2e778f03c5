/* SPDX-License-Identifier: Apache-2.0 */
/* A device with acceleration structures, at level content on backend driver or without the layer.
 * What fails though it should not ends the test. */
#ifndef ASSAY_TESTS_SNAPSHOTS_FIXTURE_H
#define ASSAY_TESTS_SNAPSHOTS_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "messages.h"
#include "platform.h"

#define GET(call) assert_int_equal(call, VK_SUCCESS)

struct fixture {
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

struct fixture_setup {
    bool has_layer;
    const char *level;                  /* NULL: content */
    const char *budget_mib, *when_full; /* settings; NULL: the default */
};

void fixture_open(struct fixture *fixture, const struct platform *platform,
                  const struct fixture_setup *setup);
void fixture_close(struct fixture *fixture);

/* Mapped, and all zeros. */
struct fixture_buffer {
    VkBuffer handle;
    VkDeviceMemory memory;
    VkDeviceSize size;
    VkDeviceAddress address;
    unsigned char *bytes;
};
struct fixture_buffer fixture_buffer(struct fixture *fixture, VkDeviceSize size,
                                     VkBufferUsageFlags usage);
void fixture_destroy_buffer(struct fixture *fixture, struct fixture_buffer *buffer);

VkAccelerationStructureKHR fixture_structure(struct fixture *fixture,
                                             const struct fixture_buffer *buffer,
                                             VkDeviceSize offset, VkDeviceSize size,
                                             VkAccelerationStructureTypeKHR type);

VkCommandBuffer fixture_begin(struct fixture *fixture, VkCommandBufferUsageFlags flags);
/* Ends and submits it, and waits. */
void fixture_finish(struct fixture *fixture, VkCommandBuffer commands);
VkResult fixture_submit(struct fixture *fixture, VkCommandBuffer commands, VkFence fence);
VkFence fixture_fence(struct fixture *fixture);
/* A timeline semaphore, and a submission that waits for its value 1; `fence` may be null. */
VkSemaphore fixture_timeline(struct fixture *fixture);
void fixture_submit_waiting(struct fixture *fixture, VkCommandBuffer commands, VkSemaphore timeline,
                            VkFence fence);

/* All that was written before is seen by all that comes behind. */
void fixture_barrier(struct fixture *fixture, VkCommandBuffer commands);

/* A build of `count` AABBs, with scratch memory. */
void fixture_build_boxes(struct fixture *fixture, VkCommandBuffer commands,
                         VkAccelerationStructureKHR dst, VkDeviceAddress boxes, uint32_t count,
                         VkDeviceAddress scratch);

void fixture_expect_silence(const struct fixture *fixture);

#endif
