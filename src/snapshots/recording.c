/* SPDX-License-Identifier: Apache-2.0 */
/* Recordings and their executions: ownership and lifetime. */
#include "src/snapshots/recording.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/platform/threads.h"

static void destroy(void *work);

struct recording *recording_create(struct journal *journal, const struct recording_memory *memory)
{
    struct recording *recording = calloc(1, sizeof(*recording));
    if (!recording)
        return NULL;
    pthread_mutex_init(&recording->lock, NULL);
    recording->journal = journal;
    recording->memory = *memory;
    journal->work = recording;
    journal->release_work = destroy;
    return recording;
}

/* Frees the first `count` chunks. */
static void free_chunks(struct recording *recording, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        pthread_mutex_lock(&recording->lock);
        struct snapshot_chunk *chunk = recording->chunks[i];
        recording->chunks[i] = NULL;
        pthread_mutex_unlock(&recording->lock);
        if (chunk)
            recording->memory.free_chunk(recording->memory.user, chunk);
    }
}

static void destroy(void *work)
{
    struct recording *recording = work;
    while (recording->builds) {
        struct recorded_build *build = recording->builds;
        recording->builds = build->next;
        recorded_build_free(build);
    }
    free_chunks(recording, recording->chunk_count);
    if (recording->gate.words)
        recording->memory.free_words(recording->memory.user, &recording->gate);
    if (recording->guarded)
        recording->memory.free_guarded(recording->memory.user, recording->guarded);
    for (uint32_t i = 0; i < recording->marks.count; i++)
        recording->memory.free_words(recording->memory.user, &recording->marks.items[i].words);
    for (uint32_t i = 0; i < recording->size_pools.count; i++)
        recording->memory.free_queries(recording->memory.user, recording->size_pools.items[i]);
    free(recording->size_pools.items);
    free(recording->marks.items);
    free(recording->chunks);
    free(recording->copy_blocks);
    pthread_mutex_destroy(&recording->lock);
    free(recording);
}

void recording_add_build(struct recording *recording, struct recorded_build *build)
{
    build->next = recording->builds;
    recording->builds = build;
    recording->has_commands = true;
}

void recording_leave_out(struct recording *recording, uint32_t position, enum left_out reason)
{
    if (recording->left_out_count < LEFT_OUT_NAMED)
        recording->left_out[recording->left_out_count] = (struct left_out_build){position, reason};
    recording->left_out_count++;
}

/* Called with the lock held. */
static bool reserve_chunk(struct recording *recording)
{
    return ARRAY_HAS_ROOM(recording->chunks, recording->chunk_count, recording->chunk_capacity);
}

bool recording_add_chunk(struct recording *recording, struct snapshot_chunk *chunk)
{
    pthread_mutex_lock(&recording->lock);
    bool has_room = reserve_chunk(recording);
    if (has_room)
        recording->chunks[recording->chunk_count++] = chunk;
    pthread_mutex_unlock(&recording->lock);
    if (!has_room)
        recording->memory.free_chunk(recording->memory.user, chunk);
    return has_room;
}

bool recording_add_copy_block(struct recording *recording, const struct copy_block *block)
{
    if (!ARRAY_HAS_ROOM(recording->copy_blocks, recording->copy_block_count,
                        recording->copy_block_capacity))
        return false;
    recording->copy_blocks[recording->copy_block_count++] = *block;
    return true;
}

void recording_continue(struct recording *recording)
{
    pthread_mutex_lock(&recording->lock);
    recording->keeps_chunks |= recording->execution_count != 0;
    pthread_mutex_unlock(&recording->lock);
}

void recording_keep_chunks(struct recording *recording)
{
    pthread_mutex_lock(&recording->lock);
    recording->keeps_chunks = true;
    pthread_mutex_unlock(&recording->lock);
}

bool recording_open_gate(struct recording *recording)
{
    pthread_mutex_lock(&recording->lock);
    bool opens = !recording->is_spent;
    /* The device may read an open gate. */
    if (opens && recording->gate.words && !atomic_load(recording->gate.words))
        atomic_store(recording->gate.words, 1);
    pthread_mutex_unlock(&recording->lock);
    return opens;
}

/* ---- executions */

static void free_execution(struct execution *execution)
{
    free(execution->children);
    free(execution->bases);
    free(execution);
}

/* Allocates an execution of the current entries. Called with the recording's lock held. */
static struct execution *allocate_execution(struct recording *recording)
{
    struct execution *execution = calloc(1, sizeof(*execution));
    if (!execution)
        return NULL;
    execution->end = chunk_list_end(&recording->journal->entries);
    execution->chunk_count = recording->chunk_count;
    execution->is_repeated = execution->detached = execution->has_no_snapshots =
        recording->is_spent;
    execution->bases =
        calloc(recording->chunk_count + 1u, sizeof(unsigned char *) + sizeof(uint64_t));
    execution->children =
        calloc(recording->journal->secondary_count + 1u, sizeof(struct execution *));
    if (!execution->bases || !execution->children) {
        free_execution(execution);
        return NULL;
    }
    execution->sizes = (uint64_t *)(execution->bases + recording->chunk_count);
    for (uint32_t i = 0; !recording->is_spent && i < recording->chunk_count; i++) {
        execution->bases[i] = recording->chunks[i]->bytes;
        execution->sizes[i] = recording->chunks[i]->used;
    }
    return execution;
}

