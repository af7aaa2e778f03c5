/* SPDX-License-Identifier: Apache-2.0 */
/* The batches that use structures, in the order of submission. */
#include "layer/execution/submitted_builds.h"

#include <stdlib.h>

struct submitted_builds {
    const struct layer_device *device;
    struct batch_list *batches;
    atomic_uint count; /* command buffers that use structures of the batches that are kept */
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

struct batch_cursor submitted_builds_start(const struct submitted_builds *submitted)
{
    return (struct batch_cursor){.list = submitted ? submitted->batches : NULL,
                                 .sequence = IN_SUBMISSION_ORDER,
                                 .use = USES_PENDING_BUILDS};
}

static const struct journal *journal_of(const struct batch_cursor *at)
{
    return at->batch->commands[at->command].captured;
}

/* ---- submissions */

static void end_at_use(struct journal_walk *walk, const struct journal_entry *entry)
{
    (void)entry;
    walk->is_over = true;
}

static bool has_uses(const struct journal *journal)
{
    static const struct journal_events uses = {ON_USES(end_at_use), .place = end_at_use,
                                               .execute = journal_walk_secondary};
    return !journal_walk(journal, &uses, NULL);
}

/* Forgets a batch whose use has ended. */
static void forget_batch(struct submitted_builds *submitted, struct order_batch *batch)
{
    for (uint32_t i = 0; i < batch->command_count; i++)
        atomic_fetch_sub(&submitted->count, batch->commands[i].is_used[USES_PENDING_BUILDS]);
    order_batch_release(batch);
}

/* Forgets all batches for which `ends` returns true. */
static void forget_those(struct submitted_builds *submitted,
                         bool (*ends)(const void *user, const struct order_batch *batch),
                         const void *user)
{
    for (struct order_batch *batch;
         (batch = batch_list_take(submitted->batches, IN_SUBMISSION_ORDER, USES_PENDING_BUILDS,
                                  ends, user));)
        forget_batch(submitted, batch);
}

struct newest {
    const struct submitted_builds *submitted;
    const struct order_batch *batch;
};

static bool is_beyond_limit(const void *user, const struct order_batch *batch)
{
    const struct newest *newest = user;
    return atomic_load(&newest->submitted->count) > SUBMITTED_MAX && batch != newest->batch;
}

static void submitted_builds_submit(void *user, struct order_batch *batch)
{
    struct submitted_builds *submitted = user;
    struct execution_clock seen;
    uint64_t untracked = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < batch->command_count; i++) {
        struct submitted_commands *commands = &batch->commands[i];
        bool is_used = commands->captured && has_uses(commands->captured);
        commands->is_used[USES_PENDING_BUILDS] = is_used;
        count += is_used;
    }
    if (!count)
        return;
    atomic_fetch_add(&submitted->count, count);
    execution_order_find_observed(submitted->device->order, &seen, &untracked);
    order_batch_keep(batch, USES_PENDING_BUILDS, (void *)(uintptr_t)untracked);
    if (atomic_load(&submitted->count) > SUBMITTED_MAX)
        forget_those(submitted, is_beyond_limit, &(struct newest){submitted, batch});
}

/* ---- completion */

void submitted_builds_end(struct submitted_builds *submitted, struct order_batch *batch)
{
    if (submitted && order_batch_end_use(batch, USES_PENDING_BUILDS))
        forget_batch(submitted, batch);
}

static void submitted_builds_fail(void *user, struct order_batch *batch)
{
    submitted_builds_end(user, batch);
}

/* Whether the host has observed the end of the batch. */
static bool batch_is_complete(const void *user, const struct order_batch *batch)
{
    return order_batch_has_run(batch) && execution_clock_has(user, batch->timestamp);
}

static void submitted_builds_deliver(void *user)
{
    struct submitted_builds *submitted = user;
    struct execution_clock seen;
    if (!atomic_load(&submitted->count))
        return;
    execution_order_host_clock(submitted->device->order, &seen);
    forget_those(submitted, batch_is_complete, &seen);
}

void submitted_builds_destroy(struct submitted_builds *submitted)
{
    if (submitted)
        forget_those(submitted, NULL, NULL);
    free(submitted);
}

