/* SPDX-License-Identifier: Apache-2.0 */
/* A list of command buffers with builds, in the order of submission. */
#include "layer/execution/submitted_builds.h"

#include <stdlib.h>

#include "layer/execution/input_check_run.h"

/* One execution of a primary command buffer. */
struct submitted_commands_entry {
    struct submitted_commands_entry *next;
    struct journal *journal;
    struct shared_labels *queue_labels;
    VkQueue queue;
    uint64_t submission;
    struct timestamp timestamp;
};

struct submitted_builds {
    const struct layer_device *device;
    atomic_uint count; /* changes with the lock held */
    pthread_mutex_t lock;
    struct submitted_commands_entry *first, **last;
};

VkResult submitted_builds_create(const struct layer_device *device,
                                 struct submitted_builds **submitted)
{
    *submitted = calloc(1, sizeof(**submitted));
    if (!*submitted)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*submitted)->device = device;
    (*submitted)->last = &(*submitted)->first;
    pthread_mutex_init(&(*submitted)->lock, NULL);
    return VK_SUCCESS;
}

static void free_list(struct submitted_commands_entry *entry)
{
    for (struct submitted_commands_entry *next; entry; entry = next) {
        next = entry->next;
        journal_release(entry->journal);
        shared_labels_release(entry->queue_labels);
        free(entry);
    }
}

void submitted_builds_destroy(struct submitted_builds *submitted)
{
    if (!submitted)
        return;
    free_list(submitted->first);
    pthread_mutex_destroy(&submitted->lock);
    free(submitted);
}

/* ---- adding */

static bool has_builds(const struct journal *journal)
{
    struct journal_cursor cursor =
        journal_start(journal, JOURNAL_BUILDS | JOURNAL_BIT(JOURNAL_EXECUTE));
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (entry->kind != JOURNAL_EXECUTE || has_builds(entry->secondary))
            return true;
    return false;
}

/* Called with the lock held. Returns the entry that exceeds the limit, or NULL. */
static struct submitted_commands_entry *append(struct submitted_builds *submitted,
                                               struct submitted_commands_entry *entry)
{
    struct submitted_commands_entry *oldest = NULL;
    *submitted->last = entry;
    submitted->last = &entry->next;
    if (atomic_fetch_add(&submitted->count, 1) < SUBMITTED_MAX)
        return NULL;
    oldest = submitted->first;
    submitted->first = oldest->next;
    oldest->next = NULL;
    atomic_fetch_sub(&submitted->count, 1);
    return oldest;
}

void submitted_builds_add(struct submitted_builds *submitted, VkQueue queue, uint64_t submission,
                          struct shared_labels *queue_labels, VkCommandBuffer handle)
{
    const struct command_buffer *command_buffer =
        submitted ? command_buffers_find(submitted->device->command_buffers, handle) : NULL;
    if (!command_buffer || !command_buffer->journal || !has_builds(command_buffer->journal))
        return;
    struct submitted_commands_entry *entry = malloc(sizeof(*entry));
    if (!entry)
        return;
    *entry = (struct submitted_commands_entry){
        .journal = journal_share(command_buffer->journal),
        .queue_labels = shared_labels_share(queue_labels),
        .queue = queue,
        .submission = submission,
        .timestamp = timestamp_never(),
    };
    pthread_mutex_lock(&submitted->lock);
    struct submitted_commands_entry *oldest = append(submitted, entry);
    pthread_mutex_unlock(&submitted->lock);
    free_list(oldest);
}

static bool has_run(const struct submitted_commands_entry *entry)
{
    return entry->timestamp.count != timestamp_never().count;
}

static void set_time(struct submitted_builds *submitted, const struct batch_run *run,
                     const struct journal *journal)
{
    struct submitted_commands_entry *entry = submitted->first;
    while (entry && (entry->journal != journal || entry->queue != run->queue ||
                     entry->submission != run->submission || has_run(entry)))
        entry = entry->next;
    if (entry)
        entry->timestamp = run->timestamp;
}

void submitted_builds_run(struct submitted_builds *submitted, const struct batch_run *run)
{
    if (!submitted || !atomic_load(&submitted->count))
        return;
    pthread_mutex_lock(&submitted->lock);
    for (uint32_t i = 0; i < run->command_count; i++)
        set_time(submitted, run, run->commands[i].captured);
    pthread_mutex_unlock(&submitted->lock);
}

/* ---- completion */

/* What an entry is to be like. */
struct pattern {
    bool (*fits)(const struct pattern *pattern, const struct submitted_commands_entry *entry);
    const struct execution_clock *clock;
    struct timestamp timestamp;
    VkQueue queue;
    uint64_t submission;
};

