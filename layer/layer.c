/* SPDX-License-Identifier: Apache-2.0 */
/* The registry of instances and devices. */
#include "layer.h"

#include <stdatomic.h>

#include "state/readable.h"
#include "state/reader_lock.h"

/* Static storage without constructor or destructor. The lists are linked through their members, so
 * that publishing cannot fail: it comes after the call down, and what succeeded there cannot be
 * undone (loaders free an instance twice if a layer fails then). */
static struct reader_lock registry_lock;
static struct layer_link *instances, *devices;

/* The first few devices again, by dispatch key, for look-ups without a lock. Nobody withdraws the
 * device that is looked up, so its slot stays as it is, whatever happens to the others. */
enum { QUICK_DEVICES = 8 };
static struct quick_device {
    const void *_Atomic key; /* NULL: unused */
    struct layer_device *device;
} quick_devices[QUICK_DEVICES];

/* Handles that the loader made for one instance or device begin with the same pointer. */
static const void *dispatch_key(const void *dispatchable)
{
    return dispatchable ? *(void *const *)dispatchable : NULL;
}

/* Of a handle that may be anything. */
static const void *dispatch_key_safely(const void *dispatchable)
{
    const void *key;
    return dispatchable && readable_copy(&key, dispatchable, sizeof(key)) == sizeof(key) ? key
                                                                                         : NULL;
}

/* The member that has the link, which is its first. */
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

/* The slot of a key, or NULL. */
static struct quick_device *quick_device(const void *key)
{
    for (unsigned i = 0; i < QUICK_DEVICES; i++)
        if (atomic_load_explicit(&quick_devices[i].key, memory_order_acquire) == key)
            return &quick_devices[i];
    return NULL;
}

/* Each intercept begins with this: it is inlined when the library is linked. */
inline struct layer_device *layer_find_device(const void *dispatchable)
{
    const void *key = dispatch_key(dispatchable);
    const struct quick_device *quick = key ? quick_device(key) : NULL;
    return quick ? quick->device : find(&devices, key);
}

struct layer_device *layer_find_device_safely(const void *dispatchable)
{
    return find(&devices, dispatch_key_safely(dispatchable));
}

struct layer_device *layer_any_device(void)
{
    unsigned stripe = reader_lock_enter(&registry_lock);
    struct layer_link *link = devices;
    reader_lock_leave(&registry_lock, stripe);
    return (struct layer_device *)link;
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
    if (quick)
        atomic_store_explicit(&quick->key, NULL, memory_order_release);
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