struct batch_consumer submitted_builds_consumer(struct submitted_builds *submitted)
{
    return (struct batch_consumer){.user = submitted,
                                   .submit = submitted_builds_submit,
                                   .fail = submitted_builds_fail,
                                   .deliver = submitted_builds_deliver};
}

/* ---- uses of one object
 *
 * The slot of a batch is the number of execution_order_find_observed() when it was submitted: if
 * that has changed, the application may know that the batch is complete. */

struct use_search {
    struct resources *resources;
    const struct used_object *object;
    struct pending_use *use; /* the result */
};

/* A structure that was created by address may lie in several buffers. */
static bool lies_in(const struct use_search *search, uint64_t handle, uint64_t id)
{
    const struct used_object *object = search->object;
    struct accel_facts facts;
    resources_look_up_accel(search->resources, (VkAccelerationStructureKHR)(uintptr_t)handle,
                            &facts);
    if (!id || facts.id != id || facts.by_address)
        return false;
    return object->buffer_id ? facts.buffer_id == object->buffer_id
                             : facts.memory == object->memory;
}

static bool is_it(const struct use_search *search, uint64_t handle, uint64_t id)
{
    return search->object->id ? id == search->object->id
                              : search->object->may_hold_structures && lies_in(search, handle, id);
}

static void note_found_use(struct journal_walk *walk, unsigned char command)
{
    const struct use_search *search = walk->user;
    search->use->command = (enum build_command)command;
    search->use->command_buffer = walk->journal->command_buffer;
    walk->is_over = true;
}

static void find_use(struct journal_walk *walk, const struct journal_entry *entry)
{
    if ((journal_entry_writes(entry) && is_it(walk->user, entry->dst, entry->dst_id)) ||
        (journal_entry_has_source_to_check(entry) && is_it(walk->user, entry->src, entry->src_id)))
        note_found_use(walk, entry->command);
}

/* An address may lie in several buffers: then a build may use any of them. */
static bool is_input_use(const struct use_search *search, const struct journal_input *input)
{
    const struct used_object *object = search->object;
    struct address_facts facts;
    if (object->id || (object->buffer_id && input->buffer_id != object->buffer_id))
        return false;
    if (input->command == COMMAND_NV)
        return object->buffer_id;
    resources_look_up_address(search->resources, input->address, &facts);
    return facts.status == ADDRESS_IN_BUFFER && facts.buffer_id == input->buffer_id &&
           !facts.is_shared && (!object->memory || facts.memory == object->memory);
}

static void find_input_use(struct journal_walk *walk, const struct journal_input *input)
{
    if (is_input_use(walk->user, input))
        note_found_use(walk, input->command);
}

static const struct journal_events finds_uses = {ON_USES(find_use), .use_buffer = find_input_use,
                                                 .execute = journal_walk_secondary};

/* A batch that was submitted, but not run yet, may be running on another thread. */
static bool is_certainly_pending(const struct order_batch *batch,
                                 const struct execution_clock *seen, uint64_t untracked)
{
    enum order_batch_state state = atomic_load(&batch->state);
    if (!batch->origin.queue || (uintptr_t)batch->slots[USES_PENDING_BUILDS] != untracked)
        return false;
    return state == BATCH_HELD ||
           (state == BATCH_ORDERED && !execution_clock_has(seen, batch->timestamp));
}

bool submitted_builds_find_use(struct submitted_builds *submitted, const struct used_object *object,
                               struct pending_use *use)
{
    const bool is_known = object->id || object->buffer_id || object->memory;
    struct execution_clock seen;
    uint64_t untracked, timed_out_waits = 0;
    bool is_found = false;
    if (!submitted || !is_known || !atomic_load(&submitted->count) ||
        !execution_order_find_observed(submitted->device->order, &seen, &untracked))
        return false;
    struct use_search search = {submitted->device->resources, object, use};
    pthread_mutex_lock(&submitted->batches->lock);
    for (struct batch_cursor at = submitted_builds_start(submitted);
         !is_found && batch_cursor_next(&at);) {
        is_found = is_certainly_pending(at.batch, &seen, untracked) &&
                   !journal_walk(journal_of(&at), &finds_uses, &search);
        use->queue = at.batch->origin.queue;
        use->submission = at.batch->origin.number;
        timed_out_waits = at.batch->timed_out_waits;
    }
    pthread_mutex_unlock(&submitted->batches->lock);
    use->timeout = is_found ? execution_order_find_timeout(submitted->device->order,
                                                           timed_out_waits, UINT64_MAX)
                            : 0;
    return is_found;
}

