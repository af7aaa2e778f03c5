/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver's files share: objects, entry points, guards and the current configuration. */
#ifndef NULL_DRIVER_INTERNAL_H
#define NULL_DRIVER_INTERNAL_H

#include "generated.h"
#include "null_driver.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <vulkan/vk_icd.h>

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))
#define RAW(handle) ((uint64_t)(uintptr_t)(handle))
#define HANDLE(type, value) ((type)(uintptr_t)(value))

/* ---- guards: what a command, structure or extension needs to be there */

enum guard {
    V1_0,
    V1_1,
    V1_2,
    V1_3,
    V1_4,
    NEVER,
    FIRST_EXTENSION,
    BEFORE_EXTENSIONS = FIRST_EXTENSION - 1,
#define GUARD(name, promoted) name,
    EXTENSIONS(GUARD)
#undef GUARD
        GUARD_COUNT,
    EXTENSION_COUNT = GUARD_COUNT - FIRST_EXTENSION,
};

/* "VK_KHR_..." of an extension's guard. */
const char *guard_extension_name(enum guard guard);
/* The extension is not hidden, or the version is at most that of the configuration. */
bool guard_is_offered(const struct null_driver_config *config, enum guard guard);
/* The same, or it has become part of the configuration's version. */
bool guard_is_known(const struct null_driver_config *config, enum guard guard);

/* ---- configuration */

/* A copy of the current one. */
struct null_driver_config config_current(void);

/* A structure of features: VkBool32 members behind sType and pNext. If they are also members of a
 * VkPhysicalDeviceVulkan1xFeatures, in the same order, the first of them there is its home, and
 * they share their values. generate.py makes a row for each way in which a structure is offered. */
struct feature_row {
    VkStructureType sType;
    enum guard guard;
    uint32_t end;         /* of the last member; there may be padding behind it */
    VkStructureType home; /* its own sType if it shares with none */
    uint32_t home_offset;
};
extern const struct feature_row feature_rows[];
extern const size_t feature_row_count;

/* Whether all features asked for are on; pEnabledFeatures may be NULL. */
bool features_are_on(const struct null_driver_config *config, const void *pNext,
                     const VkPhysicalDeviceFeatures *pEnabledFeatures);

/* Fixed properties (generate.py). */
extern const VkPhysicalDeviceLimits default_limits;
extern const VkPhysicalDeviceVulkan11Properties vulkan11;
extern const VkPhysicalDeviceVulkan12Properties vulkan12;
extern const VkPhysicalDeviceVulkan13Properties vulkan13;
extern const VkPhysicalDeviceVulkan14Properties vulkan14;

/* ---- objects */

struct private_value {
    VkObjectType type;
    uint64_t handle;
    uint64_t value;
};

/* What a dispatch of a shader does (compute.c, guard.c). */
struct dispatch;
typedef void shader_function(const struct dispatch *dispatch);

struct dispatch {
    shader_function *shader; /* NULL: nothing */
    uint32_t groups;
    struct {
        VkBuffer buffer; /* null: there is no condition */
        VkDeviceSize offset;
        bool is_inverted;
    } condition; /* of VK_EXT_conditional_rendering, without that of a primary command buffer */
    unsigned char constants[64];
};

/* Any Vulkan object. Lives in memory that is never unmapped, so that a freed handle can still be
 * looked at, by the loader too. The tree and the type change under the lock of object.c alone; the
 * union belongs to whoever may use the object by the rules of Vulkan. */
struct object {
    VK_LOADER_DATA loader; /* first: the loader's dispatch pointer of dispatchable objects */
    _Atomic uint64_t handle;
    VkObjectType type;
    uint32_t index;
    uint32_t generation;
    const struct null_driver_config *config; /* of the instance, while it lives */
    struct object *parent, *children, *next, *previous;
    void (*release)(struct object *object);
    union {
        struct null_driver_config *instance_config;
        struct {
            uint32_t index;
        } physical_device;
        struct {
            bool enabled[GUARD_COUNT];
        } device;
        struct {
            uint32_t family, index;
            VkDeviceQueueCreateFlags flags;
        } queue;
        struct {
            VkDeviceSize size;
            VkDeviceAddress address;
            void *host;    /* mapped so far, or imported */
            bool imported; /* host is the application's */
            bool host_visible, is_mapped;
        } memory;
        struct {
            VkDeviceSize size;
            VkBufferCreateFlags flags;
            VkBufferUsageFlags2 usage;
            VkDeviceAddress address;
            struct binding *bindings; /* the last one first */
        } buffer;
        struct {
            struct transfer *first, *last;
            struct dispatch compute; /* what is bound for compute, and pushed */
        } command_buffer;
        shader_function *shader; /* of modules and pipelines */
        VkMemoryRequirements image;
        struct {
            uint64_t buffer;
            VkDeviceSize offset;
            VkDeviceAddress fallback; /* where there is no buffer, or it has no address */
        } as;
        struct {
            VkDeviceSize primitives;
            VkDeviceSize compacted;
            VkDeviceAddress address;
        } as_nv;
        struct {
            uint32_t joins_left;
        } deferred;
        _Atomic uint64_t value; /* of a fence, a semaphore or an event */
        VkQueryType query_type;
        struct {
            struct private_value *values;
            size_t count;
        } private_data;
    };
};