static void forget(struct submitted_builds *submitted, const struct pattern *pattern)
{
    struct submitted_commands_entry *forgotten = NULL;
    pthread_mutex_lock(&submitted->lock);
    for (struct submitted_commands_entry **link = &submitted->first; *link;) {
        struct submitted_commands_entry *entry = *link;
        if (!pattern->fits(pattern, entry)) {
            link = &entry->next;
            continue;
        }
        *link = entry->next;
        entry->next = forgotten;
        forgotten = entry;
        atomic_fetch_sub(&submitted->count, 1);
    }
    submitted->last = &submitted->first;
    while (*submitted->last)
        submitted->last = &(*submitted->last)->next;
    pthread_mutex_unlock(&submitted->lock);
    free_list(forgotten);
}

static bool was_seen(const struct pattern *pattern, const struct submitted_commands_entry *entry)
{
    return execution_clock_has(pattern->clock, entry->timestamp);
}

static bool is_of_batch(const struct pattern *pattern, const struct submitted_commands_entry *entry)
{
    return timestamps_are_equal(entry->timestamp, pattern->timestamp);
}

static bool is_of_call(const struct pattern *pattern, const struct submitted_commands_entry *entry)
{
    return entry->queue == pattern->queue && entry->submission == pattern->submission &&
           !has_run(entry);
}

void submitted_builds_remove(struct submitted_builds *submitted, VkQueue queue, uint64_t submission)
{
    if (submitted && atomic_load(&submitted->count))
        forget(submitted,
               &(struct pattern){.fits = is_of_call, .queue = queue, .submission = submission});
}

void submitted_builds_prune(struct submitted_builds *submitted)
{
    struct execution_clock seen;
    if (!submitted || !atomic_load(&submitted->count))
        return;
    execution_order_host_clock(submitted->device->order, &seen);
    forget(submitted, &(struct pattern){.fits = was_seen, .clock = &seen});
}

void submitted_builds_end(struct submitted_builds *submitted, struct timestamp timestamp)
{
    if (submitted)
        forget(submitted, &(struct pattern){.fits = is_of_batch, .timestamp = timestamp});
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
static bool is_repeated(const struct submitted_commands_entry *entry)
{
    const struct recording *recording = entry->journal->work;
    for (const struct submitted_commands_entry *later = entry->next; recording && later;
         later = later->next)
        if (later->journal == entry->journal)
            return atomic_load(&recording->marks.ticket) != 0;
    return false;
}

bool submitted_builds_each(struct submitted_builds *submitted, bool waits,
                           bool (*visit)(void *user, const struct submitted_build *build),
                           void *user)
{
    struct visitor visitor = {
        .visit = visit, .user = user, .has_marks = submitted->device->snapshots};
    if (waits)
        pthread_mutex_lock(&submitted->lock);
    else if (pthread_mutex_trylock(&submitted->lock) != 0)
        return false;
    bool goes_on = true;
    for (const struct submitted_commands_entry *entry = submitted->first; entry && goes_on;
         entry = entry->next) {
        visitor.build.primary = entry->journal->command_buffer;
        visitor.build.queue = entry->queue;
        visitor.build.submission = entry->submission;
        visitor.build.queue_labels = shared_labels_stack(entry->queue_labels);
        goes_on =
            (visitor.has_marks && is_repeated(entry)) || visit_journal(&visitor, entry->journal);
    }
    pthread_mutex_unlock(&submitted->lock);
    return true;
}

/* ---- not run yet */

bool submitted_builds_find_unrun(struct submitted_builds *submitted, uint32_t n,
                                 struct ran_execution *ran)
{
    *ran = (struct ran_execution){0};
    pthread_mutex_lock(&submitted->lock);
    struct submitted_commands_entry *entry = submitted->first;
    while (entry && (has_run(entry) || n)) {
        n -= !has_run(entry);
        entry = entry->next;
    }
    if (entry)
        *ran = (struct ran_execution){
            .journal = journal_share(entry->journal),
            .queue = entry->queue,
            .submission = entry->submission,
            .queue_labels = shared_labels_share(entry->queue_labels),
        };
    pthread_mutex_unlock(&submitted->lock);
    if (entry && ran->journal->work)
        ran->execution = recording_share_latest(ran->journal->work);
    return entry;
}

void submitted_builds_release_unrun(struct ran_execution *ran)
{
    execution_release(ran->execution);
    journal_release(ran->journal);
    shared_labels_release(ran->queue_labels);
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
    if (!submitted || !submitted->device->snapshots || !atomic_load(&submitted->count))
        return progress;
    pthread_mutex_lock(&submitted->lock);
    for (const struct submitted_commands_entry *entry = submitted->first; entry;
         entry = entry->next)
        add_progress(&progress, entry->journal);
    pthread_mutex_unlock(&submitted->lock);
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
