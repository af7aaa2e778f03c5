/* SPDX-License-Identifier: Apache-2.0 */
/* Entry points by name, how often each was called, and which calls are to fail. */
#include "tests/null_driver/internal.h"

#include <stdio.h>
#include <stdlib.h>

static _Atomic uint64_t calls[ENTRY_COUNT];
static _Atomic int failures[ENTRY_COUNT];
static _Atomic uint32_t calls_left[ENTRY_COUNT]; /* to the call that fails, with it */
static atomic_bool refuses[ENTRY_COUNT];         /* each other call, beginning with the first */

VkResult entry_count(enum entry entry)
{
    const uint64_t before = atomic_fetch_add_explicit(&calls[entry], 1, memory_order_relaxed);
    if (before % 2 == 0 && atomic_load_explicit(&refuses[entry], memory_order_relaxed))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    if (atomic_load_explicit(&failures[entry], memory_order_relaxed) == VK_SUCCESS)
        return VK_SUCCESS;
    if (atomic_fetch_sub(&calls_left[entry], 1) != 1)
        return VK_SUCCESS;
    return (VkResult)atomic_exchange(&failures[entry], VK_SUCCESS);
}

static int compare(const void *a, const void *b)
{
    return strcmp(((const struct entry_point *)a)->name, ((const struct entry_point *)b)->name);
}

static const struct entry_point *find(const char *name)
{
    const struct entry_point key = {.name = name};
    return bsearch(&key, entry_points, entry_point_count, sizeof(key), compare);
}

PFN_vkVoidFunction entry_find(const char *name)
{
    const struct entry_point *entry = find(name);
    return entry != NULL ? entry->function : NULL;
}

PFN_vkVoidFunction entry_find_physical(const char *name)
{
    const struct entry_point *entry = find(name);
    return entry != NULL && entry->level == PHYSICAL ? entry->function : NULL;
}

PFN_vkVoidFunction entry_find_device(const struct object *device, const char *name)
{
    const struct entry_point *entry = find(name);
    if (entry == NULL || entry->level != DEVICE)
        return NULL;
    const bool there = entry->guard > BEFORE_EXTENSIONS
                           ? device->device.enabled[entry->guard]
                           : guard_is_offered(device->config, entry->guard);
    return there ? entry->function : NULL;
}

uint64_t null_driver_calls(const char *name)
{
    const struct entry_point *entry = find(name);
    return entry != NULL ? atomic_load(&calls[entry->entry]) : UINT64_MAX;
}

void null_driver_fail_at(const char *name, uint32_t number, VkResult result)
{
    const struct entry_point *entry = find(name);
    if (entry == NULL)
        return;
    atomic_store(&calls_left[entry->entry], number);
    atomic_store(&failures[entry->entry], result);
}

/* A program could not ask these again: what was recorded would be lost, and a result would be that
 * of the operation. */
static bool can_be_refused(const struct entry_point *entry)
{
    return entry->level == DEVICE && entry->entry != ENTRY_EndCommandBuffer &&
           entry->entry != ENTRY_GetDeferredOperationResultKHR;
}

void entry_plan_failure(void)
{
    const char *plan = getenv("NULL_DRIVER_FAILS");
    char name[64];
    unsigned number;
    int result;
    for (size_t i = 0; plan != NULL && strcmp(plan, "*") == 0 && i < entry_point_count; i++)
        atomic_store(&refuses[entry_points[i].entry], can_be_refused(&entry_points[i]));
    if (plan != NULL && sscanf(plan, "%63s %u %d", name, &number, &result) == 3)
        null_driver_fail_at(name, number, (VkResult)result);
}

void null_driver_reset(void)
{
    for (size_t i = 0; i < ENTRY_COUNT; i++) {
        atomic_store(&calls[i], 0);
        atomic_store(&failures[i], VK_SUCCESS);
    }
    null_driver_plan_fault(NULL);
    null_driver_end_hang();
    null_driver_set_device_lost(false);
    null_driver_set_executes_nothing(false);
    null_driver_set_reads_instances(false);
    null_driver_take_barriers(NULL, 0);
}
