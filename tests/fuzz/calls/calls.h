/* SPDX-License-Identifier: Apache-2.0 */
/* Streams of Vulkan calls made of bytes: an application that makes every mistake which the layer is
 * held to survive. The layer lies directly over the null driver, without a loader between them.
 *
 * Objects live in slots. A slot keeps the handle of an object that was destroyed, so that later
 * calls use it. Behind the last byte all bytes are 0, and 0 always stands for something valid. Each
 * operand is taken by a statement of its own: C leaves the order within an expression open. */
#ifndef FUZZ_CALLS_H
#define FUZZ_CALLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vulkan.h>
#include <vulkan/vulkan_beta.h>

#include "layer/assay.h"
#include "tests/fixture/make.h"

/* What slots hold. */
enum kind {
    MEMORIES,
    BUFFERS,
    STRUCTURES,
    NV_STRUCTURES,
    MICROMAPS,
    POOLS,
    COMMAND_BUFFERS,
    FENCES,
    SEMAPHORES, /* the first one binary, the others timelines */
    EVENTS,
    QUERY_POOLS,
    OPERATIONS,
    KINDS,
};

enum {
    SLOTS_MAX = 8, /* of a kind */
    QUEUES = 3,
    HOST_SIZE = 1 << 16,   /* of the application's memory that builds may read */
    RESULT_SIZE = 1 << 22, /* and that copies may write */
};

/* An address that nothing has. */
#define NOWHERE ((uintptr_t)0x40000000)

struct slot {
    uint64_t handle; /* 0: there was none */
    bool is_alive;
    VkDeviceSize size;       /* of a memory or a buffer */
    VkDeviceAddress address; /* what the last query of it returned */
    unsigned char *bytes;    /* where a memory is mapped, or NULL */
};

struct calls {
    const uint8_t *at, *end;

    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkuInstanceDispatchTable instance_vk;
    VkPhysicalDevice physical;
    VkDevice device;
    VkuDeviceDispatchTable vk;
    PFN_vkTraceRaysASSAY trace;
    VkQueue queues[QUEUES];
    const char *level; /* NULL: as the first byte says */
    bool is_cpu, recycles_handles;
    VkResult status;   /* of the last call that returned one */
    VkBool32 answer;   /* of the messenger */
    bool has_no_limit; /* of equal messages */
    /* NULL, or gets each message. */
    void (*hear)(const VkDebugUtilsMessengerCallbackDataEXT *data);
    bool is_host_build, has_stride_0; /* the build in hand */

    struct slot slots[KINDS][SLOTS_MAX];
    void *created; /* what a call writes the handle to, before keep() */

    unsigned char *host, *result;     /* nothing else lies near them */
    struct build_arguments *deferred; /* of builds that may still read them */
};

/* ---- bytes */

uint8_t take(struct calls *calls); /* 0 behind the end */
uint32_t take_word(struct calls *calls);
/* Of `count` values. */
#define TAKE(calls, values) ((values)[take(calls) % (sizeof(values) / sizeof((values)[0]))])

uint64_t take_offset(struct calls *calls); /* from 0 to any */
uint64_t take_size(struct calls *calls);   /* from 4096 to any */
uint32_t take_count(struct calls *calls);  /* from 1 to any */
/* The usual one, or any. Where it is 0, any number of elements can be read, and is: counts for the
 * build are small. */
uint64_t take_stride(struct calls *calls, uint64_t usual);
uint32_t take_build_count(struct calls *calls);
uint32_t take_first_vertex(struct calls *calls);
/* In a buffer, that of the slot named or another, or anywhere. */
VkDeviceAddress take_address(struct calls *calls, uint32_t slot);
/* In the application's memory, or anywhere. */
void *take_pointer(struct calls *calls);
VkIndexType take_index_type(struct calls *calls);
VkDeviceOrHostAddressConstKHR take_data(struct calls *calls, bool is_host, uint32_t slot);

/* ---- slots; handles may be null, or of destroyed objects */

extern const uint8_t slot_counts[KINDS];
struct slot *pick(struct calls *calls, enum kind kind);
#define HANDLE_OF(type, slot) ((type)(uintptr_t)(slot)->handle)
#define PICK(type, calls, kind) HANDLE_OF(type, pick(calls, kind))

/* Gives a slot the object that was created, if it was. */
void keep(struct calls *calls, struct slot *slot, VkDeviceSize size, VkResult result);
#define CREATED(calls) ((void *)&(calls)->created)
/* The same of a command of the device that has an info and an allocator. */
#define CREATE(calls, slot, size, command, info)                                                   \
    keep(calls, slot, size, (calls)->vk.command((calls)->device, info, NULL, CREATED(calls)))

/* Of a command buffer, which may have been freed; NULL: there was none. */
VkCommandBuffer pick_commands(struct calls *calls);
/* The same, or a pointer to anywhere: for commands that the layer doesn't hand on, then. */
VkCommandBuffer pick_any_commands(struct calls *calls);

/* ---- instance and device: false where there is none */

