/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the application share. */
#ifndef SCARCE_APPLICATION_PARTS_H
#define SCARCE_APPLICATION_PARTS_H

#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vulkan.h>

#include "application.h"
#include "tests/fixture/make.h"

enum {
    /* Of each object, so that tables grow beyond their first size, and arrays beyond what is kept
     * in place. */
    SETS = 48,
    BUILDS = 20,     /* of the largest call */
    GEOMETRIES = 20, /* of the largest build */
    ACCEL_SIZE = 8192,
    SCRATCH_SIZE = 8192,
    SPARSE_PAGE = 65536,
    SPARSE_PAGES = 12,
    NV_STRUCTURES = 24,
    MICROMAPS = 24,
    QUERIES = 4,
};

/* A structure in a buffer in memory of its own, and a command buffer in a pool of its own. */
struct set {
    VkDeviceMemory memory;
    VkBuffer buffer;
    VkAccelerationStructureKHR accel;
    VkCommandPool pool;
    VkCommandBuffer primary, secondary;
};

struct application {
    struct outcome *outcome;
    VkuInstanceDispatchTable instance_vk;
    VkuDeviceDispatchTable vk;
    VkInstance instance;
    VkDevice device;
    VkQueue queue;
    VkDebugUtilsMessengerCreateInfoEXT messenger_info;
    VkDebugUtilsMessengerEXT messenger;
    VkDebugReportCallbackEXT callback;
    const char *expected_id; /* of the mistake under way, or NULL */
    unsigned heard;          /* messages about it */

    struct set sets[SETS];
    VkSemaphore semaphore;
    VkQueryPool queries; /* of compacted sizes */
    /* Inputs and scratch: one memory, in which small buffers without the right usage alias the
     * large one that has it. */
    VkDeviceMemory memory;
    VkBuffer inputs, scratch, aliases[SETS];
    VkDeviceAddress input_address, scratch_address;
    /* A sparse buffer, and a structure across its pages. */
    VkDeviceMemory pages;
    VkBuffer sparse;
    VkAccelerationStructureKHR in_pages;
    /* Two structures that overlap only in bytes that their builds leave alone. */
    VkDeviceMemory tails_memory;
    VkBuffer tails;
    VkAccelerationStructureKHR with_tails[2];
    /* Of VK_NV_ray_tracing, with their scratch behind them in one memory. */
    VkDeviceMemory nv_memory;
    VkAccelerationStructureNV nv[NV_STRUCTURES];
    VkBuffer nv_scratch;
    /* Of VK_EXT_opacity_micromap; and structures for one of VK_KHR_opacity_micromap, and for what
     * uses all of them. */
    VkMicromapEXT micromaps[MICROMAPS];
    VkDeviceMemory micromap_memory;
    VkBuffer micromap_buffer;
    VkAccelerationStructureKHR micromap, with_micromaps;
};

/* Asks for something that can be refused; the second time there is memory. */
#define GET(app, what, call)                                                                       \
    do {                                                                                           \
        VkResult get_result = (call);                                                              \
        if (get_result == VK_ERROR_OUT_OF_HOST_MEMORY)                                             \
            get_result = (call);                                                                   \
        if (get_result != VK_SUCCESS)                                                              \
            complain(app, what, get_result);                                                       \
    } while (0)

/* The same for a device command of that name. */
#define CALL(app, name, ...) GET(app, "vk" #name, (app)->vk.name(__VA_ARGS__))

/* Notes the first thing that went wrong. */
void complain(struct application *app, const char *what, int result);

/* Until the second, messages of that id are about a mistake; there is at most one. */
void expect(struct application *app, const char *id);
void expect_nothing_more(struct application *app);

void name_object(struct application *app, VkObjectType type, uint64_t handle, const char *name,
                 unsigned n);
VkBuffer create_buffer(struct application *app, VkDeviceSize size, VkBufferUsageFlags usage,
                       VkBufferCreateFlags flags);
enum memory_type { DEVICE_MEMORY, HOST_MEMORY }; /* of the null driver */
VkDeviceMemory allocate(struct application *app, VkDeviceSize size, enum memory_type type);
void bind_buffer(struct application *app, VkBuffer buffer, VkDeviceMemory memory,
                 VkDeviceSize offset);
VkDeviceAddress address_of(struct application *app, VkBuffer buffer);
VkAccelerationStructureKHR create_accel(struct application *app, VkBuffer buffer,
                                        VkDeviceSize offset, VkDeviceSize size,
                                        VkAccelerationStructureTypeKHR type);
VkMicromapEXT create_micromap(struct application *app, VkBuffer buffer, VkDeviceSize offset,
                              VkDeviceSize size, VkMicromapTypeEXT type);
VkQueryPool create_queries(struct application *app, VkQueryType type); /* QUERIES of them */

/* A pool with a primary and a secondary command buffer. */
void create_commands(struct application *app, VkCommandPool *pool, VkCommandBuffer *primary,
                     VkCommandBuffer *secondary);
VkResult begin_commands(const struct application *app, VkCommandBuffer commands);

/* Triangles of three floats a vertex, without indices; the first vertices are enough for one. */
VkAccelerationStructureGeometryKHR describe_triangles(VkDeviceOrHostAddressConstKHR vertices,
                                                      const void *next);

/* Of VK_NV_ray_tracing (nv.c): what it records is valid, but for the mistake. */
void create_nv(struct application *app);
void destroy_nv(struct application *app);
void record_nv(struct application *app, VkCommandBuffer command_buffer);
void mistake_nv(struct application *app, VkCommandBuffer command_buffer);

/* Of micromaps (micromaps.c): what it records is valid. */
void create_micromaps(struct application *app);
void destroy_micromaps(struct application *app);
void record_micromaps(struct application *app, VkCommandBuffer command_buffer);

void create_objects(struct application *app);
void destroy_objects(struct application *app);
void record_all(struct application *app);
void work_on_host(struct application *app);

#endif
