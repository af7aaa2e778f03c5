/* SPDX-License-Identifier: Apache-2.0 */
/* Works and their executions: what they own, and for how long. */
#include "cpu/recording.h"

#include <stdlib.h>
#include <string.h>

struct cpu_recording *cpu_recording_create(void (*free_chunk)(void *user, struct cpu_chunk *chunk),
                                           void *user)
{
    struct cpu_recording *recording = calloc(1, sizeof(*recording));
    if (!recording)
        return NULL;
    atomic_init(&recording->references, 1);
    recording->last = &recording->first;
    pthread_mutex_init(&recording->lock, NULL);
    recording->free_chunk = free_chunk;
    recording->user = user;
    return recording;
}

struct cpu_recording *cpu_recording_share(struct cpu_recording *recording)
{
    atomic_fetch_add_explicit(&recording->references, 1, memory_order_relaxed);
    return recording;
}

static void release_item(const struct cpu_item *item)
{
    free(item->structures);
    cpu_recorded_build_free(item->build);
    cpu_recording_release(item->secondary);
}

void cpu_recording_release(struct cpu_recording *recording)
{
    if (!recording ||
        atomic_fetch_sub_explicit(&recording->references, 1, memory_order_acq_rel) != 1)
        return;
    while (recording->first) {
        struct cpu_item *item = recording->first;
        recording->first = item->next;
        release_item(item);
        free(item);
    }
    for (uint32_t i = 0; i < recording->chunk_count; i++)
        recording->free_chunk(recording->user, recording->chunks[i]);
    free(recording->chunks);
    pthread_mutex_destroy(&recording->lock);
    free(recording);
}

bool cpu_recording_add(struct cpu_recording *recording, const struct cpu_item *item)
{
    struct cpu_item *own = malloc(sizeof(*own));
    if (!own) {
        release_item(item);
        return false;
    }
    *own = *item;
    own->next = NULL;
    *recording->last = own;
    recording->last = &own->next;
    recording->secondary_count += item->kind == CPU_ITEM_EXECUTE;
    recording->has_targets |=
        item->target.buffer || (item->secondary && item->secondary->has_targets);
    return true;
}

bool cpu_recording_add_chunk(struct cpu_recording *recording, struct cpu_chunk *chunk)
{
    if (recording->chunk_count == recording->chunk_capacity) {
        uint32_t capacity = recording->chunk_capacity ? recording->chunk_capacity * 2 : 4;
        struct cpu_chunk **chunks =
            realloc(recording->chunks, capacity * sizeof(struct cpu_chunk *));
        if (!chunks) {
            recording->free_chunk(recording->user, chunk);
            return false;
        }
        recording->chunks = chunks;
        recording->chunk_capacity = capacity;
    }
    recording->chunks[recording->chunk_count++] = chunk;
    return true;
}

/* ---- executions */

static struct cpu_execution *allocate_execution(struct cpu_recording *recording)
{
    struct cpu_execution *execution = calloc(1, sizeof(*execution));
    if (!execution)
        return NULL;
    execution->bases = malloc((recording->chunk_count + 1) * sizeof(unsigned char *));
    execution->children = calloc(recording->secondary_count + 1, sizeof(struct cpu_execution *));
    if (execution->bases && execution->children)
        return execution;
    free(execution->bases);
    free(execution->children);
    free(execution);
    return NULL;
}

static bool add_children(struct cpu_execution *execution)
{
    for (const struct cpu_item *item = execution->recording->first; item; item = item->next) {
        if (item->kind != CPU_ITEM_EXECUTE)
            continue;
        struct cpu_execution *child = cpu_execution_create(item->secondary, execution->ticket);
        if (!child)
            return false;
        execution->children[execution->child_count++] = child;
    }
    return true;
}

struct cpu_execution *cpu_execution_create(struct cpu_recording *recording,
                                           struct cpu_ticket *ticket)
{
    struct cpu_execution *execution = allocate_execution(recording);
    if (!execution)
        return NULL;
    atomic_init(&execution->references, 1);
    pthread_rwlock_init(&execution->lock, NULL);
    execution->recording = cpu_recording_share(recording);
    execution->ticket = cpu_ticket_share(ticket);
    for (uint32_t i = 0; i < recording->chunk_count; i++)
        execution->bases[i] = recording->chunks[i]->bytes;
    pthread_mutex_lock(&recording->lock);
    recording->latest = execution;
    pthread_mutex_unlock(&recording->lock);
    if (add_children(execution))
        return execution;
    cpu_execution_release(execution);
    return NULL;
}

struct cpu_execution *cpu_execution_share(struct cpu_execution *execution)
{
    atomic_fetch_add_explicit(&execution->references, 1, memory_order_relaxed);
    return execution;
}

static void free_copies(unsigned char **bases, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        free(bases[i]);
}

/* So that nobody finds it by its recording any more once it has no references. */
static bool drop_reference(struct cpu_execution *execution)
{
    struct cpu_recording *recording = execution->recording;
    pthread_mutex_lock(&recording->lock);
    bool is_last = atomic_fetch_sub_explicit(&execution->references, 1, memory_order_acq_rel) == 1;
    if (is_last && recording->latest == execution)
        recording->latest = NULL;
    pthread_mutex_unlock(&recording->lock);
    return is_last;
}

void cpu_execution_release(struct cpu_execution *execution)
{
    if (!execution || !drop_reference(execution))
        return;
    for (uint32_t i = 0; i < execution->child_count; i++)
        cpu_execution_release(execution->children[i]);
    if (execution->detached)
        free_copies(execution->bases, execution->recording->chunk_count);
    free(execution->children);
    free(execution->bases);
    pthread_rwlock_destroy(&execution->lock);
    cpu_ticket_release(execution->ticket);
    cpu_recording_release(execution->recording);
    free(execution);
}

/* With the lock held. */
static bool copy_chunks(struct cpu_execution *execution)
{
    struct cpu_recording *recording = execution->recording;
    for (uint32_t i = 0; i < recording->chunk_count; i++) {
        const struct cpu_chunk *chunk = recording->chunks[i];
        unsigned char *copy = malloc(chunk->used + 1);
        if (!copy) {
            free_copies(execution->bases, i);
            memset(execution->bases, 0, recording->chunk_count * sizeof(unsigned char *));
            return false;
        }
        memcpy(copy, chunk->bytes, chunk->used);
        execution->bases[i] = copy;
    }
    return true;
}

static void detach(struct cpu_execution *execution)
{
    VkResult result = execution->ticket->wait(execution->ticket, UINT64_MAX);
    pthread_rwlock_wrlock(&execution->lock);
    if (!execution->detached) {
        execution->is_lost = result != VK_SUCCESS || !copy_chunks(execution);
        execution->detached = true;
    }
    pthread_rwlock_unlock(&execution->lock);
}

void cpu_recording_detach(struct cpu_recording *recording, const struct cpu_ticket *next)
{
    pthread_mutex_lock(&recording->lock);
    struct cpu_execution *latest =
        recording->latest ? cpu_execution_share(recording->latest) : NULL;
    pthread_mutex_unlock(&recording->lock);
    if (latest && latest->ticket != next)
        detach(latest);
    cpu_execution_release(latest);
    for (const struct cpu_item *item = recording->first; item; item = item->next)
        if (item->kind == CPU_ITEM_EXECUTE)
            cpu_recording_detach(item->secondary, next);
}
