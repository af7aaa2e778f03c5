/* SPDX-License-Identifier: Apache-2.0 */
/* Walks the journals of a batch, and reports the hazards of each command. */
#include "layer/hazards/executed/judge.h"

#include <stdlib.h>
#include <string.h>

#include "layer/hazards/executed/overwritten.h"
#include "layer/hazards/executed/traces.h"
#include "src/state/commands/journal.h"
#include "src/state/order/order.h"

enum {
    BARRIERS_AT_ONCE = 64, /* more need memory */
    /* If the host has not observed the completion of so many batches, all are forgotten. */
    BATCHES_KEPT = 4096,
};

/* ---- judging */

static void forget_first(struct hazard_judge *judge)
{
    struct order_batch *batch =
        batch_list_take(judge->batches, IN_EXECUTION_ORDER, USES_HAZARDS, NULL, NULL);
    judge->judged_count--;
    if (batch == judge->last)
        judge->last = NULL;
    hazard_batch_free(batch->slots[USES_HAZARDS]);
    order_batch_release(batch);
}

/* After memory ran out, nothing that is known can be trusted: it counts as complete. */
static void start_over(struct hazard_judge *judge)
{
    uint64_t all[HAZARD_QUEUES];
    memset(all, 0xff, sizeof(all));
    unknown_follow(&judge->shaders.tops_unknown, true);
    shader_judge_forget_inputs(&judge->shaders);
    judge_forget_all_written(judge);
    while (judge->judged_count)
        forget_first(judge);
    hazards_prune(judge->hazards, all, HAZARD_QUEUES);
}

/* What executes at an unknown time is compared with nothing: neither with what executed before nor
 * with what seems to follow. */
static bool is_compared(const struct hazard_judge *judge)
{
    return judge->current->batch->predecessors_known;
}

/* An access whose bytes are not known. */
static void judge_access_anywhere(struct hazard_judge *judge, enum access_kind kind)
{
    if (access_is_write(kind))
        hazards_write_anywhere(judge->hazards, access_is_anywhere(kind) ? kind : ACCESS_KINDS,
                               NULL);
    else
        judge_trace(judge, kind);
}

/* What the access has read, if that is known. */
static void judge_data(struct hazard_judge *judge, const struct hazard_command *command,
                       const struct hazard_entry *item)
{
    struct hazard hazard;
    if (item->access != ACCESS_BUILD_SHADER_READ || !command->item || !command->item->info ||
        (item->role != HAZARD_VERTICES && item->role != HAZARD_BOXES &&
         item->role != HAZARD_INSTANCES))
        return;
    const struct data_read *data = hazard_batch_data(judge->current, command, item);
    if (data && shader_judge_read(&judge->shaders, ACCESS_BUILD_SHADER_READ, data, &hazard))
        hazard_judge_found(judge, &hazard);
}

/* Whether the access concerns a structure, in the role of dst or src. */
static bool is_of_structure(const struct hazard_entry *item)
{
    return item->object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR &&
           (item->role == HAZARD_DST || item->role == HAZARD_TOP_DST || item->role == HAZARD_SRC);
}

/* A structure is written or read. Of the dst of a copy, the journal has the first byte. */
static void judge_structure(struct hazard_judge *judge, const struct hazard_command *command,
                            const struct hazard_entry *item)
{
    struct hazard_access access = {(enum access_kind)item->access, item->bytes};
    if (item->role == HAZARD_SRC) {
        judge_structure_read(judge, &access, item->object);
        return;
    }
    if (item->bytes.end == item->bytes.begin + 1)
        access.bytes =
            hazard_batch_copied(judge->current, command->journal, item->object, &item->bytes);
    const uint64_t number = hazards_access(judge->hazards, &access);
    judge_overlaps(judge, &access, number, item->object);
    judge_written(judge, item->object, number, &access.bytes);
    if (item->role == HAZARD_DST)
        judge_bottom(judge, &access, item->object, number);
}

