/* SPDX-License-Identifier: Apache-2.0 */
/* The table of command pools and command buffers, and lists of recordings that depend on a
 * secondary command buffer. */
#include "src/state/commands/command_buffers.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"
#include "src/base/unknown.h"

void dependents_release(struct dependents *dependents); /* invalidates them first */

struct validity *validity_create(void)
{
    struct validity *validity = malloc(sizeof(*validity));
    if (!validity)
        return NULL;
    atomic_init(&validity->references, 1);
    atomic_init(&validity->invalidated, false);
    return validity;
}

void validity_release(struct validity *validity)
{
    if (validity && atomic_fetch_sub_explicit(&validity->references, 1, memory_order_acq_rel) == 1)
        free(validity);
}

static void dependents_init(struct dependents *dependents)
{
    *dependents = (struct dependents){.items = NULL};
    pthread_mutex_init(&dependents->lock, NULL);
}

void dependents_release(struct dependents *dependents)
{
    dependents_invalidate(dependents);
    free(dependents->items);
    pthread_mutex_destroy(&dependents->lock);
}

/* Removes recordings that no longer exist, so that the list of a secondary that is executed again
 * and again does not grow without bound. */
static void prune_dependents(struct dependents *dependents)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < dependents->count; i++) {
        struct validity *validity = dependents->items[i];
        if (atomic_load_explicit(&validity->references, memory_order_acquire) == 1)
            validity_release(validity);
        else
            dependents->items[kept++] = validity;
    }
    dependents->count = kept;
}

/* Grows the list if pruning leaves it more than half full, so that pruning stays rare. */
static bool reserve_dependent(struct dependents *dependents)
{
    if (dependents->count < dependents->capacity)
        return true;
    prune_dependents(dependents);
    if (dependents->count < dependents->capacity / 2)
        return true;
    uint32_t capacity = dependents->capacity ? dependents->capacity * 2 : 4;
    struct validity **items = realloc(dependents->items, capacity * sizeof(struct validity *));
    if (!items)
        return dependents->count < dependents->capacity;
    dependents->items = items;
    dependents->capacity = capacity;
    return true;
}

void dependents_add(struct dependents *dependents, struct validity *validity)
{
    pthread_mutex_lock(&dependents->lock);
    uint32_t count = dependents->count;
    bool is_there = count && dependents->items[count - 1] == validity;
    if (!is_there && reserve_dependent(dependents)) {
        atomic_fetch_add_explicit(&validity->references, 1, memory_order_relaxed);
        dependents->items[dependents->count++] = validity;
    }
    pthread_mutex_unlock(&dependents->lock);
}

/* Reads `count` without the lock: the application must not execute a command buffer while it
 * records it again. */
void dependents_invalidate(struct dependents *dependents)
{
    if (!dependents->count)
        return;
    pthread_mutex_lock(&dependents->lock);
    while (dependents->count) {
        struct validity *validity = dependents->items[--dependents->count];
        atomic_store_explicit(&validity->invalidated, true, memory_order_relaxed);
        validity_release(validity);
    }
    pthread_mutex_unlock(&dependents->lock);
}

/* ---- the table of command pools and command buffers */

enum { RECENT_BITS = 6 };

struct command_buffers {
    struct reader_lock lock; /* guards the tables, the lists of the pools, unused, and unknown */
    struct handle_table pools, buffers;
    struct command_buffer *unused; /* records of removed command buffers, for reuse */
    uint32_t last_id;
    struct unknown unknown; /* memory ran out for a record */
    /* The records found last, by hashes of handles. Commands come in long runs for a few command
     * buffers, so most look-ups end here, without the lock. */
    struct command_buffer *_Atomic recent[1 << RECENT_BITS];
};

VkResult command_buffers_create(struct command_buffers **command_buffers)
{
    *command_buffers = calloc(1, sizeof(**command_buffers));
    if (!*command_buffers)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    return VK_SUCCESS;
}

/* Hold the lock for writing here and in the functions below. */
static void keep_for_reuse(struct command_buffers *command_buffers, struct command_buffer *record)
{
    record->next = command_buffers->unused;
    command_buffers->unused = record;
}

static void retire_command_buffer(struct command_buffers *command_buffers,
                                  struct command_buffer *command_buffer)
{
    atomic_store_explicit(&command_buffer->handle, VK_NULL_HANDLE, memory_order_release);
    label_stack_clear(&command_buffer->labels);
    dependents_release(&command_buffer->dependents);
    validity_release(command_buffer->validity);
    structures_release(&command_buffer->known);
    journal_release(command_buffer->journal);
    free(command_buffer->early_bindings);
    keep_for_reuse(command_buffers, command_buffer);
}

