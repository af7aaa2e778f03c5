/* SPDX-License-Identifier: Apache-2.0 */
/* Entry points by name, how often each was called, and which one is to fail next. */
#include "internal.h"

#include <stdlib.h>
#include <string.h>

enum level { INSTANCE, PHYSICAL, DEVICE };

struct entry_point {
    const char *name;
    PFN_vkVoidFunction function;
    enum entry entry;
    enum level level;
    enum guard guard;
};

static _Atomic uint64_t calls[ENTRY_COUNT];
static _Atomic int failures[ENTRY_COUNT];

VkResult entry_count(enum entry entry)
{
    atomic_fetch_add_explicit(&calls[entry], 1, memory_order_relaxed);
    if (atomic_load_explicit(&failures[entry], memory_order_relaxed) == VK_SUCCESS)
        return VK_SUCCESS;
    return (VkResult)atomic_exchange(&failures[entry], VK_SUCCESS);
}

/* They take no parameters, as they look at none: with the calling conventions of every platform
 * that this is built for, a caller may pass any, and may ignore the result. */
#define NO_OP(name, guard)                                                                         \
    static VkResult no_op_##name(void)                                                             \
    {                                                                                              \
        return entry_count(ENTRY_##name);                                                          \
    }
#include "no_ops.h"
#undef NO_OP

#define ENTRY(level, name, guard)                                                                  \
    {"vk" #name, (PFN_vkVoidFunction)null_##name, ENTRY_##name, level, guard},
#define ALIAS(level, name, target, guard)
#define NO_OP(name, guard)                                                                         \
    {"vk" #name, (PFN_vkVoidFunction)no_op_##name, ENTRY_##name, DEVICE, guard},
static const struct entry_point entry_points[] = {
#include "entry_points.h"
#include "no_ops.h"
};
#undef ENTRY
#undef ALIAS
#undef NO_OP

#define ENTRY(level, name, guard)
#define ALIAS(level, name, target, guard) {"vk" #name, NULL, ENTRY_##target, level, guard},
static const struct entry_point aliases[] = {
#include "entry_points.h"
};
#undef ENTRY
#undef ALIAS

/* All of both, sorted by name on first use. */
static struct entry_point sorted[COUNT_OF(entry_points) + COUNT_OF(aliases)];
static pthread_once_t sorted_once = PTHREAD_ONCE_INIT;

static int compare(const void *a, const void *b)
{
    return strcmp(((const struct entry_point *)a)->name, ((const struct entry_point *)b)->name);
}

static void sort(void)
{
    memcpy(sorted, entry_points, sizeof(entry_points));
    for (size_t i = 0; i < COUNT_OF(aliases); i++) {
        /* entry_points has them in the order of the enumeration. */
        struct entry_point alias = aliases[i];
        alias.function = entry_points[alias.entry].function;
        sorted[COUNT_OF(entry_points) + i] = alias;
    }
    qsort(sorted, COUNT_OF(sorted), sizeof(sorted[0]), compare);
}

static const struct entry_point *find(const char *name)
{
    pthread_once(&sorted_once, sort);
    const struct entry_point key = {.name = name};
    return bsearch(&key, sorted, COUNT_OF(sorted), sizeof(sorted[0]), compare);
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

void null_driver_fail_next(const char *name, VkResult result)
{
    const struct entry_point *entry = find(name);
    if (entry != NULL)
        atomic_store(&failures[entry->entry], result);
}

void null_driver_reset(void)
{
    for (size_t i = 0; i < ENTRY_COUNT; i++) {
        atomic_store(&calls[i], 0);
        atomic_store(&failures[i], VK_SUCCESS);
    }
    null_driver_set_device_lost(false);
    null_driver_set_executes_nothing(false);
}
