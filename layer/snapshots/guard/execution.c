/* SPDX-License-Identifier: Apache-2.0 */
/* Walks the journals of batches in execution order: counts builds, and sets the limits of guarded
 * builds. */
#include "layer/snapshots/guard/execution.h"

#include "layer/snapshots/guard/references.h"
#include "layer/snapshots/snapshots.h"
#include "src/snapshots/recorded_build.h"
#include "src/state/commands/journal.h"

static struct guard *guard_of(const struct layer_device *device)
{
    return device->snapshots ? device->snapshots->guard : NULL;
}

/* ---- the submission of a thread */

/* The check of a batch and the call down are on one thread, with nothing of another submission
 * between them. */
static _Thread_local struct {
    uint32_t checked, limited; /* batches */
} submission_of_thread;

void guard_begin_submission(void)
{
    submission_of_thread.checked = submission_of_thread.limited = 0;
}

uint32_t guard_limited_batches(void)
{
    return submission_of_thread.limited;
}

/* A batch behind one without limits has none either: it may execute the same command buffer, whose
 * orders have been written for the earlier batch by then. */
static bool count_batch(bool has_place)
{
    bool is_limited = has_place && submission_of_thread.limited == submission_of_thread.checked;
    submission_of_thread.checked++;
    submission_of_thread.limited += is_limited;
    return is_limited;
}

/* ---- batches */

struct guard_walk {
    struct guard *guard;
    bool sets_limits; /* the batch is about to be submitted, at a known place in execution order */
    bool may_precede; /* earlier submissions with guarded builds may execute after this batch */
    bool has_guards;
};

/* Whether instances may refer to what the entry writes: not to a top-level structure. */
static bool writes_referable(const struct journal_entry *entry)
{
    return JOURNAL_BUILDS & JOURNAL_BIT(entry->kind)
               ? entry->built.type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
               : entry->kind != JOURNAL_EXECUTE;
}

static void set_limit(struct guard_walk *walk, struct build_guard *guard)
{
    uint32_t limit = guard_next_count(walk->guard) - 1;
    atomic_store(&guard->limit, limit < GUARD_NEVER_BUILT - 1 ? limit : GUARD_ALL_LIVE);
    walk->has_guards = true;
}

static void walk_journal(struct guard_walk *walk, const struct journal *journal)
{
    const struct recording *recording = journal->work;
    bool sets_limits = walk->sets_limits && recording && recording->has_guards;
    struct journal_cursor cursor =
        journal_start(journal, JOURNAL_WRITES | JOURNAL_BIT(JOURNAL_EXECUTE));
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        struct recorded_build *build = sets_limits ? journal_copies(entry) : NULL;
        if (build && build->guard.has_order)
            set_limit(walk, &build->guard);
        if (writes_referable(entry))
            guard_note_built(walk->guard, entry->dst, entry->dst_id,
                             walk->may_precede ? 0 : guard_next_count(walk->guard));
        if (entry->kind == JOURNAL_EXECUTE)
            walk_journal(walk, entry->secondary);
    }
}

static void walk_batch(struct guard_walk *walk, const struct order_batch *batch)
{
    for (uint32_t i = 0; i < batch->command_count; i++)
        if (batch->commands[i].captured)
            walk_journal(walk, batch->commands[i].captured);
}

static void check(void *user, struct order_batch *batch)
{
    struct guard_walk walk = {.guard = guard_of(user)};
    if (batch->work != WORK_OF_QUEUE)
        return;
    walk.sets_limits = count_batch(batch->predecessors_known && batch->is_replayed);
    if (!batch->is_replayed)
        return;
    struct execution_clock *guarded = guard_clock(walk.guard);
    walk.may_precede = !execution_clock_covers(&batch->clock, guarded);
    guard_update(walk.guard);
    walk_batch(&walk, batch);
    if (walk.has_guards)
        execution_clock_add(guarded, batch->timestamp);
}

/* Work of the host counts when it begins, because a submission may overlap it. */
static void run(void *user, struct order_batch *batch)
{
    struct guard_walk walk = {.guard = guard_of(user), .may_precede = true};
    bool is_counted = batch->work == WORK_OF_QUEUE ? batch->is_checked : batch->work != WORK_BEGINS;
    if (!is_counted)
        walk_batch(&walk, batch);
}

struct batch_consumer guard_consumer(struct layer_device *device)
{
    return (struct batch_consumer){.user = device, .check = check, .run = run};
}
