/* SPDX-License-Identifier: Apache-2.0 */
/* The registry of instances and devices. */
#include "layer/layer.h"

#include <inttypes.h>
#include <stdatomic.h>

#include "src/base/readable.h"
#include "src/base/reader_lock.h"
#include "src/base/text_buffer.h"
#include "src/platform/clock.h"
#include "src/platform/probe.h"
#include "src/platform/process.h"
#include "src/platform/threads.h"
#include "src/report/words.h"

/* Static storage without constructor or destructor. The lists are linked through their members, so
 * publishing cannot fail. It must not fail, because it follows the call down, whose success cannot
 * be undone (loaders free an instance twice if a layer fails then). */
static struct layer_link *instances, *devices;

/* A second list of the first few devices, by dispatch key, for look-ups without a lock. No thread
 * withdraws a device while another looks it up (external synchronization), so the slot of that
 * device stays unchanged. */
enum { QUICK_DEVICES = 8 };
struct quick_device {
    const void *_Atomic key; /* NULL: unused */
    struct layer_device *device;
};

/* The devices of the command buffers that were looked up last, for look-ups without a lock that do
 * not dereference the handle, which may be invalid. A word holds the handle; the bits that are 0 in
 * a pointer to an object hold the index of the device in quick_devices. 0 means unused. Freeing a
 * command buffer clears its word, so that a freed handle is not found. */
enum { OWNER_BITS = 6 };
static const uintptr_t owner_index_mask = QUICK_DEVICES - 1;

/* The kernel clears this page in the child of a fork (process_clear_on_fork()). A thread that the
 * child does not have may have held the lock, or the locks of the instances and devices. So the
 * look-ups in the child find nothing here, notice the fork, and replace all instances and devices
 * first. (Handlers of pthread_atfork() are no alternative: a library that is unloaded must not
 * register any.) */
enum { PAGE = 4096 };
enum page_state { PAGE_IS_CLEAR, PAGE_IS_BEING_FILLED, PAGE_IS_FILLED };
static _Alignas(PAGE) union {
    struct {
        _Atomic enum page_state state;
        struct reader_lock lock;
        struct quick_device quick_devices[QUICK_DEVICES];
        uintptr_t _Atomic recent_owners[1 << OWNER_BITS];
    };
    char size[PAGE];
} page;

/* Instances and devices from before a fork, which stay allocated: their locks may be held for ever,
 * and their members may be inconsistent. */
static struct layer_link *abandoned_instances, *abandoned_devices;

/* Handles that the loader created for one instance or device begin with the same pointer. */
static const void *dispatch_key(const void *dispatchable)
{
    return dispatchable ? *(void *const *)dispatchable : NULL;
}

/* Returns NULL if the handle is invalid. */
static const void *dispatch_key_safely(const void *dispatchable)
{
    const void *key;
    return dispatchable && probe_copy(&key, dispatchable, sizeof(key)) == sizeof(key) ? key : NULL;
}

/* ---- forks */

/* Replaces the members of a list. One that cannot be replaced, because memory ran out, stays. */
static struct layer_link *
replace_links(struct layer_link *list, struct layer_link *(*replacement_of)(struct layer_link *old))
{
    struct layer_link *replaced = NULL, **end = &replaced;
    for (struct layer_link *old = list, *next; old; old = next) {
        next = old->next;
        struct layer_link *link = replacement_of(old);
        *end = link ? link : old;
        (*end)->key = old->key;
        (*end)->next = NULL;
        end = &(*end)->next;
    }
    return replaced;
}

static struct layer_link *replacement_of_instance(struct layer_link *old)
{
    struct layer_instance *instance = layer_replace_instance((struct layer_instance *)old);
    return instance ? &instance->link : NULL;
}

static struct layer_link *replacement_of_device(struct layer_link *old)
{
    const struct layer_link *link = instances;
    while (link && link->key != ((struct layer_device *)old)->instance->link.key)
        link = link->next;
    struct layer_device *device =
        layer_replace_device((struct layer_device *)old, (struct layer_instance *)link);
    return device ? &device->link : NULL;
}