static void judge_bytes(struct hazard_judge *judge, const struct hazard_command *command,
                        const struct hazard_entry *item)
{
    const struct hazard_access access = {(enum access_kind)item->access, item->bytes};
    if (is_of_structure(item)) {
        judge_structure(judge, command, item);
    } else {
        const uint64_t number = hazards_access(judge->hazards, &access);
        if (access_is_write(access.kind))
            judge_overlaps(judge, &access, number, 0);
    }
    if (access_is_write(access.kind))
        shader_judge_write(&judge->shaders, &item->bytes);
}

/* ---- entries of a journal */

/* An access at an unknown time leaves nothing known of what it writes. */
static void judge_access(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct hazard_judge *judge = walk->user;
    const struct hazard_command *command = &judge->command;
    if (!is_compared(judge)) {
        if (item->role == HAZARD_TOP_DST)
            unknown_set(&judge->shaders.tops_unknown, UNKNOWN_TRACED);
        if (is_of_structure(item))
            judge_written(judge, item->object, 0, NULL);
        return;
    }
    if (item->role == HAZARD_TRACED)
        judge_traced(judge, item);
    else if (item->role == HAZARD_USED)
        judge_used(judge, item);
    else if (item->role == HAZARD_SHADER && item->bytes.memory)
        hazards_write_anywhere(judge->hazards, (enum access_kind)item->access, &item->bytes);
    else if (item->bytes.memory)
        judge_bytes(judge, command, item);
    else
        judge_access_anywhere(judge, (enum access_kind)item->access);
    if (item->role == HAZARD_TOP_DST)
        judge_top(judge, command, item);
    judge_data(judge, command, item);
}

/* Each read takes its number, even if nothing is known of it. */
static void judge_vertices(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct hazard_judge *judge = walk->user;
    const struct hazard_command *command = &judge->command;
    struct hazard_bytes vertices[HAZARD_INDEXED_READS];
    if (!is_compared(judge) || !command->item)
        return;
    hazard_batch_vertices(judge->current, command, item, vertices);
    for (uint32_t i = 0; i < HAZARD_INDEXED_READS; i++)
        hazards_access(judge->hazards,
                       &(struct hazard_access){(enum access_kind)item->access, vertices[i]});
    judge_data(judge, command, item);
}

static void judge_references(struct hazard_judge *judge, const struct hazard_command *command)
{
    uint32_t count;
    const struct hazard_input *references =
        hazard_batch_references(judge->current, command, &count);
    for (uint32_t i = 0; i < count && is_compared(judge); i++) {
        judge_reference_read(judge,
                             &(struct hazard_access){ACCESS_BUILD_ACCEL_READ, references[i].bytes},
                             references[i].structure, references[i].place.position);
        shader_judge_add_reference(
            &judge->shaders, command->first, references[i].place.position,
            &(struct top_reference){references[i].structure, references[i].bytes.memory});
    }
}

static void end_command(struct hazard_judge *judge)
{
    if (judge->command.item)
        judge_references(judge, &judge->command);
    judge->command.item = NULL;
    hazard_judge_report(judge);
}

static void begin_command(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct hazard_judge *judge = walk->user;
    end_command(judge);
    shader_judge_begin_command(&judge->shaders);
    judge->command = (struct hazard_command){hazards_begin_command(judge->hazards), walk->journal,
                                             item, walk->place};
    if (!hazard_batch_note(judge->current, &judge->command))
        unknown_set(&judge->unknown, UNKNOWN_HAZARDS);
}