/* As realloc(). The driver allocates by this alone, so that a test can have the layer's allocations
 * fail, but not these. */
void *driver_allocate(void *old, size_t size);

/* Returns NULL when out of memory. release, if any, is called when the object goes, with the lock
 * of object.c held. */
struct object *object_create(struct object *parent, VkObjectType type,
                             void (*release)(struct object *));
/* The handles of count objects without state; VK_NULL_HANDLE when out of memory. */
VkResult objects_create(struct object *parent, VkObjectType type, uint32_t count, void *handles);
/* The object behind a live non-dispatchable handle of that type, else NULL. */
struct object *object_find(uint64_t handle, VkObjectType type);
#define FIND(type, handle) object_find(RAW(handle), VK_OBJECT_TYPE_##type)
/* Destroys it and what was made from it; ignores handles that are not live. */
void object_destroy(uint64_t handle, VkObjectType type);
void object_destroy_dispatchable(void *handle, VkObjectType type);
/* The child of that number, counted from 0, in order of creation; else NULL. */
struct object *object_child(struct object *parent, VkObjectType type, uint32_t number);
/* Whether there is a live object of the type for which is_wanted(object, wanted). */
bool object_any(VkObjectType type, bool (*is_wanted)(const struct object *, const void *),
                const void *wanted);

#define OBJECT(dispatchable) ((struct object *)(dispatchable))
#define CONFIG(dispatchable) (OBJECT(dispatchable)->config)

/* ---- addresses: 64 KiB aligned, never 0, with a gap behind each range */

/* One that was released, where the configuration says so; with NULL never. */
VkDeviceAddress address_allocate(const struct null_driver_config *config, VkDeviceSize size);
void address_release(const struct null_driver_config *config, VkDeviceAddress address,
                     VkDeviceSize size);
/* While nothing has an address: from where the next ones are given out. */
void address_start_over(VkDeviceAddress first);

/* From now on the addresses are those of a memory or of a sparse buffer, until it is removed. */
void address_add_object(const struct object *object, VkDeviceAddress address, VkDeviceSize size);
void address_remove_object(const struct object *object);
/* As buffer_bytes(). */
unsigned char *address_bytes(VkDeviceAddress address, VkDeviceSize *size);

/* ---- shared by several entry points */

static inline VkDeviceSize align_up(VkDeviceSize value, VkDeviceSize alignment)
{
    return (value + alignment - 1) / alignment * alignment;
}

/* A structure of an application's pNext chain, or NULL. */
static inline const void *chain_find(const void *pNext, VkStructureType sType)
{
    const VkBaseInStructure *in = pNext;
    while (in != NULL && in->sType != sType)
        in = in->pNext;
    return in;
}

/* A part of a buffer, and the memory that is bound there. */
struct binding {
    struct binding *next;
    VkDeviceSize offset, size;
    uint64_t memory;
    VkDeviceSize memory_offset;
};
void buffer_bind(struct object *buffer, const struct binding *binding);

/* The bytes of live memory from an offset on, made when they are first asked for: at most *size of
 * them, which it cuts to how many there are. NULL where there are none. */
unsigned char *memory_bytes(struct object *memory, VkDeviceSize offset, VkDeviceSize *size);
/* The same of a buffer, as it is bound: *size bytes that lie one behind the other. */
unsigned char *buffer_bytes(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize *size);
bool buffer_has_usage(VkBuffer buffer, VkBufferUsageFlags2 usage); /* also no buffer */
/* Whether a buffer with that usage has the address. */
bool address_has_usage(VkDeviceAddress address, VkBufferUsageFlags2 usage);

/* Lets the device write bytes to an address. */
void transfers_add_write(VkCommandBuffer commands, VkDeviceAddress address, const void *bytes,
                         VkDeviceSize size);
/* Records a dispatch of one of the layer's shaders; and carries it out. */
void transfers_add_dispatch(VkCommandBuffer commands, const struct dispatch *dispatch);
void dispatch_execute(const struct dispatch *dispatch);

void guard_execute(const struct dispatch *dispatch);
/* Whether the first of these ranges, pairs of addresses, that has the address has all bytes. */
bool ranges_contain(VkDeviceAddress ranges, uint32_t count, VkDeviceAddress address,
                    VkDeviceSize size);
/* Words of an instance of this VkAccelerationStructureMotionInstanceTypeNV; 0: there is none. */
uint32_t instance_words(uint32_t type);

/* Bytes of memory by their addresses. False where not all of it has memory; what has is copied. */
bool address_read(VkDeviceAddress address, void *bytes, VkDeviceSize size);
void address_write(VkDeviceAddress address, const void *bytes, VkDeviceSize size);

