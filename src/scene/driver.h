/* SPDX-License-Identifier: Apache-2.0 */
/* The device on which assay-scene replays captures, and objects made on it. The Vulkan loader is
 * opened when a device is: nothing else of the program needs one.
 *
 * All memory is mapped. Functions that return bool set `error` if they return false. */
#ifndef ASSAY_SCENE_DRIVER_H
#define ASSAY_SCENE_DRIVER_H

#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vulkan.h>

#include "src/scene/capture.h"

struct driver {
    bool traces;        /* ray queries are enabled */
    const char *wanted; /* a part of the device's name; NULL: any */
    void *library;
    VkInstance instance;
    VkuInstanceDispatchTable instance_vk;
    PFN_vkGetDeviceProcAddr get_device_command;
    VkPhysicalDevice physical;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceDriverProperties driver;
    VkPhysicalDeviceMemoryProperties memory;
    uint32_t scratch_alignment;
    VkDebugUtilsMessengerEXT messenger;
    VkDevice device;
    VkuDeviceDispatchTable vk;
    uint32_t queue_family;
    uint32_t timestamp_bits; /* 0: the queue has no timestamps */
    VkQueue queue;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkQueryPool times; /* two timestamps; null: none */
};

/* `layer`: also enables the layer of this project, whose messages `on_message` gets. */
bool driver_open(struct driver *driver, bool layer, PFN_vkDebugUtilsMessengerCallbackEXT on_message,
                 void *user, struct capture_error *error);
/* The first device that has this in its name (NULL: any) and also has ray queries; or else, the
 * first that has this in its name. */
bool driver_open_to_trace(struct driver *driver, const char *name, struct capture_error *error);
void driver_close(struct driver *driver);

/* Memory, mapped, that buffers with these requirements can be bound to. */
struct driver_memory {
    VkDeviceMemory handle;
    unsigned char *bytes;
};
bool driver_allocate(struct driver *driver, VkDeviceSize size, uint32_t types,
                     struct driver_memory *memory, struct capture_error *error);
void driver_free(struct driver *driver, struct driver_memory *memory);

/* A buffer with memory of its own. */
struct driver_buffer {
    VkBuffer handle;
    struct driver_memory memory;
    VkDeviceAddress address;
    VkDeviceSize size;
};
bool driver_make_buffer(struct driver *driver, VkDeviceSize size, VkBufferUsageFlags usage,
                        struct driver_buffer *buffer, struct capture_error *error);
void driver_destroy_buffer(struct driver *driver, struct driver_buffer *buffer);
VkDeviceAddress driver_buffer_address(const struct driver *driver, VkBuffer buffer);

/* Records into driver->commands between these two, and waits until the device has executed them. */
bool driver_begin(struct driver *driver, struct capture_error *error);
bool driver_run(struct driver *driver, struct capture_error *error);

/* Records a barrier between all that precedes it and all that follows. */
void driver_order_all(const struct driver *driver);
/* Record timestamps around what is measured. Nothing without driver->times. */
void driver_begin_time(const struct driver *driver);
void driver_end_time(const struct driver *driver);
/* Returns the nanoseconds between the two timestamps that were executed last; NaN without
 * driver->times, or if the device does not give them. */
double driver_read_time(const struct driver *driver);

/* Says that a call has failed. Returns false. */
bool driver_fail(struct capture_error *error, const char *call, VkResult result);

#endif