static void add_quick_device(struct layer_device *device);

static void replace_all(void)
{
    abandoned_instances = instances;
    abandoned_devices = devices;
    instances = replace_links(instances, replacement_of_instance);
    devices = replace_links(devices, replacement_of_device);
    for (struct layer_link *link = devices; link; link = link->next)
        add_quick_device((struct layer_device *)link);
}

/* Replacing calls commands of the next layer, and these may look up instances. Other threads of the
 * child wait. If the kernel cannot clear pages, the page is filled for good. */
__attribute__((noinline, cold)) static void fill_page(void)
{
    static _Thread_local bool is_filling;
    enum page_state found = PAGE_IS_CLEAR;
    if (!atomic_compare_exchange_strong(&page.state, &found, PAGE_IS_BEING_FILLED)) {
        while (atomic_load(&page.state) != PAGE_IS_FILLED && !is_filling)
            clock_yield();
        return;
    }
    is_filling = true;
    process_clear_on_fork(&page, sizeof(page));
    replace_all();
    is_filling = false;
    atomic_store(&page.state, PAGE_IS_FILLED);
}

static void notice_fork(void)
{
    if (atomic_load_explicit(&page.state, memory_order_acquire) != PAGE_IS_FILLED)
        fill_page();
}

static unsigned begin_reading(void)
{
    notice_fork();
    return reader_lock_enter(&page.lock);
}

static void end_reading(unsigned stripe)
{
    reader_lock_leave(&page.lock, stripe);
}

/* ---- look-ups */

/* Returns the instance or device whose first member is the link with this key. */
__attribute__((noinline)) static void *find_link(struct layer_link *const *list, const void *key)
{
    unsigned stripe = begin_reading();
    struct layer_link *link = key ? *list : NULL;
    while (link && link->key != key)
        link = link->next;
    end_reading(stripe);
    return link;
}

static void add_link(struct layer_link **list, const void *dispatchable, struct layer_link *link)
{
    notice_fork();
    reader_lock_write(&page.lock);
    link->key = dispatch_key(dispatchable);
    link->next = *list;
    atomic_signal_fence(memory_order_release); /* a fork finds a whole list at any time */
    *list = link;
    reader_lock_write_done(&page.lock);
}

static void take_out(struct layer_link **list, const struct layer_link *link)
{
    notice_fork();
    reader_lock_write(&page.lock);
    while (*list && *list != link)
        list = &(*list)->next;
    if (*list)
        *list = link->next;
    reader_lock_write_done(&page.lock);
}

struct layer_instance *layer_find_instance(const void *dispatchable)
{
    return find_link(&instances, dispatch_key(dispatchable));
}

/* The slot of a key. Returns NULL if there is none. */
static struct quick_device *quick_device(const void *key)
{
    for (unsigned i = 0; i < QUICK_DEVICES; i++)
        if (atomic_load_explicit(&page.quick_devices[i].key, memory_order_acquire) == key)
            return &page.quick_devices[i];
    return NULL;
}

struct layer_device *layer_find_device(const void *dispatchable)
{
    const void *key = dispatch_key(dispatchable);
    const struct quick_device *quick = key ? quick_device(key) : NULL;
    return quick ? quick->device : find_link(&devices, key);
}

struct layer_device *layer_find_device_safely(const void *dispatchable)
{
    return find_link(&devices, dispatch_key_safely(dispatchable));
}

struct layer_device *layer_find_reporting_device(const void *dispatchable)
{
    struct layer_device *device = layer_find_device_safely(dispatchable);
    if (device)
        return device;
    unsigned stripe = begin_reading();
    struct layer_link *link = devices;
    end_reading(stripe);
    return (struct layer_device *)link;
}

/* ---- devices of command buffers */

/* Hashed as in src/base/handle_table.c. */
static uintptr_t _Atomic *recent_owner(VkCommandBuffer handle)
{
    uint64_t hash = handle_number(handle) * 0x9e3779b97f4a7c15u;
    return &page.recent_owners[hash >> (64 - OWNER_BITS)];
}

