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

extern VkuDeviceDispatchTable vk;
extern VkDevice device;
extern VkQueue queue;

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

/* With memory of its own, which the host can see. */
VkBuffer create_bound_buffer(VkDeviceSize size, VkBufferUsageFlags usage);
VkMicromapEXT create_micromap(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size,
                              VkMicromapTypeEXT type);

/* Triangles of three floats a vertex, without indices; the first vertices are enough for one. */
VkAccelerationStructureGeometryKHR describe_triangles(VkDeviceOrHostAddressConstKHR vertices,
                                                      const void *next);

void create_objects(void);
void record_all(void);

#endif
