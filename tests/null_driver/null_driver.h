/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The null driver as tests see it: how to configure it, make it fail, and count what reached it.
 *
 * A test names the driver's manifest in VK_DRIVER_FILES, loads the same libVkICD_null.so with
 * null_driver_load (which keeps it and its state in memory while the loader comes and goes), and
 * configures it before vkCreateInstance. An instance and all that is made from it keep the
 * configuration that was current when the instance was created.
 *
 * For a process that cannot load it: NULL_DRIVER_FAILS="vkAllocateMemory 3 -2" makes the third such
 * call behind each vkCreateInstance return -2, which is VK_ERROR_OUT_OF_DEVICE_MEMORY. "*" makes
 * each other call of the commands of devices return VK_ERROR_OUT_OF_HOST_MEMORY, beginning with the
 * first, except those that cannot be called again.
 */
#ifndef NULL_DRIVER_H
#define NULL_DRIVER_H

#include <dlfcn.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

enum {
    NULL_DRIVER_PHYSICAL_DEVICES = 2, /* all alike, in one group */
    NULL_DRIVER_MAX_EXTENSIONS = 32,
    NULL_DRIVER_MAX_FEATURES = 64,
    NULL_DRIVER_MAX_QUEUE_FAMILIES = 8,
    NULL_DRIVER_MAX_FORMATS = 64,
};

/* One feature set to something else than on: the VkBool32 at an offset of a feature structure.
 * Core features are members of VkPhysicalDeviceFeatures2. A feature that is a member of several
 * structures (VkPhysicalDeviceVulkan12Features and its own) is the same in all, by any name. */
struct null_driver_feature {
    VkStructureType sType;
    uint32_t offset;
    VkBool32 value;
};

/* Serialized data that the driver can read: a header alone. */
struct null_driver_serialized {
    char versions[2][VK_UUID_SIZE];
    uint64_t size, deserialized_size, reference_count;
};
#define NULL_DRIVER_SERIALIZED                                                                     \
    ((struct null_driver_serialized){                                                              \
        {"null driver", "null driver"}, sizeof(struct null_driver_serialized), 1, 0})

/* Buffer features of a format; they come with VK_FORMAT_FEATURE_VERTEX_BUFFER_BIT. */
struct null_driver_format {
    VkFormat format;
    VkFormatFeatureFlags2 buffer_features;
};

struct null_driver_config {
    uint32_t api_version; /* of the driver and its devices; default 1.3 */

    /* The driver offers all extensions that generate.py lists; hidden ones are taken away (with
     * their features, properties and commands), extra ones are added by name alone. Strings are not
     * copied. */
    const char *hidden_extensions[NULL_DRIVER_MAX_EXTENSIONS];
    uint32_t hidden_extension_count;
    const char *extra_extensions[NULL_DRIVER_MAX_EXTENSIONS];
    uint32_t extra_extension_count;

    /* All features of known structures are on, save for these. */
    struct null_driver_feature features[NULL_DRIVER_MAX_FEATURES];
    uint32_t feature_count;

    /* Limits. sType and pNext are ignored, and so is properties.apiVersion. */
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceAccelerationStructurePropertiesKHR as_properties;
    VkPhysicalDeviceRayTracingPropertiesNV nv_properties;
    VkPhysicalDeviceProtectedMemoryProperties protected_properties;
    VkPhysicalDeviceRayTracingPipelinePropertiesKHR pipeline_properties;
    VkPhysicalDeviceOpacityMicromapPropertiesEXT micromap_properties;
    VkPhysicalDeviceOpacityMicromapPropertiesKHR micromap_properties_khr;
#ifdef VK_NV_displacement_micromap
    VkPhysicalDeviceDisplacementMicromapPropertiesNV displacement_properties;
#endif
    VkPhysicalDeviceClusterAccelerationStructurePropertiesNV cluster_properties;
    VkPhysicalDevicePartitionedAccelerationStructurePropertiesNV partition_properties;

    /* Default types: 0 device local (multi-instance heap), 1 host visible and coherent, 2 the same
     * and cached, 3 device local and host visible, 4 protected, 5 lazily allocated. */
    VkPhysicalDeviceMemoryProperties memory;

