/* SPDX-License-Identifier: Apache-2.0 */
/* An application on backend cpu that copes with a lack of memory: it repeats each call that fails.
 * Its objects and deeds are in several files. */
#ifndef SCARCE_APPLICATION_PARTS_H
#define SCARCE_APPLICATION_PARTS_H

#include <stdbool.h>

#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vulkan.h>

#include "tests/fixture/make.h"

/* What its messenger heard, and what went wrong. */
extern struct outcome {
    bool is_creating_instance;
    unsigned expected, found; /* what only a lack of memory may take away */
    char wrong[4096]; /* a message that should not have been, or what failed; "": all is well */
} outcome;

/* Lives once, from vkCreateInstance to vkDestroyInstance. */
void application_live(void);

enum {
    /* Of each object, so that tables grow beyond their first size, and arrays beyond what is kept
     * in place. */
    SETS = 48,
    GEOMETRIES = 20, /* of the largest build */
    NV_STRUCTURES = 24,
    QUERIES = 4,
};

struct set {
    VkAccelerationStructureKHR accel;
};

extern VkuDeviceDispatchTable vk;
extern VkDevice device;
extern VkQueue queue;

extern struct application {
    struct set sets[SETS];
    VkAccelerationStructureNV nv[NV_STRUCTURES]; /* of VK_NV_ray_tracing */
} app;

/* Asks for something that can be refused; the second time there is memory. */
#define GET(what, call)                                                                            \
    do {                                                                                           \
        VkResult get_result = (call);                                                              \
        if (get_result == VK_ERROR_OUT_OF_HOST_MEMORY)                                             \
            get_result = (call);                                                                   \
        if (get_result != VK_SUCCESS)                                                              \
            complain(what, get_result);                                                            \
    } while (0)

/* The same for a device command of that name. */
#define CALL(name, ...) GET("vk" #name, vk.name(__VA_ARGS__))

/* The same for the command that creates an object, which lives until the end. */
#define CREATE(type, info, handle)                                                                 \
    do {                                                                                           \
        CALL(Create##type, device, info, NULL, handle);                                            \
        OWN(Destroy##type, *(handle));                                                             \
    } while (0)

/* Destroys an object at the end, before those that are older: OWN(DestroyFence, fence). */
#define OWN(command, handle) own((PFN_vkVoidFunction)vk.command, (uint64_t)(handle))
void own(PFN_vkVoidFunction destroy, uint64_t handle);

/* Notes the first thing that went wrong. */
void complain(const char *what, int result);

void name_object(VkObjectType type, uint64_t handle, const char *name, unsigned n);
VkBuffer create_buffer(VkDeviceSize size, VkBufferUsageFlags usage, VkBufferCreateFlags flags);
enum memory_type { DEVICE_MEMORY, HOST_MEMORY }; /* of the null driver */
VkDeviceMemory allocate(VkDeviceSize size, enum memory_type type);
void bind_buffer(VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize offset);
/* With memory of its own. */
VkBuffer create_bound_buffer(VkDeviceSize size, VkBufferUsageFlags usage, enum memory_type type);
VkDeviceAddress address_of(VkBuffer buffer);
VkAccelerationStructureKHR create_accel(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size,
                                        VkAccelerationStructureTypeKHR type);
VkMicromapEXT create_micromap(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size,
                              VkMicromapTypeEXT type);
VkQueryPool create_queries(VkQueryType type); /* QUERIES of them */

/* A pool with a primary and a secondary command buffer. */
void create_commands(VkCommandPool *pool, VkCommandBuffer *primary, VkCommandBuffer *secondary);
VkResult begin_commands(VkCommandBuffer commands);

/* Triangles of three floats a vertex, without indices; the first vertices are enough for one. */
VkAccelerationStructureGeometryKHR describe_triangles(VkDeviceOrHostAddressConstKHR vertices,
                                                      const void *next);

/* A build or an update of a BLAS that allows updates; without scratch memory. */
VkAccelerationStructureBuildGeometryInfoKHR
describe_build(VkAccelerationStructureKHR dst, VkAccelerationStructureKHR src, uint32_t count,
               const VkAccelerationStructureGeometryKHR *geometries);

/* Of VK_NV_ray_tracing (nv.c): what it records is valid. */
void create_nv(void);
void record_nv(VkCommandBuffer command_buffer);

void create_objects(void);
void record_all(void);

#endif
