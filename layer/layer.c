/* SPDX-License-Identifier: Apache-2.0 */
/* The registry of instances and devices. */
#include "layer/layer.h"

#include <inttypes.h>
#include <stdatomic.h>

#include "src/base/readable.h"
#include "src/base/reader_lock.h"
#include "src/base/text_buffer.h"

/* Static storage without constructor or destructor. The lists are linked through their members, so
 * publishing cannot fail. It must not fail, because it follows the call down, whose success cannot
 * be undone (loaders free an instance twice if a layer fails then). */
static struct reader_lock registry_lock;
static struct layer_link *instances, *devices;

/* A second list of the first few devices, by dispatch key, for look-ups without a lock. No thread
 * withdraws a device while another looks it up (external synchronization), so the slot of that
 * device stays unchanged. */
enum { QUICK_DEVICES = 8 };
static struct quick_device {
    const void *_Atomic key; /* NULL: unused */
    struct layer_device *device;
} quick_devices[QUICK_DEVICES];

/* The devices of the command buffers that were looked up last, for look-ups without a lock that do
 * not dereference the handle, which may be invalid. A word holds the handle; the bits that are 0 in
 * a pointer to an object hold the index of the device in quick_devices. 0 means unused. Freeing a
 * command buffer clears its word, so that a freed handle is not found. */
enum { OWNER_BITS = 6 };
static uintptr_t _Atomic recent_owners[1 << OWNER_BITS];
static const uintptr_t owner_index_mask = QUICK_DEVICES - 1;

/* Handles that the loader created for one instance or device begin with the same pointer. */
static const void *dispatch_key(const void *dispatchable)
{
    return dispatchable ? *(void *const *)dispatchable : NULL;
}

/* The same for a handle that may be invalid. */
static const void *dispatch_key_safely(const void *dispatchable)
{
    const void *key;
    return dispatchable && readable_copy(&key, dispatchable, sizeof(key)) == sizeof(key) ? key
                                                                                         : NULL;
}

/* Returns the instance or device whose first member is the link with this key. */
__attribute__((noinline)) static void *find(struct layer_link *const *list, const void *key)
{
    unsigned stripe = reader_lock_enter(&registry_lock);
    struct layer_link *link = key ? *list : NULL;
    while (link && link->key != key)
        link = link->next;
    reader_lock_leave(&registry_lock, stripe);
    return link;
}

static void add(struct layer_link **list, const void *dispatchable, struct layer_link *link)
{
    reader_lock_write(&registry_lock);
    link->key = dispatch_key(dispatchable);
    link->next = *list;
    *list = link;
    reader_lock_write_done(&registry_lock);
}

static void take_out(struct layer_link **list, const struct layer_link *link)
{
    reader_lock_write(&registry_lock);
    while (*list && *list != link)
        list = &(*list)->next;
    if (*list)
        *list = link->next;
    reader_lock_write_done(&registry_lock);
}

struct layer_instance *layer_find_instance(const void *dispatchable)
{
    return find(&instances, dispatch_key(dispatchable));
}

/* The slot of a key. Returns NULL if there is none. */
static struct quick_device *quick_device(const void *key)
{
    for (unsigned i = 0; i < QUICK_DEVICES; i++)
        if (atomic_load_explicit(&quick_devices[i].key, memory_order_acquire) == key)
            return &quick_devices[i];
    return NULL;
}

struct layer_device *layer_find_device(const void *dispatchable)
{
    const void *key = dispatch_key(dispatchable);
    const struct quick_device *quick = key ? quick_device(key) : NULL;
    return quick ? quick->device : find(&devices, key);
}

struct layer_device *layer_find_device_safely(const void *dispatchable)
{
    return find(&devices, dispatch_key_safely(dispatchable));
}

struct layer_device *layer_find_reporting_device(const void *dispatchable)
{
    struct layer_device *device = layer_find_device_safely(dispatchable);
    if (device)
        return device;
    unsigned stripe = reader_lock_enter(&registry_lock);
    struct layer_link *link = devices;
    reader_lock_leave(&registry_lock, stripe);
    return (struct layer_device *)link;
}

/* ---- devices of command buffers */

/* Hashed as in src/base/handle_table.c. */
static uintptr_t _Atomic *recent_owner(VkCommandBuffer handle)
{
    uint64_t hash = (uint64_t)(uintptr_t)handle * 0x9e3779b97f4a7c15u;
    return &recent_owners[hash >> (64 - OWNER_BITS)];
}

static void remember_owner(VkCommandBuffer handle, const struct layer_device *device)
{
    const struct quick_device *quick = quick_device(device->link.key);
    if (quick && ((uintptr_t)handle & owner_index_mask) == 0)
        atomic_store_explicit(recent_owner(handle),
                              (uintptr_t)handle | (uintptr_t)(quick - quick_devices),
                              memory_order_release);
}

