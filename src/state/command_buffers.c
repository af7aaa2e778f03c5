/* SPDX-License-Identifier: Apache-2.0 */
/* The table of command pools and command buffers. */
#include "state/command_buffers.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "state/handle_table.h"
#include "state/reader_lock.h"

struct command_buffers {
    struct reader_lock lock; /* guards the tables, the lists of the pools, and incomplete */
    struct handle_table pools, buffers;
    bool incomplete; /* a record was lost for lack of memory */
    _Atomic uint64_t epoch;
};

/* An epoch is a time in which no command buffer of its table goes; no two tables ever have the same
 * one. While it lasts, what a thread found last is there: commands come in long runs for one
 * command buffer, and need no lock. */
static _Atomic uint64_t last_epoch;
static _Thread_local struct found_command_buffer {
    uint64_t epoch;
    VkCommandBuffer handle;
    struct command_buffer *record;
} last_found;

static void begin_epoch(struct command_buffers *command_buffers)
{
    uint64_t epoch = atomic_fetch_add_explicit(&last_epoch, 1, memory_order_relaxed) + 1;
    atomic_store_explicit(&command_buffers->epoch, epoch, memory_order_release);
}

VkResult command_buffers_create(struct command_buffers **command_buffers)
{
    *command_buffers = calloc(1, sizeof(**command_buffers));
    if (!*command_buffers)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    reader_lock_init(&(*command_buffers)->lock);
    begin_epoch(*command_buffers);
    return VK_SUCCESS;
}

static void free_command_buffer(struct command_buffer *command_buffer)
{
    label_stack_clear(&command_buffer->labels);
    dependents_release(&command_buffer->dependents);
    validity_release(command_buffer->validity);
    build_states_release(&command_buffer->known);
    journal_release(command_buffer->journal);
    free(command_buffer);
}

static void free_pool(void *record, void *context)
{
    struct command_pool *pool = record;
    (void)context;
    while (pool->first) {
        struct command_buffer *command_buffer = pool->first;
        pool->first = command_buffer->next;
        free_command_buffer(command_buffer);
    }
    free(pool);
}

void command_buffers_destroy(struct command_buffers *command_buffers)
{
    if (!command_buffers)
        return;
    handle_table_each(&command_buffers->pools, free_pool, NULL);
    handle_table_release(&command_buffers->pools);
    handle_table_release(&command_buffers->buffers);
    reader_lock_destroy(&command_buffers->lock);
    free(command_buffers);
}

/* Pools. */

/* Takes a pool and its command buffers out of the tables. */
static struct command_pool *take_out_pool(struct command_buffers *command_buffers,
                                          VkCommandPool handle)
{
    struct command_pool *pool =
        handle_table_remove(&command_buffers->pools, (uint64_t)(uintptr_t)handle);
    if (pool && pool->first)
        begin_epoch(command_buffers);
    for (struct command_buffer *b = pool ? pool->first : NULL; b; b = b->next)
        handle_table_remove(&command_buffers->buffers, (uint64_t)(uintptr_t)b->handle);
    return pool;
}

void command_buffers_add_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                              VkQueueFlags queue_flags, bool is_protected)
{
    struct command_pool *pool = malloc(sizeof(*pool));
    if (pool)
        *pool = (struct command_pool){
            .handle = handle, .queue_flags = queue_flags, .is_protected = is_protected};
    reader_lock_write(&command_buffers->lock);
    struct command_pool *old = take_out_pool(command_buffers, handle);
    if (!pool || !handle_table_set(&command_buffers->pools, (uint64_t)(uintptr_t)handle, pool)) {
        command_buffers->incomplete = true;
        free(pool);
    }
    reader_lock_write_done(&command_buffers->lock);
    if (old)
        free_pool(old, NULL);
}

void command_buffers_remove_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                                 void (*gone)(void *user, VkCommandBuffer handle), void *user)
{
    reader_lock_write(&command_buffers->lock);
    struct command_pool *pool = take_out_pool(command_buffers, handle);
    reader_lock_write_done(&command_buffers->lock);
    if (!pool)
        return;
    for (const struct command_buffer *b = pool->first; b; b = b->next)
        gone(user, b->handle);
    free_pool(pool, NULL);
}

