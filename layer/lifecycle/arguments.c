/* SPDX-License-Identifier: Apache-2.0 */
/* The helpers of the checked functions, which are included. */
#include "layer/lifecycle/arguments.h"

#include <string.h>

#include "layer/cpu/commands.h"
#include "layer/hazards/commands.h"
#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"
#include "layer/snapshots/commands.h"
#include "layer/snapshots/snapshots.h"
#include "src/base/readable.h"
#include "vuid-tables/registry.h"

/* ---- memory */

static bool array_is_readable(struct readable_cache *cache, const void *array, uint64_t count,
                              size_t size)
{
    uint64_t bytes;
    return !count || (array && !__builtin_mul_overflow(count, size, &bytes) && bytes <= SIZE_MAX &&
                      readable(cache, array, (size_t)bytes));
}

/* Reads page by page. */
static bool string_is_readable(struct readable_cache *cache, const char *string)
{
    const uintptr_t page = (uintptr_t)1 << READABLE_PAGE_SHIFT;
    for (const char *at = string; at;) {
        size_t size = page - (uintptr_t)at % page;
        if (!readable(cache, at, size))
            return false;
        if (memchr(at, '\0', size))
            return true;
        at += size;
    }
    return false;
}

static bool strings_are_readable(struct readable_cache *cache, const char *const *strings,
                                 uint64_t count)
{
    if (!array_is_readable(cache, strings, count, sizeof(*strings)))
        return false;
    for (uint64_t i = 0; i < count; i++)
        if (!string_is_readable(cache, strings[i]))
            return false;
    return true;
}

/* Pointers to one element each. */
static bool pointers_are_readable(struct readable_cache *cache, const void *pointers,
                                  uint64_t count, size_t size)
{
    const void *const *all = pointers;
    if (!array_is_readable(cache, pointers, count, sizeof(*all)))
        return false;
    for (uint64_t i = 0; i < count; i++)
        if (!array_is_readable(cache, all[i], 1, size))
            return false;
    return true;
}

bool arguments_can_read_string(const char *string)
{
    return string_is_readable(readable_cache_of_thread(), string);
}

/* ---- chains */

static bool chained_is_readable(struct readable_cache *cache, const void *chained);

static bool chain_is_readable(struct readable_cache *cache, const void *chain)
{
    for (const VkBaseInStructure *s = chain; s; s = s->pNext) {
        if (!readable(cache, s, sizeof(*s)))
            return false;
        const struct registry_structure *structure = registry_find_structure(s->sType);
        if (structure && !readable(cache, s, structure->size))
            return false;
        if (!chained_is_readable(cache, s))
            return false;
    }
    return true;
}

/* ---- the next layer's commands. NULL: the call is skipped. */

static const VkuInstanceDispatchTable *next_of_instance(const void *dispatchable)
{
    const struct layer_instance *instance = layer_find_instance(dispatchable);
    return instance && instance->backend == BACKEND_DRIVER ? &instance->vk : NULL;
}

static const VkuDeviceDispatchTable *next_of(const struct layer_device *device)
{
    if (!device || device->cpu)
        return NULL;
    return device->snapshots ? &device->snapshots->next : &device->vk;
}

static const VkuDeviceDispatchTable *next_of_device(const void *dispatchable)
{
    return next_of(layer_find_device(dispatchable));
}

static const VkuDeviceDispatchTable *next_of_recording(VkCommandBuffer handle)
{
    return next_of(layer_find_recording_device(handle));
}

/* ---- checked functions */

struct checked_command {
    PFN_vkVoidFunction command, checked;
};

#include "argument_checks.h"

PFN_vkVoidFunction arguments_checked(PFN_vkVoidFunction command)
{
    for (size_t i = 0; i < sizeof(checked_commands) / sizeof(checked_commands[0]); i++)
        if (checked_commands[i].command == command)
            return checked_commands[i].checked;
    return command;
}