/* Returns an empty record without a handle; NULL if memory runs out. */
static struct command_buffer *take_record(struct command_buffers *command_buffers)
{
    struct command_buffer *record = command_buffers->unused;
    if (!record)
        return calloc(1, sizeof(*record));
    command_buffers->unused = record->next;
    memset(&record->pool, 0, sizeof(*record) - offsetof(struct command_buffer, pool));
    return record;
}

static void free_pool(void *record, void *context)
{
    struct command_pool *pool = record;
    while (pool->first) {
        struct command_buffer *command_buffer = pool->first;
        pool->first = command_buffer->next;
        retire_command_buffer(context, command_buffer);
    }
    free(pool);
}

void command_buffers_destroy(struct command_buffers *command_buffers)
{
    if (!command_buffers)
        return;
    handle_table_each(&command_buffers->pools, free_pool, command_buffers);
    handle_table_release(&command_buffers->pools);
    handle_table_release(&command_buffers->buffers);
    while (command_buffers->unused) {
        struct command_buffer *record = command_buffers->unused;
        command_buffers->unused = record->next;
        free(record);
    }
    free(command_buffers);
}

/* Pools. */

/* Removes a pool and its command buffers from the tables. */
static struct command_pool *take_out_pool(struct command_buffers *command_buffers,
                                          VkCommandPool handle)
{
    struct command_pool *pool = handle_table_remove(&command_buffers->pools, handle_number(handle));
    for (struct command_buffer *b = pool ? pool->first : NULL; b; b = b->next)
        handle_table_remove(&command_buffers->buffers, handle_number(b->handle));
    return pool;
}

void command_buffers_add_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                              uint32_t queue_family, VkQueueFlags queue_flags, bool is_protected)
{
    struct command_pool *pool = malloc(sizeof(*pool));
    if (pool)
        *pool = (struct command_pool){.handle = handle,
                                      .queue_family = queue_family,
                                      .queue_flags = queue_flags,
                                      .is_protected = is_protected};
    reader_lock_write(&command_buffers->lock);
    struct command_pool *old = take_out_pool(command_buffers, handle);
    if (!pool || !handle_table_set(&command_buffers->pools, handle_number(handle), pool)) {
        unknown_set(&command_buffers->unknown, UNKNOWN_COMMAND_BUFFERS);
        free(pool);
    }
    if (old)
        free_pool(old, command_buffers);
    reader_lock_write_done(&command_buffers->lock);
}

void command_buffers_remove_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                                 void (*removed)(void *user, VkCommandBuffer handle), void *user)
{
    reader_lock_write(&command_buffers->lock);
    struct command_pool *pool = take_out_pool(command_buffers, handle);
    reader_lock_write_done(&command_buffers->lock);
    if (!pool)
        return;
    for (const struct command_buffer *b = pool->first; b; b = b->next)
        removed(user, b->handle);
    reader_lock_write(&command_buffers->lock);
    free_pool(pool, command_buffers);
    reader_lock_write_done(&command_buffers->lock);
}

void command_buffers_reset_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                                bool releases)
{
    unsigned stripe = reader_lock_enter(&command_buffers->lock);
    struct command_pool *pool = handle_table_find(&command_buffers->pools, handle_number(handle));
    for (struct command_buffer *b = pool ? pool->first : NULL; b; b = b->next)
        command_buffer_reset(b, releases, VK_SUCCESS);
    reader_lock_leave(&command_buffers->lock, stripe);
}

/* Command buffers. */

static void unlink_from_pool(struct command_buffer *command_buffer)
{
    if (command_buffer->previous)
        command_buffer->previous->next = command_buffer->next;
    else
        command_buffer->pool->first = command_buffer->next;
    if (command_buffer->next)
        command_buffer->next->previous = command_buffer->previous;
}

static void link_to_pool(struct command_buffer *command_buffer, struct command_pool *pool)
{
    command_buffer->pool = pool;
    command_buffer->next = pool->first;
    if (pool->first)
        pool->first->previous = command_buffer;
    pool->first = command_buffer;
}

static void remove_command_buffer(struct command_buffers *command_buffers, VkCommandBuffer handle)
{
    struct command_buffer *old =
        handle_table_remove(&command_buffers->buffers, handle_number(handle));
    if (!old)
        return;
    unlink_from_pool(old);
    retire_command_buffer(command_buffers, old);
}