static struct execution *start_execution(struct recording *recording, const struct ticket *ticket)
{
    pthread_mutex_lock(&recording->lock);
    struct execution *execution = allocate_execution(recording);
    if (execution) {
        struct execution *other = recording->latest;
        while (other && !ticket_is_of_call(other->ticket, ticket))
            other = other->older;
        if (other) /* so are all before, by now */
            atomic_store(&other->is_overwritten, true);
        atomic_init(&execution->references, 1);
        recording->execution_count++;
    }
    pthread_mutex_unlock(&recording->lock);
    return execution;
}

/* From now on other threads find the execution, which has all members by now. */
static void publish(struct recording *recording, struct execution *execution)
{
    pthread_mutex_lock(&recording->lock);
    execution->older = recording->latest;
    if (execution->older)
        execution->older->newer = execution;
    recording->latest = execution;
    pthread_mutex_unlock(&recording->lock);
}

/* Called with the lock held. The execution may not be published yet. */
static void unpublish(struct recording *recording, const struct execution *execution)
{
    if (recording->latest == execution)
        recording->latest = execution->older;
    if (execution->newer)
        execution->newer->older = execution->older;
    if (execution->older)
        execution->older->newer = execution->newer;
}

static bool add_children(struct execution *execution)
{
    struct journal_walk walk = journal_start_secondaries(execution->recording->journal);
    if (execution->recording->journal->secondary_count)
        walk.end = execution->end;
    for (const struct journal *secondary; (secondary = journal_next_secondary(&walk));) {
        struct recording *recording = recording_with_commands(secondary);
        struct execution *child = recording ? execution_create(recording, execution->ticket) : NULL;
        if (recording && !child)
            return false;
        execution->children[execution->child_count++] = child;
    }
    return true;
}

struct execution *execution_create(struct recording *recording, struct ticket *ticket)
{
    struct execution *execution = start_execution(recording, ticket);
    if (!execution)
        return NULL;
    shared_lock_init(&execution->lock);
    execution->recording = recording;
    journal_share(recording->journal);
    execution->ticket = ticket_share(ticket);
    if (add_children(execution)) {
        publish(recording, execution);
        return execution;
    }
    execution_release(execution);
    return NULL;
}

struct execution *execution_share(struct execution *execution)
{
    atomic_fetch_add_explicit(&execution->references, 1, memory_order_relaxed);
    return execution;
}

static void free_copies(unsigned char **bases, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        free(bases[i]);
}

/* Drops a reference under the recording's lock, so that the recording never returns an execution
 * without references. */
static bool drop_reference(struct execution *execution)
{
    struct recording *recording = execution->recording;
    pthread_mutex_lock(&recording->lock);
    bool is_last = atomic_fetch_sub_explicit(&execution->references, 1, memory_order_acq_rel) == 1;
    if (is_last)
        unpublish(recording, execution);
    pthread_mutex_unlock(&recording->lock);
    return is_last;
}

/* Gives the chunks back if no later execution needs them. Does not wait, because calls that destroy
 * something may release an execution. */
static void spend_chunks(const struct execution *execution)
{
    struct recording *recording = execution->recording;
    bool is_complete = recording->executes_once && atomic_load(&execution->ticket->is_complete);
    pthread_mutex_lock(&recording->lock);
    recording->execution_count--;
    recording->keeps_chunks |= !is_complete;
    bool spends = !recording->execution_count && !recording->keeps_chunks;
    recording->is_spent |= spends;
    if (spends && recording->gate.words)
        atomic_store(recording->gate.words, 0);
    pthread_mutex_unlock(&recording->lock);
    if (spends)
        free_chunks(recording, execution->chunk_count);
}

void execution_release(struct execution *execution)
{
    if (!execution || !drop_reference(execution))
        return;
    for (uint32_t i = 0; i < execution->child_count; i++)
        execution_release(execution->children[i]);
    if (execution->detached)
        free_copies(execution->bases, execution->chunk_count);
    spend_chunks(execution);
    shared_lock_destroy(&execution->lock);
    ticket_release(execution->ticket);
    journal_release(execution->recording->journal);
    free_execution(execution);
}

/* Called with the lock held. */
static bool copy_chunks(struct execution *execution)
{
    for (uint32_t i = 0; i < execution->chunk_count; i++) {
        unsigned char *copy = malloc(execution->sizes[i] + 1);
        if (!copy) {
            free_copies(execution->bases, i);
            return false;
        }
        memcpy(copy, execution->bases[i], execution->sizes[i]);
        execution->bases[i] = copy;
    }
    return true;
}