    /* Default families: 0 graphics, compute, transfer, sparse binding, 2 queues; 1 compute and
     * transfer, 2 queues; 2 transfer only; 3 graphics, compute, transfer, protected; 4 transfer and
     * video decode. */
    VkQueueFamilyProperties queue_families[NULL_DRIVER_MAX_QUEUE_FAMILIES];
    uint32_t queue_family_count;

    /* Default: the formats that the specification makes mandatory as vertices of an acceleration
     * structure, and two that radii of spheres may have. All others have no buffer features. */
    struct null_driver_format formats[NULL_DRIVER_MAX_FORMATS];
    uint32_t format_count;

    /* Updates, and builds of micromaps, need no scratch memory; sizes do not grow with the number
     * of primitives. Default false. */
    bool needs_no_scratch, sizes_are_constant;

    /* Host commands with a deferred operation return VK_OPERATION_DEFERRED_KHR and complete at this
     * join (earlier ones return VK_THREAD_IDLE_KHR); 0: they return
     * VK_OPERATION_NOT_DEFERRED_KHR and have completed. Default 1. */
    uint32_t deferred_joins;

    /* A destroyed object's handle, or a freed memory's addresses, are given to the next one that
     * fits; else none is ever given out twice. Default false. */
    bool recycle_handles;
    bool recycle_addresses;

    /* Nothing can be read for 1 MiB before mapped memory and 16 GiB behind it. Default false. */
    bool has_gaps;
};

static inline void null_driver_set_feature(struct null_driver_config *config, VkStructureType sType,
                                           size_t offset, VkBool32 value)
{
    if (config->feature_count < NULL_DRIVER_MAX_FEATURES) {
        config->features[config->feature_count++] =
            (struct null_driver_feature){sType, (uint32_t)offset, value};
    }
}

static inline void null_driver_hide_extension(struct null_driver_config *config, const char *name)
{
    if (config->hidden_extension_count < NULL_DRIVER_MAX_EXTENSIONS) {
        config->hidden_extensions[config->hidden_extension_count++] = name;
    }
}

/* What goes wrong, once: at the n-th call that submits command buffers, at the n-th wait (whose
 * timeout is not 0), or at the n-th build command that is executed. Plan it before the builds are
 * recorded: only then are they executed at all. */
enum null_driver_place { NULL_DRIVER_AT_SUBMIT, NULL_DRIVER_AT_WAIT, NULL_DRIVER_AT_BUILD };
enum null_driver_event {
    NULL_DRIVER_LOSE,  /* the device is lost, as by set_device_lost */
    NULL_DRIVER_HANG,  /* nothing is executed or signaled any more; all waits go on */
    NULL_DRIVER_CRASH, /* a signal */
};
struct null_driver_fault {
    enum null_driver_event kind;
    enum null_driver_place at;
    uint32_t number;   /* from 1; 0 is 1 */
    bool skips_copies; /* at a build: it happens before the copies and dispatches in front of it */
    /* If the address is not 0, vkGetDeviceFaultInfoEXT returns these after a loss. */
    VkDeviceAddress address;
    VkDeviceSize precision;
    VkDeviceFaultAddressTypeEXT address_type;
    int signal; /* of a crash; 0: SIGSEGV, by writing to an address without memory */
    /* What each wait does while the device hangs, before it times out. */
    enum null_driver_progress {
        NULL_DRIVER_STANDS,
        NULL_DRIVER_COMPUTES, /* uses processor time */
        NULL_DRIVER_SIGNALS,  /* signals the first fence of several, or counts semaphores up by 1 */
    } progress;
    bool is_at_once; /* of a loss: the call that submits the build returns it */
    bool in_thread;  /* the crash is that of a thread of the driver, for which the call waits */
};

/* Stages and accesses of a barrier or subpass dependency; of vkCmdPipelineBarrier without barriers,
 * the stages alone. Commands with one mask of stages have it in `src`; submissions have stages that
 * wait in `dst`, those that signal in `src`. */