static void add_command_buffer(struct command_buffers *command_buffers, struct command_pool *pool,
                               VkCommandBufferLevel level, VkCommandBuffer handle)
{
    remove_command_buffer(command_buffers, handle);
    struct command_buffer *new = pool ? take_record(command_buffers) : NULL;
    if (!new || !handle_table_set(&command_buffers->buffers, handle_number(handle), new)) {
        unknown_set(&command_buffers->unknown, UNKNOWN_COMMAND_BUFFERS);
        if (new)
            keep_for_reuse(command_buffers, new);
        return;
    }
    new->level = level;
    new->facts = (struct command_buffer_facts){.handle = handle,
                                               .id = ++command_buffers->last_id,
                                               .alive = YES,
                                               .state = COMMAND_BUFFER_INITIAL,
                                               .is_protected = pool->is_protected ? YES : NO,
                                               .queue_flags = pool->queue_flags};
    dependents_init(&new->dependents);
    link_to_pool(new, pool);
    atomic_store_explicit(&new->handle, handle, memory_order_release);
}

void command_buffers_add(struct command_buffers *command_buffers, VkCommandPool pool,
                         VkCommandBufferLevel level, uint32_t count, const VkCommandBuffer *handles)
{
    reader_lock_write(&command_buffers->lock);
    struct command_pool *owner = handle_table_find(&command_buffers->pools, handle_number(pool));
    for (uint32_t i = 0; i < count; i++)
        add_command_buffer(command_buffers, owner, level, handles[i]);
    reader_lock_write_done(&command_buffers->lock);
}

void command_buffers_remove(struct command_buffers *command_buffers, uint32_t count,
                            const VkCommandBuffer *handles)
{
    reader_lock_write(&command_buffers->lock);
    for (uint32_t i = 0; i < count; i++)
        remove_command_buffer(command_buffers, handles[i]);
    reader_lock_write_done(&command_buffers->lock);
}

/* Uses the hash of src/base/handle_table.c. */
static struct command_buffer *_Atomic *recent_slot(struct command_buffers *command_buffers,
                                                   VkCommandBuffer handle)
{
    uint64_t hash = handle_number(handle) * 0x9e3779b97f4a7c15u;
    return &command_buffers->recent[hash >> (64 - RECENT_BITS)];
}

__attribute__((noinline)) static struct command_buffer *
look_up(struct command_buffers *command_buffers, VkCommandBuffer handle)
{
    unsigned stripe = reader_lock_enter(&command_buffers->lock);
    struct command_buffer *found =
        handle_table_find(&command_buffers->buffers, handle_number(handle));
    reader_lock_leave(&command_buffers->lock, stripe);
    if (found)
        atomic_store_explicit(recent_slot(command_buffers, handle), found, memory_order_release);
    return found;
}

struct command_buffer *command_buffers_find(struct command_buffers *command_buffers,
                                            VkCommandBuffer handle)
{
    struct command_buffer *recent =
        atomic_load_explicit(recent_slot(command_buffers, handle), memory_order_acquire);
    bool matches =
        recent && handle && atomic_load_explicit(&recent->handle, memory_order_acquire) == handle;
    return matches ? recent : look_up(command_buffers, handle);
}

bool command_buffers_are_unknown(struct command_buffers *command_buffers)
{
    unsigned stripe = reader_lock_enter(&command_buffers->lock);
    const bool is_unknown = unknown_is_set(&command_buffers->unknown);
    reader_lock_leave(&command_buffers->lock, stripe);
    return is_unknown;
}

void command_buffers_set_unknown(struct command_buffers *command_buffers)
{
    reader_lock_write(&command_buffers->lock);
    unknown_set(&command_buffers->unknown, UNKNOWN_COMMAND_BUFFERS);
    reader_lock_write_done(&command_buffers->lock);
}

/* Sets the facts of a handle without a record. */
__attribute__((cold)) static void set_unknown_facts(struct command_buffers *command_buffers,
                                                    VkCommandBuffer handle,
                                                    struct command_buffer_facts *facts)
{
    const bool is_unknown = command_buffers_are_unknown(command_buffers);
    *facts = (struct command_buffer_facts){.handle = handle, .alive = is_unknown ? UNKNOWN : NO};
}

void command_buffers_facts(struct command_buffers *command_buffers,
                           const struct command_buffer *command_buffer, VkCommandBuffer handle,
                           struct command_buffer_facts *facts)
{
    if (!command_buffer) {
        set_unknown_facts(command_buffers, handle, facts);
        return;
    }
    *facts = command_buffer->facts;
    if (command_buffer->facts.state != COMMAND_BUFFER_RECORDING)
        facts->in_render_pass = facts->in_video_coding = facts->suspended = UNKNOWN;
    if (command_buffer->validity &&
        atomic_load_explicit(&command_buffer->validity->invalidated, memory_order_relaxed))
        facts->state = COMMAND_BUFFER_INVALID;
}

struct label_stack *command_buffers_labels(struct command_buffers *command_buffers,
                                           VkCommandBuffer handle)
{
    struct command_buffer *found = command_buffers_find(command_buffers, handle);
    return found ? &found->labels : NULL;
}