/* The instances of a build (builds.c). */
struct instances {
    VkBuffer buffer;       /* of VK_NV_ray_tracing, where data is an offset; else null */
    VkDeviceAddress data;  /* without the offset of an indirect range */
    VkDeviceAddress range; /* 0: the count is known */
    uint32_t count;
    bool are_pointers, have_motion;
    bool are_partitioned; /* data is operations, range their number */
};
/* Records a build at which a fault may happen. */
void transfers_add_build(VkCommandBuffer commands);
/* Records a build that reads instances; and reads them. */
void transfers_add_instances(VkCommandBuffer commands, const struct instances *instances);
void instances_read(const struct instances *instances);

/* Does what the command buffer's commands do to buffers. Returns false if the device is lost, or
 * hangs, at one of its builds. */
bool transfers_execute(VkCommandBuffer commands);
void transfers_release(struct object *commands);

/* What is behind sType and pNext of a structure that has both (`is_chained`), or all of it. */
static inline void fill_with_zeros(void *result, size_t size, bool is_chained)
{
    const size_t kept = is_chained ? sizeof(VkBaseOutStructure) : 0;
    memset((char *)result + kept, 0, size - kept);
}

/* The two calls of every enumeration: copies the members named by from, of which there are
 * available, of size bytes each, to where count says there is room. */
VkResult enumerate(uint32_t *count, void *to, const void *from, uint32_t available, size_t size);

/* What a property query of a built acceleration structure or micromap answers. */
enum { STRUCTURE_SIZE = 4096, COMPACTED_SIZE = 2048, SERIALIZED_SIZE = 4096 };
void query_write(uint32_t count, VkQueryType type, size_t size, void *data, size_t stride);

/* Completes a host command at once, or leaves that to the deferred operation's joins. */
VkResult deferred_start(VkDevice device, VkDeferredOperationKHR operation);

uint32_t requirements_types(const struct null_driver_config *config, VkMemoryPropertyFlags required,
                            VkMemoryPropertyFlags refused);

/* Raises the value of a semaphore, or of a fence, which has 1 when it is signaled. */
void sync_signal(uint64_t handle, VkObjectType type, uint64_t value);
void sync_wake(void);
VkResult sync_wait_idle(void); /* waits while the device hangs */
bool device_is_lost(void);

/* Planned faults (fault.c). The functions return whether one happens now. */
bool fault_is_at_build(void); /* whether builds are recorded */
bool fault_at_submit(void);
void fault_at_wait(uint64_t timeout);
bool fault_at_build(void);
bool fault_before_copies(void); /* of the next build, if that is the planned place */
bool device_hangs(void);
enum null_driver_progress hang_progress(void); /* NULL_DRIVER_STANDS if the device does not hang */
bool loss_is_at_once(void);
/* Keeps a submission until the hang ends. `commands` has the command buffers of `info`. */
void fault_keep(const VkSubmitInfo2 *info, const VkCommandBuffer *commands, VkFence fence);

/* ---- stages that submissions name, for tests */

void barriers_note_submission(const VkSubmitInfo2 *info);
void barriers_note_old_submission(const VkSubmitInfo *info);

/* ---- entry points
 *
 * generate.py makes a function entry_NAME for each command that the registry has of the versions
 * and extensions offered. It counts the call, and calls null_NAME unless the call is to fail. Of
 * null_NAME it makes a weak definition: does what its table says, creates or destroys an object
 * without state, asks the newer form of a query, fills its result with zeros, enumerates nothing,
 * lets a deferred operation start, or does nothing and succeeds. COMMAND(NAME) in a file here
 * replaces it.
 */

enum entry {
#define ENTRY(name) ENTRY_##name,
    ENTRIES(ENTRY)
#undef ENTRY
        ENTRY_COUNT,
};

#define ENTRY(name) __typeof__(*(PFN_vk##name)NULL) null_##name;
ENTRIES(ENTRY)
#undef ENTRY

/* Defines null_NAME: COMMAND(CreateDevice) { ... }. The parameters have the registry's names. */
#define COMMAND(name) COMMAND_##name

/* Defines what a command that creates one object does to it before the application has its handle:
 * ON_CREATION(CreateFence) { ... }. The parameters are `object` and pCreateInfo. */
#undef CreateEvent /* macros of <windows.h> */
#undef CreateSemaphore
#define ON_CREATION(name) ON_CREATION_##name
#define CREATION(name) ON_CREATION(name);
CREATIONS(CREATION)
#undef CREATION

enum entry_level { INSTANCE, PHYSICAL, DEVICE };

/* A name of a command. The guard is the core version, or the extension to enable, with which
 * vkGetDeviceProcAddr gives the command. */
struct entry_point {
    const char *name;
    PFN_vkVoidFunction function;
    enum entry entry;
    enum entry_level level;
    enum guard guard;
};
extern const struct entry_point entry_points[]; /* sorted by name */
extern const size_t entry_point_count;

/* Counts a call; the failure that was asked for, else VK_SUCCESS. */
VkResult entry_count(enum entry entry);
void entry_plan_failure(void); /* as the environment says: null_driver.h */
PFN_vkVoidFunction entry_find(const char *name);
PFN_vkVoidFunction entry_find_physical(const char *name);
PFN_vkVoidFunction entry_find_device(const struct object *device, const char *name);

#endif