void command_buffers_reset_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                                bool releases)
{
    unsigned stripe = reader_lock_enter(&command_buffers->lock);
    struct command_pool *pool =
        handle_table_find(&command_buffers->pools, (uint64_t)(uintptr_t)handle);
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
        handle_table_remove(&command_buffers->buffers, (uint64_t)(uintptr_t)handle);
    if (!old)
        return;
    begin_epoch(command_buffers);
    unlink_from_pool(old);
    free_command_buffer(old);
}

static void add_command_buffer(struct command_buffers *command_buffers, struct command_pool *pool,
                               VkCommandBufferLevel level, VkCommandBuffer handle)
{
    remove_command_buffer(command_buffers, handle);
    struct command_buffer *new = pool ? calloc(1, sizeof(*new)) : NULL;
    if (!new || !handle_table_set(&command_buffers->buffers, (uint64_t)(uintptr_t)handle, new)) {
        command_buffers->incomplete = true;
        free(new);
        return;
    }
    new->handle = handle;
    new->level = level;
    new->state = COMMAND_BUFFER_INITIAL;
    dependents_init(&new->dependents);
    link_to_pool(new, pool);
}

void command_buffers_add(struct command_buffers *command_buffers, VkCommandPool pool,
                         VkCommandBufferLevel level, uint32_t count, const VkCommandBuffer *handles)
{
    reader_lock_write(&command_buffers->lock);
    struct command_pool *owner =
        handle_table_find(&command_buffers->pools, (uint64_t)(uintptr_t)pool);
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

struct command_buffer *command_buffers_find(struct command_buffers *command_buffers,
                                            VkCommandBuffer handle)
{
    uint64_t epoch = atomic_load_explicit(&command_buffers->epoch, memory_order_acquire);
    struct found_command_buffer *last = &last_found;
    if (last->epoch == epoch && last->handle == handle)
        return last->record;
    unsigned stripe = reader_lock_enter(&command_buffers->lock);
    struct command_buffer *found =
        handle_table_find(&command_buffers->buffers, (uint64_t)(uintptr_t)handle);
    reader_lock_leave(&command_buffers->lock, stripe);
    if (found)
        *last = (struct found_command_buffer){epoch, handle, found};
    return found;
}

static enum tristate tristate_of(bool value)
{
    return value ? YES : NO;
}

struct command_buffer_facts command_buffers_facts(struct command_buffers *command_buffers,
                                                  const struct command_buffer *command_buffer,
                                                  VkCommandBuffer handle)
{
    struct command_buffer_facts facts = {.handle = handle};
    if (!command_buffer) {
        unsigned stripe = reader_lock_enter(&command_buffers->lock);
        facts.alive = command_buffers->incomplete ? UNKNOWN : NO;
        reader_lock_leave(&command_buffers->lock, stripe);
        return facts;
    }
    facts.alive = YES;
    facts.state = command_buffer->state;
    if (command_buffer->validity &&
        atomic_load_explicit(&command_buffer->validity->lost, memory_order_relaxed))
        facts.state = COMMAND_BUFFER_INVALID;
    facts.queue_flags = command_buffer->pool->queue_flags;
    facts.is_protected = tristate_of(command_buffer->pool->is_protected);
    facts.build_index = command_buffer->build_count;
    if (command_buffer->state == COMMAND_BUFFER_RECORDING) {
        facts.in_render_pass = tristate_of(command_buffer->in_render_pass);
        facts.in_video_coding = tristate_of(command_buffer->in_video_coding);
        facts.suspended = command_buffer->suspended;
    }
    return facts;
}

struct label_stack *command_buffers_labels(struct command_buffers *command_buffers,
                                           VkCommandBuffer handle)
{
    struct command_buffer *found = command_buffers_find(command_buffers, handle);
    return found ? &found->labels : NULL;
}
