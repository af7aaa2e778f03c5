/* SPDX-License-Identifier: Apache-2.0 */
/* The layer's own instances and devices, and how intercepts find them.
 *
 * Both are found by dispatch key, the first pointer of every dispatchable handle. They are
 * published when their creation has succeeded and withdrawn before the call that destroys them goes
 * down, so that a key which the loader reuses never finds a dead one. The application must not
 * destroy an instance or device that another thread uses (external synchronization), so a found
 * pointer stays good for the length of a call.
 *
 * Order of locks: registry (layer.c), then the modules of src/state in any order, one at a time,
 * save that deferred operations end their work, which takes the lock of the execution order. No
 * lock is held across a call down or a message. */
#ifndef ASSAY_LAYER_LAYER_H
#define ASSAY_LAYER_LAYER_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include "src/base/reader_lock.h"
#include "src/check/call/check.h"
#include "src/report/reporter.h"
#include "src/state/builds/built_flags.h"
#include "src/state/builds/size_cache.h"
#include "src/state/commands/command_buffers.h"
#include "src/state/commands/deferred_operations.h"
#include "src/state/commands/events.h"
#include "src/state/commands/object_names.h"
#include "src/state/commands/query_pools.h"
#include "src/state/facts.h"
#include "src/state/order/order.h"
#include "src/state/resources/resources.h"

#define ASSAY_LAYER_NAME "VK_LAYER_ASSAY_validation"

/* In the list of all instances, or of all devices (layer.c). */
struct layer_link {
    struct layer_link *next;
    const void *key; /* the dispatch key */
};

struct layer_instance {
    struct layer_link link; /* first */
    VkInstance handle;
    uint32_t api_version; /* that the application asked for */
    bool has_properties2; /* it enabled VK_KHR_get_physical_device_properties2 */
    VkuInstanceDispatchTable vk;
    PFN_GetPhysicalDeviceProcAddr next_physical_device_proc_addr;
    struct reporter *reporter;
    enum backend backend;
    VkuInstanceDispatchTable next; /* backend cpu: what its commands in `vk` lie over */
};

enum { FORMAT_CACHE_SIZE = 256 };

struct layer_device {
    struct layer_link link; /* first */
    VkDevice handle;
    VkPhysicalDevice physical_device;
    struct layer_instance *instance;
    VkuDeviceDispatchTable vk;
    struct cpu_overlay *cpu;     /* backend cpu (layer/cpu/overlay.h); NULL on backend driver */
    struct snapshots *snapshots; /* of what builds read (layer/snapshots/snapshots.h), or NULL */
    struct input_checks *input_checks; /* what of them waits to be judged (contents.h), or NULL */
    struct comparer *comparer; /* setting compare_rays (layer/compare/comparer.h), or NULL */

    /* Never change after creation. */
    struct device_facts facts;
    enum level level;
    bool active_rules[COMMAND_COUNT][RULE_COUNT];
    VkPhysicalDeviceMemoryProperties memory;
    uint32_t physical_device_count; /* of its group */
    VkQueueFamilyProperties *queue_families;
    uint32_t queue_family_count;

    _Atomic bool warned_of_skipped; /* commands, see layer_find_recording_device */

    /* Each has its own lock. */
    struct resources *resources;
    struct command_buffers *command_buffers;
    struct size_cache *sizes;
    struct object_names *names;
    struct query_pools *query_pools;
    struct events *events;
    struct deferred_operations *deferred;

    /* What has been submitted; NULL below level EXECUTION. */
    struct submissions *submissions;
    struct execution_order *order;
    /* Which structures let instances disable their micromaps; NULL below level CONTENT, and without
     * opacity micromaps. */
    struct built_flags *built_flags;

    /* Memory for large calls, which one call leaves to the next. Threads of different stripes use
     * different cache lines. NULL while a call uses it. */
    union {
        struct sweep *_Atomic sweep;
        char size[READER_LOCK_STRIPE_SIZE];
    } spare_sweeps[READER_LOCK_STRIPES];

    /* enum tristate of whether builds take a VkFormat below FORMAT_CACHE_SIZE as vertices, and as
     * radii of spheres; see formats.h. */
    _Atomic unsigned char vertex_formats[FORMAT_CACHE_SIZE], radius_formats[FORMAT_CACHE_SIZE];
};

/* For the handles of intercepted commands never NULL, so only these ask: the destructions of both,
 * which take VK_NULL_HANDLE, and vkGetDeviceProcAddr, which comes before the device is published.
 * With all other commands it was the same key that led the loader to the layer. Commands that are
 * recorded look up their command buffer instead, see layer_find_recording_device. */
struct layer_instance *layer_find_instance(const void *dispatchable);
struct layer_device *layer_find_device(const void *dispatchable);

/* For handles that may be anything. The second is for reports of invalid handles: it returns the
 * device that the handle leads to, or else any device, or NULL. */
struct layer_device *layer_find_device_safely(const void *dispatchable);
struct layer_device *layer_blamed_device(const void *dispatchable);

/* The device of a command buffer, whatever the handle is. Returns NULL if no device tracks a
 * command buffer of that handle: it is VK_NULL_HANDLE, was freed, or was never allocated. The
 * command must be skipped then, for there may be nothing to read at the handle. A warning says so,
 * once a device; build commands report the handle themselves. If a device lost a record for lack of
 * memory, or is below level STATE, its dispatch key counts as well. */
struct layer_device *layer_find_recording_device(VkCommandBuffer handle);
struct layer_device *layer_find_build_device(VkCommandBuffer handle);
/* After a command buffer was allocated or freed; takes VK_NULL_HANDLE. */
void layer_forget_command_buffer(VkCommandBuffer handle);

/* Publish and withdraw. */
void layer_add_instance(struct layer_instance *instance);
void layer_remove_instance(struct layer_instance *instance);
void layer_add_device(struct layer_device *device);
void layer_remove_device(struct layer_device *device);

/* Whether a device other than this one has such a thing of that handle. */
bool layer_other_device_has_operation(const struct layer_device *device,
                                      VkDeferredOperationKHR handle);
bool layer_other_device_has(const struct layer_device *device, enum resource_kind kind,
                            uint64_t handle);

/* The loader's link information in a creation chain; NULL if it isn't there. */
VkLayerInstanceCreateInfo *layer_instance_link(const VkInstanceCreateInfo *create_info);
VkLayerDeviceCreateInfo *layer_device_link(const VkDeviceCreateInfo *create_info);

/* Fills the facts that never change: features and limits from what the application asked for in
 * `create_info` and what the physical device says (device_facts.c). */
VkResult layer_collect_device_facts(struct layer_device *device,
                                    const VkDeviceCreateInfo *create_info);

#endif