/* Searches all devices. The registry is locked so that each of them stays. */
static struct layer_device *find_owner(VkCommandBuffer handle)
{
    unsigned stripe = reader_lock_enter(&registry_lock);
    struct layer_link *link = devices;
    while (link && !command_buffers_find(((struct layer_device *)link)->command_buffers, handle))
        link = link->next;
    reader_lock_leave(&registry_lock, stripe);
    return (struct layer_device *)link;
}

/* Searches for the device of a handle that was not looked up recently, or is invalid. Below level
 * STATE invalid handles are not reported, so a handle that may be valid is passed down. */
__attribute__((noinline, cold)) static struct layer_device *search_owner(VkCommandBuffer handle)
{
    struct layer_device *device = handle ? find_owner(handle) : NULL;
    if (device) {
        remember_owner(handle, device);
        return device;
    }
    device = layer_find_device_safely(handle);
    bool may_be_valid = device && (device->level < LEVEL_STATE ||
                                   command_buffers_incomplete(device->command_buffers));
    return may_be_valid ? device : NULL;
}

struct layer_device *layer_find_build_device(VkCommandBuffer handle)
{
    uintptr_t owner = atomic_load_explicit(recent_owner(handle), memory_order_acquire);
    return handle && (owner & ~owner_index_mask) == (uintptr_t)handle
               ? quick_devices[owner & owner_index_mask].device
               : search_owner(handle);
}

__attribute__((cold)) static void warn_of_skipped(VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_reporting_device(handle);
    char line[256];
    struct text_buffer text;
    if (!device || atomic_exchange(&device->warned_of_skipped, true))
        return;
    text_begin(&text, line, sizeof(line));
    text_append(&text,
                "A command was to be recorded in VkCommandBuffer %#" PRIx64
                ", which is not a command buffer: it was freed, or never allocated. The layer "
                "skips such commands.",
                (uint64_t)(uintptr_t)handle);
    reporter_warn(device->instance->reporter, line);
}

struct layer_device *layer_find_recording_device(VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_build_device(handle);
    if (!device)
        warn_of_skipped(handle);
    return device;
}

void layer_forget_command_buffer(VkCommandBuffer handle)
{
    uintptr_t _Atomic *slot = recent_owner(handle);
    uintptr_t owner = atomic_load_explicit(slot, memory_order_relaxed);
    if ((owner & ~owner_index_mask) == (uintptr_t)handle)
        atomic_compare_exchange_strong(slot, &owner, 0);
}

static void forget_owned_by(const struct quick_device *quick)
{
    for (unsigned i = 0; i < 1 << OWNER_BITS; i++) {
        uintptr_t owner = atomic_load_explicit(&recent_owners[i], memory_order_relaxed);
        if (owner && quick_devices + (owner & owner_index_mask) == quick)
            atomic_compare_exchange_strong(&recent_owners[i], &owner, 0);
    }
}

void layer_add_instance(struct layer_instance *instance)
{
    add(&instances, instance->handle, &instance->link);
}

void layer_remove_instance(struct layer_instance *instance)
{
    take_out(&instances, &instance->link);
}

void layer_add_device(struct layer_device *device)
{
    add(&devices, device->handle, &device->link);
    reader_lock_write(&registry_lock);
    struct quick_device *unused = quick_device(NULL);
    if (unused) {
        unused->device = device;
        atomic_store_explicit(&unused->key, device->link.key, memory_order_release);
    }
    reader_lock_write_done(&registry_lock);
}

void layer_remove_device(struct layer_device *device)
{
    struct quick_device *quick = quick_device(device->link.key);
    if (quick) {
        forget_owned_by(quick);
        atomic_store_explicit(&quick->key, NULL, memory_order_release);
    }
    take_out(&devices, &device->link);
}

bool layer_other_device_has_operation(const struct layer_device *device,
                                      VkDeferredOperationKHR handle)
{
    bool found = false;
    unsigned stripe = reader_lock_enter(&registry_lock);
    for (struct layer_link *link = devices; link && !found; link = link->next)
        found = link != &device->link &&
                deferred_operations_has(((struct layer_device *)link)->deferred, handle) == YES;
    reader_lock_leave(&registry_lock, stripe);
    return found;
}

bool layer_other_device_has(const struct layer_device *device, enum resource_kind kind,
                            uint64_t handle)
{
    bool found = false;
    unsigned stripe = reader_lock_enter(&registry_lock);
    for (struct layer_link *link = devices; link && !found; link = link->next)
        found = link != &device->link &&
                resources_find_id(((struct layer_device *)link)->resources, kind, handle) != 0;
    reader_lock_leave(&registry_lock, stripe);
    return found;
}
