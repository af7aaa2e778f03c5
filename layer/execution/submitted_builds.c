/* SPDX-License-Identifier: Apache-2.0 */
/* The batches with builds, in the order of submission. */
#include "layer/execution/submitted_builds.h"

#include <stdlib.h>

#include "layer/execution/input_check_run.h"

struct submitted_builds {
    const struct layer_device *device;
    struct batch_list *batches;
    atomic_uint count; /* pending command buffers; changes with the lock of the list */
};

VkResult submitted_builds_create(const struct layer_device *device,
                                 struct submitted_builds **submitted)
{
    *submitted = calloc(1, sizeof(**submitted));
    if (!*submitted)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*submitted)->device = device;
    (*submitted)->batches = execution_order_batches(device->order);
    return VK_SUCCESS;
}

/* ---- the list. Call these functions with its lock. */

/* A pending command buffer. */
struct pending {
    struct order_batch *batch; /* NULL: none yet */
    uint32_t command;
};

static struct order_batch *next_batch(const struct submitted_builds *submitted,
                                      const struct order_batch *after)
{
    return batch_list_next(submitted->batches, IN_SUBMISSION_ORDER, after, USES_PENDING_BUILDS);
}

/* Goes on to the next pending command buffer. Returns false if there is none. */
static bool next_pending(const struct submitted_builds *submitted, struct pending *at)
{
    uint32_t i = at->batch ? at->command + 1 : 0;
    struct order_batch *batch = at->batch ? at->batch : next_batch(submitted, NULL);
    for (; batch; batch = next_batch(submitted, batch), i = 0)
        for (; i < batch->command_count; i++)
            if (batch->commands[i].is_pending) {
                *at = (struct pending){batch, i};
                return true;
            }
    return false;
}

static const struct journal *journal_of(const struct pending *at)
{
    return at->batch->commands[at->command].captured;
}

/* Forgets command buffers of a batch that is kept. Returns whether none is left: then the caller
 * releases the batch. */
static bool forget(struct submitted_builds *submitted, struct order_batch *batch, uint32_t first,
                   uint32_t end)
{
    bool is_left = false;
    for (uint32_t i = 0; i < batch->command_count; i++) {
        bool *is_pending = &batch->commands[i].is_pending;
        if (i >= first && i < end) {
            atomic_fetch_sub(&submitted->count, *is_pending);
            *is_pending = false;
        }
        is_left |= *is_pending;
    }
    if (!is_left)
        order_batch_end_use(batch, USES_PENDING_BUILDS);
    return !is_left;
}

static bool forget_batch(struct submitted_builds *submitted, struct order_batch *batch)
{
    return order_batch_is_kept(batch, USES_PENDING_BUILDS) &&
           forget(submitted, batch, 0, batch->command_count);
}

/* ---- submissions */

static bool has_builds(const struct journal *journal)
{
    struct journal_cursor cursor =
        journal_start(journal, JOURNAL_BUILDS | JOURNAL_BIT(JOURNAL_EXECUTE));
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (entry->kind != JOURNAL_EXECUTE || has_builds(entry->secondary))
            return true;
    return false;
}

static void forget_oldest(struct submitted_builds *submitted)
{
    struct pending oldest = {0};
    bool is_last = false;
    pthread_mutex_lock(&submitted->batches->lock);
    if (next_pending(submitted, &oldest))
        is_last = forget(submitted, oldest.batch, oldest.command, oldest.command + 1);
    pthread_mutex_unlock(&submitted->batches->lock);
    if (is_last)
        order_batch_release(oldest.batch);
}

static void submit(void *user, struct order_batch *batch)
{
    struct submitted_builds *submitted = user;
    uint32_t count = 0;
    for (uint32_t i = 0; i < batch->command_count; i++) {
        struct submitted_commands *commands = &batch->commands[i];
        commands->is_pending = commands->captured && has_builds(commands->captured);
        count += commands->is_pending;
    }
    if (!count)
        return;
    atomic_fetch_add(&submitted->count, count);
    order_batch_keep(batch, USES_PENDING_BUILDS, NULL);
    while (atomic_load(&submitted->count) > SUBMITTED_MAX)
        forget_oldest(submitted);
}

/* ---- completion */

void submitted_builds_end(struct submitted_builds *submitted, struct order_batch *batch)
{
    if (!submitted)
        return;
    pthread_mutex_lock(&submitted->batches->lock);
    bool was_kept = forget_batch(submitted, batch);
    pthread_mutex_unlock(&submitted->batches->lock);
    if (was_kept)
        order_batch_release(batch);
}

static void fail(void *user, struct order_batch *batch)
{
    submitted_builds_end(user, batch);
}

enum { FORGOTTEN_AT_ONCE = 32 };

/* Forgets batches whose end the host has observed. Returns the number. */
static uint32_t forget_complete(struct submitted_builds *submitted,
                                const struct execution_clock *seen,
                                struct order_batch *forgotten[FORGOTTEN_AT_ONCE])
{
    uint32_t count = 0;
    pthread_mutex_lock(&submitted->batches->lock);
    for (struct order_batch *batch = NULL;
         count < FORGOTTEN_AT_ONCE && (batch = next_batch(submitted, batch));)
        if (order_batch_has_run(batch) && execution_clock_has(seen, batch->timestamp) &&
            forget_batch(submitted, batch))
            forgotten[count++] = batch;
    pthread_mutex_unlock(&submitted->batches->lock);
    return count;
}