struct null_driver_barrier {
    VkPipelineStageFlags2 src, dst;
    VkAccessFlags2 src_access, dst_access;
    VkBuffer buffer; /* null: of a memory barrier */
    /* The size of a buffer barrier or an address range, the new layout of an image barrier, or the
     * subpass that a dependency leads to. */
    uint64_t detail;
    const void *masks; /* where the driver read them, only to compare; null: a parameter had them */
    uint64_t builds;   /* build calls before, but for indirect ones */
};

/* What the library exports. Names are entry points' names ("vkCreateBuffer"); the aliases of a
 * command (KHR, EXT) count and fail as one with it. */
/* clang-format off */
#define NULL_DRIVER_FUNCTIONS(FUNCTION)                                                            \
    FUNCTION(struct null_driver_config, default_config, (void))                                    \
    /* NULL: the default. */                                                                       \
    FUNCTION(void, configure, (const struct null_driver_config *config))                           \
    /* One of the next calls of a command that returns VkResult, number 1 is the next, returns     \
     * this one and does nothing. */                                                               \
    FUNCTION(void, fail_at, (const char *name, uint32_t number, VkResult result))                  \
    /* While true, submits, waits and status queries return VK_ERROR_DEVICE_LOST. */               \
    FUNCTION(void, set_device_lost, (bool lost))                                                   \
    /* While true, submissions complete and nothing in them is executed, as on a mock driver. */   \
    FUNCTION(void, set_executes_nothing, (bool executes_nothing))                                  \
    /* While true, recorded builds of top-level structures read the references of their instances  \
     * when they execute; their parameters must be valid. */                                       \
    FUNCTION(void, set_reads_instances, (bool reads))                                              \
    /* The references that were read since the last call, in the order of the builds; UINT64_MAX   \
     * where an instance has no memory. Returns their number. */                                   \
    FUNCTION(uint32_t, take_references, (uint64_t *references, uint32_t capacity))                 \
    /* The first barriers since the last call, or since the reset. Returns their number. */        \
    FUNCTION(uint32_t, take_barriers, (struct null_driver_barrier *barriers, uint32_t capacity))   \
    /* NULL: nothing is planned any more. */                                                       \
    FUNCTION(void, plan_fault, (const struct null_driver_fault *fault))                            \
    /* Executes what was submitted since the device hung, the submission that hung from its        \
     * beginning; unless the device is lost. */                                                    \
    FUNCTION(void, end_hang, (void))                                                               \
    /* Calls that reached the driver since the last reset, failed ones included; UINT64_MAX for a  \
     * name that it does not have. */                                                              \
    FUNCTION(uint64_t, calls, (const char *name))                                                  \
    /* Queries of the address of a structure whose buffer is not bound, or lacks                   \
     * VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, since the library was loaded. */                 \
    FUNCTION(uint64_t, invalid_queries, (void))                                                    \
    /* Bytes of device memory that are allocated. */                                               \
    FUNCTION(uint64_t, allocated, (void))                                                          \
    /* Sets all counts to 0, forgets pending and planned failures and the lost device, ends a      \
     * hang, and executes again. */                                                                \
    FUNCTION(void, reset, (void))
/* clang-format on */

#define NULL_DRIVER_MEMBER(result, name, parameters) result(*name) parameters;
struct null_driver_api {
    NULL_DRIVER_FUNCTIONS(NULL_DRIVER_MEMBER)
};
#define NULL_DRIVER_EXPORT(result, name, parameters)                                               \
    __attribute__((visibility("default"))) result null_driver_##name parameters;
NULL_DRIVER_FUNCTIONS(NULL_DRIVER_EXPORT)

/* Returns what dlopen returned; NULL, with dlerror set, where something is missing. */
static inline void *null_driver_load(const char *path, struct null_driver_api *api)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    bool is_whole = library != NULL;
#define NULL_DRIVER_FIND(result, name, parameters)                                                 \
    is_whole = is_whole && (*(void **)&api->name = dlsym(library, "null_driver_" #name)) != NULL;
    NULL_DRIVER_FUNCTIONS(NULL_DRIVER_FIND)
    if (!is_whole && library != NULL)
        dlclose(library);
    return is_whole ? library : NULL;
}

#endif
