/* SPDX-License-Identifier: Apache-2.0 */
/* The table of structures, and the allocation of their handles. */
#include "src/cpu/structures.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"
#include "src/platform/threads.h"

#define FIRST_HANDLE (1ull << 62)
#define HANDLE_ALIGNMENT 256u /* of device addresses in instances: at least 16 */
#define BUFFER_SIZE_MAX (1ull << 44)

/* The range of handles for structures of generic type in one buffer. */
struct generic_range {
    uint64_t buffer_id, begin, size;
    uint64_t structure_count;
};

struct cpu_structure {
    struct cpu_structure_info info;
    struct cpu_tree *tree; /* a reference; NULL: not built */
    struct generic_range *range;
};

struct cpu_structures {
    pthread_mutex_t watch_lock;
    struct cpu_watcher *watchers;
    struct reader_lock lock;
    struct handle_table table;  /* of struct cpu_structure */
    struct handle_table ranges; /* of struct generic_range, by the buffer's id */
};

static uint64_t reserve_addresses(uint64_t size)
{
    static _Atomic uint64_t next = FIRST_HANDLE;
    uint64_t rounded = (size + HANDLE_ALIGNMENT - 1) & ~(uint64_t)(HANDLE_ALIGNMENT - 1);
    return atomic_fetch_add_explicit(&next, rounded, memory_order_relaxed);
}

uint64_t cpu_unique_handle(void)
{
    return reserve_addresses(HANDLE_ALIGNMENT);
}

VkResult cpu_structures_create(struct cpu_structures **structures)
{
    *structures = calloc(1, sizeof(**structures));
    if (!*structures)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&(*structures)->watch_lock, NULL);
    return VK_SUCCESS;
}

static void free_structure(void *record)
{
    struct cpu_structure *structure = record;
    cpu_tree_release(structure->tree);
    free(structure);
}

void cpu_structures_destroy(struct cpu_structures *structures)
{
    if (!structures)
        return;
    handle_table_drop(&structures->table, free_structure);
    handle_table_drop(&structures->ranges, free);
    pthread_mutex_destroy(&structures->watch_lock);
    free(structures);
}

/* ---- the caller holds the lock for writing */

static bool is_in_a_buffer(const struct cpu_structure_info *info)
{
    return info->type == VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR && info->buffer_id &&
           info->buffer_size <= BUFFER_SIZE_MAX && info->offset < info->buffer_size &&
           info->offset % HANDLE_ALIGNMENT == 0;
}

static struct generic_range *range_of(struct cpu_structures *structures,
                                      const struct cpu_structure_info *info)
{
    struct generic_range *range = handle_table_find(&structures->ranges, info->buffer_id);
    if (range)
        return info->offset < range->size ? range : NULL;
    range = calloc(1, sizeof(*range));
    if (!range || !handle_table_set(&structures->ranges, info->buffer_id, range)) {
        free(range);
        return NULL;
    }
    *range = (struct generic_range){.buffer_id = info->buffer_id, .size = info->buffer_size};
    range->begin = reserve_addresses(range->size);
    return range;
}

static void leave_range(struct cpu_structures *structures, struct generic_range *range)
{
    if (!range || --range->structure_count > 0)
        return;
    handle_table_remove(&structures->ranges, range->buffer_id);
    free(range);
}

/* Returns the handle; 0 if memory runs out. */
static uint64_t add_cpu_structure(struct cpu_structures *structures,
                                  struct cpu_structure *structure)
{
    const struct cpu_structure_info *info = &structure->info;
    uint64_t handle = 0;
    if (is_in_a_buffer(info)) {
        structure->range = range_of(structures, info);
        if (!structure->range)
            return 0;
        structure->range->structure_count++;
        handle = structure->range->begin + info->offset;
    }
    /* If two structures have the same offset, the second gets another handle. */
    if (!handle || handle_table_find(&structures->table, handle))
        handle = cpu_unique_handle();
    if (handle_table_set(&structures->table, handle, structure))
        return handle;
    leave_range(structures, structure->range);
    return 0;
}

/* ---- watchers */

void cpu_structures_watch(struct cpu_structures *structures, struct cpu_watcher *watcher)
{
    pthread_mutex_lock(&structures->watch_lock);
    watcher->previous = NULL;
    watcher->next = structures->watchers;
    if (watcher->next)
        watcher->next->previous = watcher;
    structures->watchers = watcher;
    pthread_mutex_unlock(&structures->watch_lock);
}

void cpu_structures_unwatch(struct cpu_structures *structures, struct cpu_watcher *watcher)
{
    pthread_mutex_lock(&structures->watch_lock);
    if (watcher->next)
        watcher->next->previous = watcher->previous;
    if (watcher->previous)
        watcher->previous->next = watcher->next;
    else
        structures->watchers = watcher->next;
    pthread_mutex_unlock(&structures->watch_lock);
}

static void notify_watchers(struct cpu_structures *structures, uint64_t handle)
{
    pthread_mutex_lock(&structures->watch_lock);
    for (struct cpu_watcher *watcher = structures->watchers; watcher; watcher = watcher->next)
        watcher->before_change(watcher, handle);
    pthread_mutex_unlock(&structures->watch_lock);
}

/* ---- the functions below take the lock */

VkResult cpu_structures_add(struct cpu_structures *structures,
                            const struct cpu_structure_info *info, uint64_t *handle)
{
    struct cpu_structure *structure = calloc(1, sizeof(*structure));
    if (!structure)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    structure->info = *info;
    reader_lock_write(&structures->lock);
    *handle = add_cpu_structure(structures, structure);
    reader_lock_write_done(&structures->lock);
    if (*handle)
        return VK_SUCCESS;
    free(structure);
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}

void cpu_structures_remove(struct cpu_structures *structures, uint64_t handle)
{
    notify_watchers(structures, handle);
    reader_lock_write(&structures->lock);
    struct cpu_structure *structure = handle_table_remove(&structures->table, handle);
    if (structure)
        leave_range(structures, structure->range);
    reader_lock_write_done(&structures->lock);
    if (structure)
        free_structure(structure);
}

bool cpu_structures_find(struct cpu_structures *structures, uint64_t handle,
                         struct cpu_structure_info *info)
{
    unsigned stripe = reader_lock_enter(&structures->lock);
    const struct cpu_structure *structure = handle_table_find(&structures->table, handle);
    if (structure)
        *info = structure->info;
    reader_lock_leave(&structures->lock, stripe);
    return structure != NULL;
}

struct cpu_tree *cpu_structures_tree(struct cpu_structures *structures, uint64_t handle)
{
    unsigned stripe = reader_lock_enter(&structures->lock);
    const struct cpu_structure *structure = handle_table_find(&structures->table, handle);
    struct cpu_tree *tree = structure && structure->tree ? cpu_tree_keep(structure->tree) : NULL;
    reader_lock_leave(&structures->lock, stripe);
    return tree;
}

bool cpu_structures_set_tree(struct cpu_structures *structures, uint64_t handle,
                             struct cpu_tree *tree)
{
    notify_watchers(structures, handle);
    reader_lock_write(&structures->lock);
    struct cpu_structure *structure = handle_table_find(&structures->table, handle);
    struct cpu_tree *unwanted = tree;
    if (structure) {
        unwanted = structure->tree;
        structure->tree = tree;
    }
    reader_lock_write_done(&structures->lock);
    cpu_tree_release(unwanted);
    return structure != NULL;
}