static void deliver(void *user)
{
    struct submitted_builds *submitted = user;
    struct order_batch *forgotten[FORGOTTEN_AT_ONCE];
    struct execution_clock seen;
    uint32_t count;
    if (!atomic_load(&submitted->count))
        return;
    execution_order_host_clock(submitted->device->order, &seen);
    do {
        count = forget_complete(submitted, &seen, forgotten);
        for (uint32_t i = 0; i < count; i++)
            order_batch_release(forgotten[i]);
    } while (count == FORGOTTEN_AT_ONCE);
}

void submitted_builds_destroy(struct submitted_builds *submitted)
{
    if (!submitted)
        return;
    for (struct order_batch *batch; (batch = next_batch(submitted, NULL));)
        submitted_builds_end(submitted, batch);
    free(submitted);
}

struct batch_consumer submitted_builds_consumer(struct submitted_builds *submitted)
{
    return (struct batch_consumer){
        .user = submitted, .submit = submit, .fail = fail, .deliver = deliver};
}

/* ---- visiting */

struct visitor {
    bool (*visit)(void *user, const struct submitted_build *build);
    void *user;
    struct submitted_build build;
    bool has_marks;
};

static bool visit_journal(struct visitor *visitor, const struct journal *journal)
{
    struct submitted_build *build = &visitor->build;
    struct journal_cursor cursor =
        journal_start(journal, JOURNAL_BUILDS | JOURNAL_BIT(JOURNAL_EXECUTE));
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (entry->kind == JOURNAL_EXECUTE && !visit_journal(visitor, entry->secondary))
            return false;
        if (entry->kind == JOURNAL_EXECUTE)
            continue;
        const struct recorded_build *copies = visitor->has_marks ? journal_copies(entry) : NULL;
        build->journal = journal;
        build->entry = entry;
        build->state = MARK_IS_UNKNOWN;
        build->lacks_inputs = copies && copies->left_out;
        if (copies)
            build->state = recording_mark_state(journal->work, copies->mark, 0);
        if (!visitor->visit(visitor->user, build))
            return false;
    }
    return true;
}

/* A later execution of the same command buffer has cleared the marks, so this one is complete. */
static bool is_repeated(const struct submitted_builds *submitted, struct pending at)
{
    const struct journal *journal = journal_of(&at);
    const struct recording *recording = journal->work;
    while (recording && next_pending(submitted, &at))
        if (journal_of(&at) == journal)
            return atomic_load(&recording->marks.ticket) != 0;
    return false;
}

bool submitted_builds_each(struct submitted_builds *submitted, bool waits,
                           bool (*visit)(void *user, const struct submitted_build *build),
                           void *user)
{
    struct visitor visitor = {
        .visit = visit, .user = user, .has_marks = submitted->device->snapshots};
    struct pending at = {0};
    if (waits)
        pthread_mutex_lock(&submitted->batches->lock);
    else if (pthread_mutex_trylock(&submitted->batches->lock) != 0)
        return false;
    bool goes_on = true;
    while (goes_on && next_pending(submitted, &at)) {
        const struct journal *journal = journal_of(&at);
        visitor.build.primary = journal->command_buffer;
        visitor.build.queue = at.batch->queue;
        visitor.build.submission = at.batch->number;
        visitor.build.queue_labels = shared_labels_stack(at.batch->labels);
        goes_on =
            (visitor.has_marks && is_repeated(submitted, at)) || visit_journal(&visitor, journal);
    }
    pthread_mutex_unlock(&submitted->batches->lock);
    return true;
}

/* ---- not run yet */

bool submitted_builds_find_unrun(struct submitted_builds *submitted, uint32_t n,
                                 struct ran_execution *ran)
{
    struct pending at = {0};
    bool found = false;
    *ran = (struct ran_execution){0};
    pthread_mutex_lock(&submitted->batches->lock);
    while (!found && next_pending(submitted, &at))
        found = !order_batch_has_run(at.batch) && !n--;
    if (found) {
        ran->batch = order_batch_share(at.batch);
        ran->journal = journal_of(&at);
    }
    pthread_mutex_unlock(&submitted->batches->lock);
    if (found && ran->journal->work)
        ran->execution = recording_share_latest(ran->journal->work);
    return found;
}

void submitted_builds_release_unrun(struct ran_execution *ran)
{
    execution_release(ran->execution);
    order_batch_release(ran->batch);
}

/* ---- progress */

struct progress {
    uint64_t sum;
    bool is_pending;
};

static void add_progress(struct progress *progress, const struct journal *journal)
{
    const struct recording *recording = journal->work;
    for (uint32_t i = 0; recording && i < recording->marks.count; i++) {
        enum mark_state state = recording_mark_state(recording, i + 1, 0);
        progress->sum = progress->sum * 31 + state + 1;
        progress->is_pending |= state == MARK_IS_CLEAR || state == MARK_HAS_COPIES;
    }
    struct journal_cursor cursor = journal_start_secondaries(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        add_progress(progress, entry->secondary);
}

static struct progress find_progress(struct submitted_builds *submitted)
{
    struct progress progress = {0};
    struct pending at = {0};
    if (!submitted || !submitted->device->snapshots || !atomic_load(&submitted->count))
        return progress;
    pthread_mutex_lock(&submitted->batches->lock);
    while (next_pending(submitted, &at))
        add_progress(&progress, journal_of(&at));
    pthread_mutex_unlock(&submitted->batches->lock);
    return progress;
}

uint64_t submitted_builds_progress(struct submitted_builds *submitted)
{
    return find_progress(submitted).sum;
}

bool submitted_builds_are_pending(struct submitted_builds *submitted)
{
    return find_progress(submitted).is_pending;
}
