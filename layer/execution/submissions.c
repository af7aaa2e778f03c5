/* SPDX-License-Identifier: Apache-2.0 */
/* Replays journals as batches execute. One thread at a time checks and runs batches
 * (src/state/order/order.h): it is the writer of the device's table of structures
 * (src/state/builds/structures.h), and holds no lock while a message is sent. */
#include "layer/execution/submissions.h"

#include <stdlib.h>

#include "layer/execution/build_records.h"
#include "layer/execution/input_checks.h"
#include "layer/execution/query_writes.h"
#include "layer/hazards/executed/checks.h"
#include "layer/layer.h"
#include "layer/snapshots/guard/execution.h"
#include "src/base/unknown.h"
#include "src/check/replay/replay.h"

struct submissions {
    struct layer_device *device;
    struct unknown unknown; /* all structures are unknown */
};

VkResult submissions_create(struct layer_device *device, struct submissions **submissions)
{
    *submissions = calloc(1, sizeof(**submissions));
    if (!*submissions)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*submissions)->device = device;
    return VK_SUCCESS;
}

void submissions_destroy(struct submissions *submissions)
{
    free(submissions);
}

static void set_order_unknown(struct submissions *submissions, enum order_unknown_reason why)
{
    if (!unknown_is_set(&submissions->unknown))
        reporter_add_unchecked(submissions->device->instance->reporter,
                               order_unknown_words[why].unchecked, 1);
    unknown_follow(&submissions->unknown, true);
    structures_release(submissions->device->structures);
    hazard_checks_stop(submissions->device->hazard_checks);
}

/* ---- one batch */

struct batch_check {
    struct submissions *submissions;
    struct order_batch *batch;
};

static bool send_found(void *user, const struct journal *journal, uint32_t first_build,
                       uint32_t origin, enum rule rule, const struct location *location,
                       const struct finding *finding)
{
    struct batch_check *check = user;
    struct recording *recording = journal->work;
    if (recording)
        atomic_store(&recording->has_findings, true);
    const struct layer_device *device = check->submissions->device;
    const struct call_origin from =
        layer_origin_of(device, &check->batch->origin, journal, first_build, origin);
    struct reporter *reporter = device->instance->reporter;
    if (reporter_send(reporter, rule, location, &from, finding))
        check->batch->skips_call = true;
    return reporter_wants(reporter, rule_infos[rule].vuid[location->command]);
}

static void record_compacted_size(void *user, uint64_t structure, VkDeviceSize size)
{
    const struct batch_check *check = user;
    build_records_add_size(check->submissions->device,
                           (VkAccelerationStructureKHR)(uintptr_t)structure, size);
}

static struct replay replay_of(struct batch_check *check, const struct order_batch *batch)
{
    struct submissions *submissions = check->submissions;
    return (struct replay){
        .active = submissions->device->active_rules,
        .resources = submissions->device->resources,
        .query_pools = submissions->device->query_pools,
        .places = submissions->device->places,
        .structures = submissions->device->structures,
        .now = batch->timestamp,
        .follows = &batch->clock,
        .predecessors_known = batch->predecessors_known,
        .destroy_count = batch->destroy_count,
        .never_is_certain = !submissions->device->facts.newer_than_registry &&
                            !places_are_used(submissions->device->places, PLACE_BOTTOM_LEVEL),
        .sizes_may_be_unknown = submissions->device->sizes_may_be_unknown,
        .unordered = batch->work != WORK_OF_QUEUE,
        .found = send_found,
        .compacted = submissions->device->records_builds ? record_compacted_size : NULL,
        .user = check,
    };
}

/* Judges work of the host when it begins, unless that was done before its call went down. */
static void replay_work(struct replay *replay, const struct journal *journal,
                        const struct order_batch *batch)
{
    if (batch->work != WORK_BEGINS) {
        replay_end_work(replay, journal, batch->work == WORK_FAILS);
        return;
    }
    if (!batch->is_checked)
        replay_judge_work(replay, journal);
    replay_begin_work(replay, journal);
}

/* Judges a batch and applies it; a check of the host's work (`is_check` set) is not applied. If a
 * command buffer lacks a complete journal, it may have written anything, so the order becomes
 * unknown. */