/* Judges barriers, the first of which is `item`: those of a command, or of a wait for an event. */
static void judge_barriers(struct journal_walk *walk, const struct hazard_entry *item,
                           const struct hazard_entry *wait)
{
    struct hazard_judge *judge = walk->user;
    struct hazard_barrier few[BARRIERS_AT_ONCE], *barriers = few;
    uint32_t count = wait ? wait->count : item->count;
    if (count > BARRIERS_AT_ONCE)
        barriers = malloc(count * sizeof(*barriers));
    if (!barriers) {
        unknown_set(&judge->unknown, UNKNOWN_HAZARDS);
        barriers = few;
        count = BARRIERS_AT_ONCE;
    }
    uint32_t filled = 0;
    for (; item && filled < count; item = filled < count ? hazard_next(walk) : NULL)
        barriers[filled++] = (struct hazard_barrier){.dependency = item->dependency,
                                                     .is_global = item->is_global,
                                                     .bytes = item->bytes,
                                                     .is_acquisition = item->is_acquisition};
    if (wait)
        hazards_wait_event(judge->hazards, wait->object, barriers, filled);
    else
        hazards_barriers(judge->hazards, barriers, filled);
    if (barriers != few)
        free(barriers);
}

static void judge_barrier(struct journal_walk *walk, const struct hazard_entry *item)
{
    end_command(walk->user);
    judge_barriers(walk, item, NULL);
}

static void judge_set_event(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct hazard_judge *judge = walk->user;
    end_command(judge);
    hazards_set_event(judge->hazards, item->object, item->dependency.src);
}

/* Other uses have entries of setting hazards. */
static void judge_reset_event(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct hazard_judge *judge = walk->user;
    if (entry->info != EVENT_RESET)
        return;
    end_command(judge);
    hazards_reset_event(judge->hazards, entry->dst);
}

static void judge_wait_event(struct journal_walk *walk, const struct hazard_entry *item)
{
    end_command(walk->user);
    judge_barriers(walk, item->count ? hazard_next(walk) : NULL, item);
}

static void judge_journal(struct hazard_judge *judge, const struct journal *journal);

static void judge_secondary(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct hazard_judge *judge = walk->user;
    end_command(judge);
    judge_journal(judge, entry->secondary);
}

/* If entries are missing, nothing is reported, not even of this journal: a barrier may be missing.
 */
static void judge_journal(struct hazard_judge *judge, const struct journal *journal)
{
    static const struct journal_events judges = {.hazard_access = judge_access,
                                                 .hazard_indexed = judge_vertices,
                                                 .hazard_command = begin_command,
                                                 .hazard_barrier = judge_barrier,
                                                 .hazard_set_event = judge_set_event,
                                                 .hazard_wait_event = judge_wait_event,
                                                 .use_event = judge_reset_event,
                                                 .execute = judge_secondary};
    unknown_follow(
        &judge->unknown,
        unknown_is_set(
            &journal->accesses_unknown)); /* barriers between its accesses may be missing */
    journal_walk(journal, &judges, judge);
    end_command(judge);
}

/* ---- a batch */

static void judge_waits(struct hazard_judge *judge, const struct order_batch *batch)
{
    for (uint32_t i = 0; i < batch->operation_count; i++) {
        const struct semaphore_operation *operation = &batch->operations[i];
        const struct dependency scope = dependency_of_wait(operation->stages);
        if (!operation->is_signal && !operation->is_met)
            hazards_wait(judge->hazards, operation->signal, &scope);
    }
}