bool calls_open(struct calls *calls);
void calls_close(struct calls *calls);
/* What an ordinary application has before it records. */
void calls_prepare(struct calls *calls);
/* The handle of the driver's, which layers below the loader see. */
PFN_vkVoidFunction calls_driver_proc_addr(VkInstance instance, const char *name);
PFN_vkVoidFunction calls_driver_device_proc_addr(VkDevice device, const char *name);
VkResult calls_set_loader_data(VkDevice device, void *object);
/* For the instance to come. Addresses begin anew; they and handles are given out again as it says.
 */
void calls_configure_driver(bool is_below_cpu, bool recycles_handles, bool recycles_addresses,
                            uint32_t joins);
/* Before the instance goes: what the driver has for its objects is used again. */
void calls_recycle_all(VkInstance instance);

/* ---- builds */

struct build_arguments {
    struct build_arguments *next;
    uint32_t count;
    VkAccelerationStructureBuildGeometryInfoKHR *infos;
    const VkAccelerationStructureBuildRangeInfoKHR **ranges; /* `count` arrays */
    void *blocks[64];
    uint32_t block_count;
};
/* Zeros; never NULL. The application allocates by this alone. */
void *calls_allocate(size_t size);
struct build_arguments *build_arguments_take(struct calls *calls, bool is_host);
void build_arguments_free(struct build_arguments *arguments);
/* Memory that lives as long as the arguments. */
void *build_block(struct build_arguments *arguments, size_t size);
/* What is chained to a geometry, or NULL. */
void *geometry_chain(struct calls *calls, struct build_arguments *arguments, bool is_host);
bool geometry_of_extension(struct calls *calls, struct build_arguments *arguments, bool is_host,
                           uint8_t kind, VkAccelerationStructureGeometryKHR *geometry);
void make_micromap_info(struct calls *calls, bool is_host, VkMicromapUsageEXT *usage,
                        VkMicromapBuildInfoEXT *info);

/* A copy of one structure to another. */
VkCopyAccelerationStructureInfoKHR take_copy(struct calls *calls);

/* ---- calls */

#define CALLS(CALL)                                                                                \
    CALL(build)                                                                                    \
    CALL(submit)                                                                                   \
    CALL(begin)                                                                                    \
    CALL(end)                                                                                      \
    CALL(wait_idle)                                                                                \
    CALL(write_data)                                                                               \
    CALL(build_indirect)                                                                           \
    CALL(submit2)                                                                                  \
    CALL(wait_fence)                                                                               \
    CALL(execute)                                                                                  \
    CALL(reset_commands)                                                                           \
    CALL(allocate_commands)                                                                        \
    CALL(free_commands)                                                                            \
    CALL(create_pool)                                                                              \
    CALL(destroy_pool)                                                                             \
    CALL(reset_pool)                                                                               \
    CALL(allocate_memory)                                                                          \
    CALL(free_memory)                                                                              \
    CALL(map_memory)                                                                               \
    CALL(create_buffer)                                                                            \
    CALL(destroy_buffer)                                                                           \
    CALL(bind_buffer)                                                                              \
    CALL(get_address)                                                                              \
    CALL(bind_sparse)                                                                              \
    CALL(create_structure)                                                                         \
    CALL(destroy_structure)                                                                        \
    CALL(get_structure_address)                                                                    \
    CALL(create_nv)                                                                                \
    CALL(destroy_nv)                                                                               \
    CALL(bind_nv)                                                                                  \
    CALL(build_nv)                                                                                 \
    CALL(copy_nv)                                                                                  \
    CALL(create_micromap)                                                                          \
    CALL(destroy_micromap)                                                                         \
    CALL(build_micromap)                                                                           \
    CALL(copy_micromap)                                                                            \
    CALL(copy_structure)                                                                           \
    CALL(serialize)                                                                                \
    CALL(deserialize)                                                                              \
    CALL(write_properties)                                                                         \
    CALL(create_query_pool)                                                                        \
    CALL(destroy_query_pool)                                                                       \
    CALL(reset_queries)                                                                            \
    CALL(copy_queries)                                                                             \
    CALL(get_queries)                                                                              \
    CALL(copy_buffer)                                                                              \
    CALL(fill_buffer)                                                                              \
    CALL(barrier)                                                                                  \
    CALL(label)                                                                                    \
    CALL(scope)                                                                                    \
    CALL(compute)                                                                                  \
    CALL(event)                                                                                    \
    CALL(create_sync)                                                                              \
    CALL(destroy_sync)                                                                             \
    CALL(use_semaphore)                                                                            \
    CALL(reset_fence)                                                                              \
    CALL(lose_device)                                                                              \
    CALL(fail_next)                                                                                \
    CALL(host_build)                                                                               \
    CALL(host_copy)                                                                                \
    CALL(host_serialize)                                                                           \
    CALL(host_deserialize)                                                                         \
    CALL(host_properties)                                                                          \
    CALL(host_micromap)                                                                            \
    CALL(operation)                                                                                \
    CALL(get_sizes)                                                                                \
    CALL(trace)                                                                                    \
    CALL(name_object)                                                                              \
    CALL(answer)

#define DECLARE_CALL(name) void call_##name(struct calls *calls);
CALLS(DECLARE_CALL)
#undef DECLARE_CALL

#endif
