/* SPDX-License-Identifier: Apache-2.0 */
/* The layer's own instances and devices, and how intercepts find them.
 *
 * Both are found by dispatch key, the first pointer of every dispatchable handle. They are
 * published after their creation has succeeded and withdrawn before the destruction goes down,
 * because the loader may reuse the key afterwards. The application must not destroy an instance or
 * device that another thread uses (external synchronization), so a pointer that was found stays
 * valid for the length of a call.
 *
 * Order of locks: the registry (layer.c), then the modules of src/state, one at a time. One
 * exception: deferred operations end their work with their lock held, which takes the lock of the
 * execution order. None of these locks is held across a call down or a message. */
#ifndef ASSAY_LAYER_LAYER_H
#define ASSAY_LAYER_LAYER_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include "src/base/reader_lock.h"
#include "src/check/call/check.h"
#include "src/report/reported_queries.h"
#include "src/report/reporter.h"
#include "src/state/builds/places.h"
#include "src/state/builds/size_cache.h"
#include "src/state/builds/structures.h"
#include "src/state/commands/command_buffers.h"
#include "src/state/commands/deferred_operations.h"
#include "src/state/commands/events.h"
#include "src/state/commands/label_stack.h"
#include "src/state/commands/object_names.h"
#include "src/state/commands/query_pools.h"
#include "src/state/facts.h"
#include "src/state/order/order.h"
#include "src/state/resources/destroyed.h"
#include "src/state/resources/resources.h"

#define ASSAY_LAYER_NAME "VK_LAYER_ASSAY_validation"
#define ASSAY_LAYER_DESCRIPTION "Validates acceleration-structure builds"

struct call_sites;
struct hazard_objects;

/* A member of the list of all instances, or of the list of all devices (layer.c). */
struct layer_link {
    struct layer_link *next;
    const void *key; /* the dispatch key */
};

struct layer_instance {
    struct layer_link link; /* first */
    VkInstance handle;
    uint32_t api_version; /* VkApplicationInfo::apiVersion */
    bool has_properties2; /* VK_KHR_get_physical_device_properties2 is enabled */
    bool is_below_layer;  /* another layer has created it, and calls on its own account, too */
    VkuInstanceDispatchTable vk;
    PFN_GetPhysicalDeviceProcAddr next_physical_device_proc_addr;
    struct reporter *reporter;
    enum backend_setting backend;
    VkuInstanceDispatchTable down; /* backend cpu: the commands that it replaces in `vk` */
    struct { /* limits = harsh: the commands that layer/harsh.c replaces in `vk` */
        PFN_vkGetPhysicalDeviceProperties2 get_properties2;
        PFN_vkGetPhysicalDeviceProperties2KHR get_properties2_khr;
    } harsh;
};

enum { FORMAT_CACHE_SIZE = 256 };

struct layer_device {
    struct layer_link link; /* first */
    VkDevice handle;
    VkPhysicalDevice physical_device;
    struct layer_instance *instance;
    VkuDeviceDispatchTable vk;
    struct cpu_overlay *cpu; /* backend cpu (layer/cpu/overlay.h); NULL on backend driver */
    struct {                 /* limits = harsh: the commands that layer/harsh.c replaces in `vk` */
        PFN_vkGetAccelerationStructureBuildSizesKHR get_build_sizes;
        PFN_vkGetMicromapBuildSizesEXT get_micromap_sizes;
        PFN_vkGetAccelerationStructureMemoryRequirementsNV get_requirements_nv;
    } harsh;
    struct snapshots *snapshots;       /* inputs of builds (layer/snapshots/snapshots.h), or NULL */
    struct input_checks *input_checks; /* snapshots to be validated (input_checks.h), or NULL */
    struct attached_consumer *consumers; /* of executed builds (layer/consumers.h), or NULL */

    /* Setting hazards: a pipeline has been created, or a command recorded, whose shaders may write
     * buffers. */
    atomic_bool shaders_write;
    /* The application may know sizes of structures from queries that the layer did not follow. */
    atomic_bool sizes_may_be_unknown;

    _Atomic uint64_t frame; /* calls of vkQueuePresentKHR */

    /* Never change after creation. */
    struct device_facts facts;
    enum level level;
    bool active_rules[COMMAND_COUNT][RULE_COUNT];
    bool checks[COMMAND_COUNT];                  /* a rule about the command is active */
    bool finds_hazards;                          /* setting hazards */
    bool records_builds;                         /* setting record_builds */
    bool notes_figures;                          /* the same, or a consumer needs them */
    const struct build_recorder *build_recorder; /* for journals; NULL below level EXECUTION */
    VkPhysicalDeviceMemoryProperties memory;
    bool is_on_processor;      /* VK_PHYSICAL_DEVICE_TYPE_CPU */
    bool may_query_structures; /* sizes and addresses of acceleration structures */
    VkQueueFamilyProperties *queue_families;
    uint32_t queue_family_count;

    atomic_bool loss_reported, hang_reported; /* see layer/postmortem/ */
    _Atomic bool warned_of_skipped;           /* see layer_find_recording_device */

    /* Each has its own lock. */
    struct resources *resources;
    struct command_buffers *command_buffers;
    struct size_cache *sizes;
    struct size_queries *size_queries; /* of the application */
    struct places *places; /* NULL unless an extension builds structures without handles */
    struct destroyed_objects *destroyed;
    struct object_names *names;
    struct queue_labels *queue_labels;
    struct query_pools *query_pools;
    struct update_templates *update_templates; /* NULL without memory */
    struct events *events;
    struct deferred_operations *deferred;

