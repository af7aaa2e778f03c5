/* SPDX-License-Identifier: Apache-2.0 */
/* The registry of instances and devices. */
#include "layer.h"

#include "state/handle_table.h"
#include "state/reader_lock.h"

/* Static storage without constructor or destructor: the tables are empty, and hold no memory, when
 * the last instance is gone and the loader unloads the library. */
static struct reader_lock registry_lock = READER_LOCK_INITIALIZER;
static struct handle_table instances, devices;

/* Handles that the loader made for one instance or device begin with the same pointer. */
static uint64_t dispatch_key(const void *dispatchable)
{
    return dispatchable ? (uint64_t)(uintptr_t) * (void *const *)dispatchable : 0;
}

static void *find(const struct handle_table *table, const void *dispatchable)
{
    uint64_t key = dispatch_key(dispatchable);
    unsigned stripe = reader_lock_enter(&registry_lock);
    void *record = handle_table_find(table, key);
    reader_lock_leave(&registry_lock, stripe);
    return record;
}

static VkResult add(struct handle_table *table, const void *dispatchable, void *record)
{
    reader_lock_write(&registry_lock);
    bool added = handle_table_set(table, dispatch_key(dispatchable), record);
    reader_lock_write_done(&registry_lock);
    return added ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

static void take_out(struct handle_table *table, const void *dispatchable)
{
    reader_lock_write(&registry_lock);
    handle_table_remove(table, dispatch_key(dispatchable));
    if (!table->count)
        handle_table_release(table);
    reader_lock_write_done(&registry_lock);
}

struct layer_instance *layer_find_instance(const void *dispatchable)
{
    return find(&instances, dispatchable);
}

struct layer_device *layer_find_device(const void *dispatchable)
{
    return find(&devices, dispatchable);
}

VkResult layer_add_instance(struct layer_instance *instance)
{
    return add(&instances, instance->handle, instance);
}

void layer_remove_instance(struct layer_instance *instance)
{
    take_out(&instances, instance->handle);
}

VkResult layer_add_device(struct layer_device *device)
{
    return add(&devices, device->handle, device);
}

void layer_remove_device(struct layer_device *device)
{
    take_out(&devices, device->handle);
}

struct accel_search {
    const struct layer_device *except;
    VkAccelerationStructureKHR handle;
    bool found;
};

static void search_device(void *record, void *context)
{
    struct layer_device *device = record;
    struct accel_search *search = context;
    if (device != search->except && resources_has_accel(device->resources, search->handle))
        search->found = true;
}

bool layer_other_device_has_accel(const struct layer_device *device,
                                  VkAccelerationStructureKHR handle)
{
    struct accel_search search = {.except = device, .handle = handle};
    unsigned stripe = reader_lock_enter(&registry_lock);
    handle_table_each(&devices, search_device, &search);
    reader_lock_leave(&registry_lock, stripe);
    return search.found;
}