static void remember_owner(VkCommandBuffer handle, const struct layer_device *device)
{
    const struct quick_device *quick = quick_device(device->link.key);
    if (quick && ((uintptr_t)handle & owner_index_mask) == 0)
        atomic_store_explicit(recent_owner(handle),
                              (uintptr_t)handle | (uintptr_t)(quick - page.quick_devices),
                              memory_order_release);
}

/* Searches all devices. The registry is locked so that each of them stays. */
static struct layer_device *find_owner(VkCommandBuffer handle)
{
    unsigned stripe = begin_reading();
    struct layer_link *link = devices;
    while (link && !command_buffers_find(((struct layer_device *)link)->command_buffers, handle))
        link = link->next;
    end_reading(stripe);
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
                                   command_buffers_are_unknown(device->command_buffers));
    return may_be_valid ? device : NULL;
}

struct layer_device *layer_find_build_device(VkCommandBuffer handle)
{
    uintptr_t owner = atomic_load_explicit(recent_owner(handle), memory_order_acquire);
    return handle && (owner & ~owner_index_mask) == (uintptr_t)handle
               ? page.quick_devices[owner & owner_index_mask].device
               : search_owner(handle);
}

__attribute__((cold)) static void warn_of_skipped(VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_reporting_device(handle);
    if (!device || atomic_exchange(&device->warned_of_skipped, true))
        return;
    reporter_say_warning(
        device->instance->reporter,
        "A command was to be recorded in VkCommandBuffer {}, which is not a command buffer: "
        "it was freed, or never allocated. The layer skips such commands.",
        hex(handle_number(handle)));
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
        uintptr_t owner = atomic_load_explicit(&page.recent_owners[i], memory_order_relaxed);
        if (owner && page.quick_devices + (owner & owner_index_mask) == quick)
            atomic_compare_exchange_strong(&page.recent_owners[i], &owner, 0);
    }
}

void layer_add_instance(struct layer_instance *instance)
{
    add_link(&instances, instance->handle, &instance->link);
}

void layer_remove_instance(struct layer_instance *instance)
{
    take_out(&instances, &instance->link);
}

/* The caller has locked the registry for writing, or is alone. */
static void add_quick_device(struct layer_device *device)
{
    struct quick_device *unused = quick_device(NULL);
    if (!unused)
        return;
    unused->device = device;
    atomic_store_explicit(&unused->key, device->link.key, memory_order_release);
}

void layer_add_device(struct layer_device *device)
{
    add_link(&devices, device->handle, &device->link);
    reader_lock_write(&page.lock);
    add_quick_device(device);
    reader_lock_write_done(&page.lock);
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

void layer_visit_devices(const struct layer_instance *instance,
                         void (*visit)(void *user, struct layer_device *device), void *user)
{
    unsigned stripe = begin_reading();
    for (struct layer_link *link = devices; link; link = link->next)
        if (((struct layer_device *)link)->instance == instance)
            visit(user, (struct layer_device *)link);
    end_reading(stripe);
}

bool layer_other_device_has_operation(const struct layer_device *device,
                                      VkDeferredOperationKHR handle)
{
    bool found = false;
    unsigned stripe = begin_reading();
    for (struct layer_link *link = devices; link && !found; link = link->next)
        found = link != &device->link &&
                deferred_operations_has(((struct layer_device *)link)->deferred, handle) == YES;
    end_reading(stripe);
    return found;
}

static bool has_object(const struct layer_device *device, enum resource_kind kind, uint64_t handle)
{
    struct query_pool_facts pool = {.alive = NO};
    if (kind != RESOURCE_QUERY_POOL)
        return resources_find_id(device->resources, kind, handle) != 0;
    query_pools_facts(device->query_pools, (VkQueryPool)(uintptr_t)handle, &pool);
    return pool.alive == YES;
}

bool layer_other_device_has(const struct layer_device *device, enum resource_kind kind,
                            uint64_t handle)
{
    bool found = false;
    unsigned stripe = begin_reading();
    for (struct layer_link *link = devices; link && !found; link = link->next)
        found = link != &device->link && has_object((struct layer_device *)link, kind, handle);
    end_reading(stripe);
    return found;
}