    /* Structures in execution order, submissions, and their order; NULL below level EXECUTION,
     * except that backend cpu always has them. */
    struct structures *structures;
    struct submissions *submissions;
    struct query_writes *query_writes; /* NULL below EXECUTION, and without memory */
    struct execution_order *order;
    struct submitted_builds *submitted_builds; /* for reports of a loss; NULL below EXECUTION */
    struct hazard_checks *hazard_checks;       /* NULL if setting hazards is off */
    struct host_writes *host_writes;           /* the same */
    struct hazard_objects *hazard_objects; /* NULL if setting hazards is off, and without memory */
    struct reported_queries reported_queries; /* findings about queries of sizes */
    /* From where build commands are called; NULL if setting call_sites is off, and without memory.
     */
    struct call_sites *call_sites;

    /* Memory that a large call leaves to the next one; NULL while a call uses it. Each stripe of
     * threads has its own, in cache lines of its own. */
    union {
        struct sweep *_Atomic sweep;
        char size[READER_LOCK_STRIPE_SIZE];
    } spare_sweeps[READER_LOCK_STRIPES];

    /* Values of enum tristate: whether builds support a VkFormat below FORMAT_CACHE_SIZE for
     * vertices, and for radii of spheres; see physical_device.h. */
    _Atomic unsigned char vertex_formats[FORMAT_CACHE_SIZE], radius_formats[FORMAT_CACHE_SIZE];
};

/* Find by dispatch key.
 *
 * Return NULL only in two cases: for a destruction of VK_NULL_HANDLE, and for vkGetDeviceProcAddr
 * before the device is published. For all other commands the loader found the layer by the same
 * key. Commands that are recorded look up their command buffer instead, see
 * layer_find_recording_device. */
struct layer_instance *layer_find_instance(const void *dispatchable);
struct layer_device *layer_find_device(const void *dispatchable);

/* For handles that may be invalid. layer_find_reporting_device() returns the device on which to
 * report an invalid handle: the device that the handle leads to, or else any device, or NULL. */
struct layer_device *layer_find_device_safely(const void *dispatchable);
struct layer_device *layer_find_reporting_device(const void *dispatchable);

/* The device of a command buffer, which may be an invalid handle. Returns NULL if no device tracks
 * a command buffer of that handle: the handle is VK_NULL_HANDLE, was freed, or was never allocated.
 * The intercept must then skip the command, because the handle may point to unreadable memory.
 * layer_find_recording_device() warns about that, once for each device; build commands use
 * layer_find_build_device() and report the handle themselves. If a device has no record for lack of
 * memory, or is below level STATE, its dispatch key also identifies it. */
struct layer_device *layer_find_recording_device(VkCommandBuffer handle);
struct layer_device *layer_find_build_device(VkCommandBuffer handle);
/* Called after a command buffer was allocated or freed; accepts VK_NULL_HANDLE. */
void layer_forget_command_buffer(VkCommandBuffer handle);

/* Publish and withdraw. */
void layer_add_instance(struct layer_instance *instance);
void layer_remove_instance(struct layer_instance *instance);
void layer_add_device(struct layer_device *device);
void layer_remove_device(struct layer_device *device);
/* Calls `visit` for each device of the instance, with the registry locked. */
void layer_visit_devices(const struct layer_instance *instance,
                         void (*visit)(void *user, struct layer_device *device), void *user);

/* Whether a device other than this one has an object of that handle. */
bool layer_other_device_has_operation(const struct layer_device *device,
                                      VkDeferredOperationKHR handle);
bool layer_other_device_has(const struct layer_device *device, enum resource_kind kind,
                            uint64_t handle);

/* Replace an instance or device of the parent process in the child of a fork
 * (layer/lifecycle/forks.c). Read nothing but what never changes. Return NULL if memory runs out.
 */
struct layer_instance *layer_replace_instance(const struct layer_instance *old);
struct layer_device *layer_replace_device(const struct layer_device *old,
                                          struct layer_instance *instance);

/* Allocates a device and what it needs at each level; and frees a device that is not published. */
struct layer_device *layer_allocate_device(void);
void layer_free_device(struct layer_device *device);
VkResult layer_track_submissions(struct layer_device *device);
VkResult layer_register_consumers(struct layer_device *device);

/* What messages say of a call of the application on the device, and of a command that was recorded
 * in a command buffer and submitted: `entry` is the origin of an entry of its journal, and
 * `first_build` the number of builds that were recorded before the command. */
struct call_origin layer_origin(const struct layer_device *device);
struct call_origin layer_origin_of(const struct layer_device *device,
                                   const struct submission_origin *submission,
                                   const struct journal *journal, uint32_t first_build,
                                   uint32_t entry);

/* The loader's link information in a creation chain: a structure of type
 * VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO, or of VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO.
 * Returns NULL if the chain lacks it. */
void *layer_link(const void *chain, VkStructureType type);

/* Fills the facts that never change: extensions, features and limits, from `create_info` and the
 * physical device (device_facts.c). */
VkResult layer_collect_device_facts(struct layer_device *device,
                                    const VkDeviceCreateInfo *create_info);

#endif
