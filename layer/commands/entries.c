/* SPDX-License-Identifier: Apache-2.0 */
/* The entries, which are generated and included, with what they call; and how they are found. */
#include "layer/commands/commands.h"

#include <string.h>

#include "arguments.h"
#include "layer/hazards/recording.h"
#include "layer/intercepts/intercepts.h"
#include "layer/intercepts/lower.h"
#include "layer/postmortem/postmortem.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/base/recording_path.h"
#include "src/state/commands/bound_shaders.h"
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

static inline bool strings_are_readable(struct readable_cache *cache, const char *const *strings,
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
static inline bool pointers_are_readable(struct readable_cache *cache, const void *pointers,
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

bool command_can_read_string(const char *string)
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

/* ---- the next layer's commands, for calls that the layer does not learn of. NULL: such a call is
 * skipped. */

static inline const VkuInstanceDispatchTable *
unchecked_instance(const struct layer_instance *instance)
{
    return instance && instance->backend == BACKEND_DRIVER ? &instance->vk : NULL;
}

static inline const VkuDeviceDispatchTable *unchecked_device(const struct layer_device *device)
{
    if (!device || device->cpu)
        return NULL;
    return device->snapshots ? &device->snapshots->next : &device->vk;
}

/* ---- entries */

enum command_scope {
    OF_LOADER, /* vkGetInstanceProcAddr returns them without an instance */
    OF_INSTANCE,
    OF_DEVICE,
};

struct command_entry {
    const char *name;
    enum command_scope scope;
    bool is_supplied;                                         /* backend cpu supplies it */
    enum build_command column;                                /* COMMAND_COUNT: no rule */
    size_t member;                                            /* its place in the dispatch table */
    PFN_vkVoidFunction by_conditions[COMMAND_CONDITION_SETS]; /* NULL: nothing observes it */
};

#include "entries.h"

static int compare_to_entry(const void *name, const void *entry)
{
    return strcmp(name, ((const struct command_entry *)entry)->name);
}

/* An application asks for some 600 commands a device. */
static const struct command_entry *find_command_entry(const char *name)
{
    return bsearch(name, entries, sizeof(entries) / sizeof(entries[0]), sizeof(entries[0]),
                   compare_to_entry);
}

PFN_vkVoidFunction command_of_loader(const char *name, bool has_instance)
{
    const struct command_entry *entry = find_command_entry(name);
    return entry && (entry->scope == OF_LOADER || !has_instance) ? entry->by_conditions[0] : NULL;
}

static unsigned conditions_of(const struct layer_instance *instance)
{
    const struct settings *settings = reporter_settings(instance->reporter);
    return (settings->hazards ? WITH_HAZARDS : 0) |
           (settings->call_sites == CALL_SITES_OFF ? 0 : WITH_CALL_SITES);
}

/* What the table of an instance or a device holds: the next layer's command, or what replaces it.
 */
static PFN_vkVoidFunction in_table(const void *table, const struct command_entry *entry)
{
    PFN_vkVoidFunction command;
    memcpy(&command, (const char *)table + entry->member, sizeof(command));
    return command;
}

/* Which devices copy inputs, or have active rules, is unknown: the entries that use snapshots look
 * whether there are any. */
PFN_vkVoidFunction command_of_instance(const struct layer_instance *instance, const char *name)
{
    const bool has_backend = instance->backend == BACKEND_CPU;
    const unsigned conditions =
        conditions_of(instance) | WITH_CONTENT | WITH_CHECKS | (has_backend ? WITH_BACKEND : 0);
    const struct command_entry *entry = find_command_entry(name);
    PFN_vkVoidFunction own = entry ? entry->by_conditions[conditions] : NULL;
    PFN_vkVoidFunction next = instance->vk.GetInstanceProcAddr(instance->handle, name);
    if (own)
        return next || (has_backend && entry->is_supplied) ? own : NULL;
    return next && entry && entry->scope == OF_INSTANCE ? in_table(&instance->vk, entry) : next;
}

PFN_vkVoidFunction command_of_device(const struct layer_device *device, const char *name)
{
    const struct command_entry *entry = find_command_entry(name);
    const bool is_checked =
        entry && entry->column != COMMAND_COUNT && device->checks[entry->column];
    const unsigned conditions = conditions_of(device->instance) |
                                (device->snapshots ? WITH_CONTENT : 0) |
                                (device->cpu ? WITH_BACKEND : 0) | (is_checked ? WITH_CHECKS : 0);
    if (!entry || entry->scope != OF_DEVICE)
        return device->vk.GetDeviceProcAddr(device->handle, name);
    PFN_vkVoidFunction own = entry->by_conditions[conditions], next = in_table(&device->vk, entry);
    return next && own ? own : next;
}