/* Later signals of the queue include what a fence waits for. */
static void judge_signals(struct hazard_judge *judge, const struct order_batch *batch)
{
    const struct dependency all = dependency_of_signal(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    for (uint32_t i = 0; i < batch->operation_count; i++) {
        const struct semaphore_operation *operation = &batch->operations[i];
        const struct dependency scope = dependency_of_signal(operation->stages);
        if (operation->is_signal)
            hazards_signal(judge->hazards, operation->signal, operation->previous, &scope);
    }
    if (batch->signals_fence)
        hazards_signal(judge->hazards, 0, 0, &all);
}

/* Drops what had completed, as the host knew, when the last batch was submitted. The host may know
 * more now, but batches that are yet to be judged may have been submitted before it did. */
static void prune_records(struct hazard_judge *judge, const struct execution_clock *completed)
{
    const struct order_batch *first;
    hazards_prune(judge->hazards, completed->counts, completed->queues);
    while ((first = hazard_judge_next(judge, NULL)) &&
           execution_clock_has(completed, first->timestamp))
        forget_first(judge);
}

static void keep_record(struct hazard_judge *judge, struct hazard_batch_record *record,
                        const struct execution_clock *completed)
{
    judge->current = NULL;
    judge->last = record->batch;
    judge->judged_count++;
    judge->batch_count++;
    prune_records(judge, completed);
    if (judge->judged_count <= BATCHES_KEPT)
        return;
    unknown_follow(&judge->unknown, true);
    reporter_add_unchecked(judge->device->instance->reporter,
                           "batches for hazards, because more are pending than the layer tracks",
                           judge->judged_count);
}

void hazard_judge_end_object(struct hazard_judge *judge, const struct ended_object *ended)
{
    switch (ended->ended) {
    case MEMORY_FREED:
        judge_end_of_traced(judge, ended);
        hazards_forget_memory(judge->hazards, ended->id);
        shader_judge_forget_memory(&judge->shaders, ended->id);
        break;
    case EVENT_DESTROYED:
        hazards_reset_event(judge->hazards, ended->id);
        break;
    case STRUCTURE_DESTROYED:
        judge_end_of_traced(judge, ended);
        judge_written(judge, ended->id, 0, NULL);
        break;
    }
}

static void judge_commands(struct hazard_judge *judge, const struct order_batch *batch,
                           const struct execution_clock *completed)
{
    struct execution_clock before;
    const uint64_t lost_write = hazards_lost_write(judge->hazards);
    execution_clock_copy(&before, &batch->clock);
    execution_clock_extend(&before, completed->queues);
    hazards_begin_batch(judge->hazards, &(struct hazard_batch){
                                            .queue = batch->timestamp.queue,
                                            .number = batch->timestamp.count,
                                            .completed = completed->counts,
                                            .before = before.counts,
                                            .count = before.queues,
                                            .is_certain = batch->predecessors_known,
                                        });
    judge_waits(judge, batch);
    for (uint32_t i = 0; i < batch->command_count; i++)
        if (batch->commands[i].captured)
            judge_journal(judge, batch->commands[i].captured);
    judge_signals(judge, batch);
    hazards_end_batch(judge->hazards);
    if (hazards_lost_write(judge->hazards) != lost_write)
        reporter_add_unchecked(judge->device->instance->reporter,
                               "batches with more writes of shaders than the layer tracks", 1);
}

void hazard_judge_batch(struct hazard_judge *judge, struct hazard_batch_record *record)
{
    const struct order_batch *batch = record->batch;
    struct execution_clock completed;
    execution_clock_copy(&completed, batch->host);
    execution_clock_extend(&completed, batch->clock.queues);
    judge->current = record;
    if (unknown_is_set(&judge->unknown))
        start_over(judge);
    judge->unknown = record->inputs_unknown;
    hazard_batch_sort(record);
    judge_commands(judge, batch, &completed);
    /* From now on the application may know that the batch is complete. */
    if (batch->is_exposed)
        unknown_set(&judge->unknown, UNKNOWN_EXPOSED);
    keep_record(judge, record, &completed);
}

/* ---- creation */

bool hazard_judge_begin(struct hazard_judge *judge, struct layer_device *device)
{
    judge->device = device;
    judge->batches = execution_order_batches(device->order);
    judge->hazards = hazards_create(hazard_judge_found, judge);
    shader_judge_begin(&judge->shaders, device->instance->reporter, judge->hazards);
    /* A shader may trace a null descriptor, or a structure that an unknown command built. */
    unknown_follow(&judge->shaders.tops_unknown, device->facts.null_descriptor);
    return judge->hazards;
}

void hazard_judge_end(struct hazard_judge *judge)
{
    while (judge->judged_count)
        forget_first(judge);
    shader_judge_end(&judge->shaders);
    judge_forget_all_written(judge);
    hazards_destroy(judge->hazards);
}