static void replay_batch(struct submissions *submissions, struct order_batch *batch, bool is_check)
{
    struct batch_check check = {submissions, batch};
    struct replay replay = replay_of(&check, batch);
    replay.may_fail = is_check;
    structures_forget_destroyed(submissions->device->structures);
    for (uint32_t i = 0; i < batch->command_count && !unknown_is_set(&submissions->unknown); i++) {
        const struct journal *journal = batch->commands[i].captured;
        if (!journal_is_complete(journal)) {
            set_order_unknown(submissions, ORDER_UNKNOWN_OUT_OF_MEMORY);
            break;
        }
        if (batch->work == WORK_OF_QUEUE) {
            replay.notes = input_checks_note(submissions->device->input_checks, batch, i);
            replay_submitted(&replay, journal);
        } else if (is_check) {
            replay_judge_work(&replay, journal);
        } else {
            replay_work(&replay, journal, batch);
        }
        if (replay.out_of_memory)
            set_order_unknown(submissions, ORDER_UNKNOWN_OUT_OF_MEMORY);
    }
    if (replay.sizes_may_be_unknown)
        submissions->device->sizes_may_be_unknown = true;
    batch->is_replayed = !unknown_is_set(&submissions->unknown);
}

/* ---- what command buffers recorded */

static void *capture(void *user, VkCommandBuffer handle)
{
    struct submissions *submissions = user;
    struct command_buffer *command_buffer =
        command_buffers_find(submissions->device->command_buffers, handle);
    return command_buffer && command_buffer->journal ? journal_share(command_buffer->journal)
                                                     : NULL;
}

static bool is_open(void *user, VkQueue queue, const void *captured)
{
    const struct submissions *submissions = user;
    return events_submit(submissions->device->events, queue, captured);
}

static void settle_binding(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct sparse_binding binding = journal_binding(entry);
    resources_settle_sparse(walk->user, &binding);
}

static void settle_bindings(struct resources *resources, struct journal *journal)
{
    static const struct journal_events settles = {.bind = settle_binding};
    journal_walk(journal, &settles, resources);
    journal->binds = false;
}

static void submissions_release(void *user, void *captured)
{
    const struct submissions *submissions = user;
    struct journal *journal = captured;
    if (journal->binds)
        settle_bindings(submissions->device->resources, journal);
    journal_release(captured);
}

struct execution_hooks submissions_hooks(struct submissions *submissions)
{
    return (struct execution_hooks){
        .user = submissions,
        .follows_host = submissions->device->finds_hazards,
        .capture = capture,
        .release = submissions_release,
        .is_open = is_open,
    };
}

/* ---- the consumer */

/* Looks for destroyed objects now: they are used from the submission on. When the batch runs, its
 * commands may have completed, and the application may have destroyed its objects. */
static void inspect(void *user, struct order_batch *batch)
{
    struct submissions *submissions = user;
    struct batch_check check = {submissions, batch};
    struct replay replay = replay_of(&check, batch);
    for (uint32_t i = 0; i < batch->command_count; i++) {
        const struct journal *journal = batch->commands[i].captured;
        if (journal_is_complete(journal))
            replay_destroyed(&replay, journal);
        else
            places_lack_memory(replay.places);
    }
    query_writes_submit(submissions->device->query_writes, batch);
}

static void submissions_fail(void *user, struct order_batch *batch)
{
    const struct submissions *submissions = user;
    query_writes_fail(submissions->device->query_writes, batch);
}

/* Judges a batch before its call goes down, so that a callback can have the call skipped. Applies
 * it at once, because all earlier batches have run. */
static void submissions_check(void *user, struct order_batch *batch)
{
    struct submissions *submissions = user;
    if (!unknown_is_set(&submissions->unknown))
        replay_batch(submissions, batch, true);
}

/* All batches that were checked and have not run belong to one call. */
static void undo(void *user, struct order_batch *batch)
{
    const struct submissions *submissions = user;
    (void)batch;
    structures_undo(submissions->device->structures);
}

static void submissions_run(void *user, struct order_batch *batch)
{
    struct submissions *submissions = user;
    bool is_done = batch->is_checked && batch->work == WORK_OF_QUEUE;
    if (batch->work != WORK_SYNC)
        structures_keep(submissions->device->structures);
    if (!is_done && batch->work != WORK_SYNC && !unknown_is_set(&submissions->unknown))
        replay_batch(submissions, batch, false);
    batch->is_replayed = !unknown_is_set(&submissions->unknown);
    query_writes_run(submissions->device->query_writes, batch);
}

static void submissions_ran(void *user, struct order_batch *batch)
{
    const struct submissions *submissions = user;
    struct journal *journal = batch->command_count ? batch->commands[0].captured : NULL;
    if (journal && journal->binds)
        settle_bindings(submissions->device->resources, journal);
}

static void order_unknown(void *user, enum order_unknown_reason why)
{
    set_order_unknown(user, why);
}

struct batch_consumer submissions_consumer(struct submissions *submissions)
{
    return (struct batch_consumer){
        .user = submissions,
        .submit = inspect,
        .check = submissions_check,
        .undo = undo,
        .run = submissions_run,
        .ran = submissions_ran,
        .fail = submissions_fail,
        .order_unknown = order_unknown,
    };
}