/* From now on the execution and the executions of its secondaries have no snapshots. */
static void execution_drop_snapshots(struct execution *execution)
{
    if (!execution)
        return;
    shared_lock_write(&execution->lock);
    execution->has_no_snapshots = true;
    shared_lock_release(&execution->lock);
    for (uint32_t i = 0; i < execution->child_count; i++)
        execution_drop_snapshots(execution->children[i]);
}

void execution_drop_invalidated(struct execution *execution)
{
    if (!execution)
        return;
    if (atomic_load(&execution->recording->is_invalidated)) {
        execution_drop_snapshots(execution);
        return;
    }
    for (uint32_t i = 0; i < execution->child_count; i++)
        execution_drop_invalidated(execution->children[i]);
}

void execution_mark_reached(struct execution *execution)
{
    if (!execution)
        return;
    atomic_store(&execution->is_reached, true);
    for (uint32_t i = 0; i < execution->child_count; i++)
        execution_mark_reached(execution->children[i]);
}

/* Another execution may overwrite the chunks: they are not read any more. Called with the lock
 * held. */
static void drop_snapshots(struct execution *execution)
{
    memset(execution->bases, 0, execution->chunk_count * sizeof(unsigned char *));
    execution->has_no_snapshots = true;
    execution->detached = true;
}

/* Copies the snapshots of an execution that is about to be overwritten. Returns false if they are
 * dropped instead. */
static bool detach(struct execution *execution, uint64_t nanoseconds)
{
    bool is_kept = true;
    VkResult result = execution->ticket->wait(
        execution->ticket, atomic_load(&execution->is_reached) ? nanoseconds : 0);
    shared_lock_write(&execution->lock);
    if (!execution->detached) {
        is_kept = result == VK_SUCCESS && copy_chunks(execution);
        if (is_kept)
            execution->detached = true;
        else
            drop_snapshots(execution);
    }
    shared_lock_release(&execution->lock);
    return is_kept;
}

uint32_t execution_count_repeated(const struct execution *execution)
{
    if (!execution)
        return 0;
    uint32_t count = execution->is_repeated;
    for (uint32_t i = 0; i < execution->child_count; i++)
        count += execution_count_repeated(execution->children[i]);
    return count;
}

/* Returns the execution that was made last, or last before `after`, with a reference. Skips those
 * of the submissions of `after` and of `next`. Returns NULL if there is none. */
static struct execution *share_other(struct recording *recording, const struct execution *after,
                                     const struct ticket *next)
{
    pthread_mutex_lock(&recording->lock);
    struct execution *execution = after ? after->older : recording->latest;
    while (execution && (ticket_is_of_call(execution->ticket, next) ||
                         (after && ticket_is_of_call(execution->ticket, after->ticket))))
        execution = execution->older;
    if (execution)
        execution_share(execution);
    pthread_mutex_unlock(&recording->lock);
    return execution;
}

struct execution *recording_share_latest(struct recording *recording)
{
    return share_other(recording, NULL, NULL);
}

uint32_t recording_detach(struct recording *recording, const struct ticket *next,
                          uint64_t nanoseconds)
{
    uint32_t dropped = 0;
    struct execution *latest = share_other(recording, NULL, next);
    if (latest)
        dropped += !detach(latest, nanoseconds);
    execution_release(latest);
    struct journal_walk walk = journal_start_secondaries(recording->journal);
    for (const struct journal *secondary; (secondary = journal_next_secondary(&walk));)
        if (secondary->work)
            dropped += recording_detach(secondary->work, next, nanoseconds);
    return dropped;
}

void recording_invalidate(struct recording *recording)
{
    atomic_store(&recording->is_invalidated, true);
    struct journal_walk walk = journal_start_secondaries(recording->journal);
    for (const struct journal *secondary; (secondary = journal_next_secondary(&walk));)
        if (secondary->work)
            recording_invalidate(secondary->work);
}

static bool is_pending(const struct execution *execution)
{
    return !ticket_result_is_final(execution->ticket->wait(execution->ticket, 0));
}

/* Whether an execution is pending whose ticket is not `next`, and whose queue is not `besides`. */
static bool has_pending(struct recording *recording, const struct ticket *next, VkQueue besides)
{
    bool has = false;
    struct execution *execution = share_other(recording, NULL, next);
    while (execution) {
        struct execution *after = execution;
        has = (!besides || after->ticket->queue != besides) && is_pending(after);
        execution = has ? NULL : share_other(recording, after, next);
        execution_release(after);
    }
    return has;
}

bool recording_is_pending(struct recording *recording, const struct ticket *next)
{
    return atomic_load(&recording->is_invalidated) || has_pending(recording, next, VK_NULL_HANDLE);
}

uint32_t execution_drop_contested(struct execution *execution)
{
    if (!execution)
        return 0;
    const struct ticket *ticket = execution->ticket;
    uint32_t count = has_pending(execution->recording, ticket, ticket->queue);
    if (count) {
        shared_lock_write(&execution->lock);
        drop_snapshots(execution);
        shared_lock_release(&execution->lock);
    }
    for (uint32_t i = 0; i < execution->child_count; i++)
        count += execution_drop_contested(execution->children[i]);
    return count;
}