void submitted_builds_note_destroyed(struct submitted_builds *submitted, uint64_t last)
{
    struct execution_clock seen;
    uint64_t untracked;
    if (!submitted || !atomic_load(&submitted->count) ||
        !execution_order_find_observed(submitted->device->order, &seen, &untracked))
        return;
    pthread_mutex_lock(&submitted->batches->lock);
    for (struct batch_cursor at = submitted_builds_start(submitted); batch_cursor_next(&at);)
        if (last > atomic_load(&at.batch->last_destroyed) &&
            is_certainly_pending(at.batch, &seen, untracked))
            atomic_store(&at.batch->last_destroyed, last);
    pthread_mutex_unlock(&submitted->batches->lock);
}

/* ---- visiting */

struct visitor {
    bool (*visit)(void *user, const struct submitted_build *build);
    void *user;
    struct submitted_build build;
    bool has_marks;
};

static void visit_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct visitor *visitor = walk->user;
    struct submitted_build *build = &visitor->build;
    const struct recorded_build *copies = visitor->has_marks ? journal_copies(entry) : NULL;
    build->journal = walk->journal;
    build->entry = entry;
    build->state = MARK_IS_UNKNOWN;
    build->lacks_inputs = copies && copies->left_out;
    build->copies = copies;
    if (copies)
        build->state = recording_mark_state(walk->journal->work, copies->mark, 0);
    walk->is_over = !visitor->visit(visitor->user, build);
}

static const struct journal_events visits = {ON_BUILDS(visit_build),
                                             .execute = journal_walk_secondary};

/* A later execution of the same command buffer has cleared the marks, so this one is complete. */
static bool is_repeated(struct batch_cursor at)
{
    const struct journal *journal = journal_of(&at);
    const struct recording *recording = journal->work;
    while (recording && batch_cursor_next(&at))
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
    struct batch_cursor at = submitted_builds_start(submitted);
    if (waits)
        pthread_mutex_lock(&submitted->batches->lock);
    else if (pthread_mutex_trylock(&submitted->batches->lock) != 0)
        return false;
    bool goes_on = true;
    while (goes_on && batch_cursor_next(&at)) {
        const struct journal *journal = journal_of(&at);
        visitor.build.primary = journal->command_buffer;
        visitor.build.submission = &at.batch->origin;
        goes_on =
            (visitor.has_marks && is_repeated(at)) || journal_walk(journal, &visits, &visitor);
    }
    pthread_mutex_unlock(&submitted->batches->lock);
    return true;
}

/* ---- progress */

static void visit_marks(struct submitted_builds *submitted,
                        bool (*visit)(void *user, const struct submitted_build *build), void *user)
{
    if (submitted && submitted->device->snapshots && atomic_load(&submitted->count))
        submitted_builds_each(submitted, true, visit, user);
}

static bool add_progress(void *user, const struct submitted_build *build)
{
    uint64_t *sum = user;
    *sum = *sum * 31 + build->state + 1;
    return true;
}

uint64_t submitted_builds_progress(struct submitted_builds *submitted)
{
    uint64_t sum = 0;
    visit_marks(submitted, add_progress, &sum);
    return sum;
}

static bool find_pending(void *user, const struct submitted_build *build)
{
    bool *is_pending = user;
    *is_pending = build->state == MARK_IS_CLEAR || build->state == MARK_HAS_COPIES;
    return !*is_pending;
}

bool submitted_builds_are_pending(struct submitted_builds *submitted)
{
    bool is_pending = false;
    visit_marks(submitted, find_pending, &is_pending);
    return is_pending;
}
