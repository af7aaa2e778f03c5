/* SPDX-License-Identifier: Apache-2.0 */
/* Walks the journals of a batch, and reports the hazards of each command. */
#include "layer/hazards/executed/search.h"

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

static void forget_first(struct hazard_search *search)
{
    struct order_batch *batch =
        batch_list_take(search->batches, IN_EXECUTION_ORDER, USES_HAZARDS, NULL, NULL);
    search->judged_count--;
    if (batch == search->last)
        search->last = NULL;
    hazard_batch_free(batch->slots[USES_HAZARDS]);
    order_batch_release(batch);
}

/* After memory ran out, nothing that is known can be trusted: it counts as complete. */
static void start_over(struct hazard_search *search)
{
    uint64_t all[HAZARD_QUEUES];
    memset(all, 0xff, sizeof(all));
    unknown_follow(&search->shaders.tops_unknown, true);
    trace_search_forget_inputs(&search->shaders);
    hazard_search_forget_all_written(search);
    while (search->judged_count)
        forget_first(search);
    hazards_prune(search->hazards, all, HAZARD_QUEUES);
}

/* What executes at an unknown time is compared with nothing: neither with what executed before nor
 * with what seems to follow. */
static bool is_compared(const struct hazard_search *search)
{
    return search->current->batch->predecessors_known;
}

/* An access whose bytes are not known. */
static void judge_access_anywhere(struct hazard_search *search, enum access_kind kind)
{
    if (access_is_write(kind))
        hazards_write_anywhere(search->hazards, access_is_anywhere(kind) ? kind : ACCESS_KINDS,
                               NULL);
    else
        hazard_search_check_trace(search, kind);
}

/* What the access has read, if that is known. */
static void judge_data(struct hazard_search *search, const struct hazard_command *command,
                       const struct hazard_entry *item)
{
    struct hazard hazard;
    if (item->access != ACCESS_BUILD_SHADER_READ || !command->item || !command->item->build_count ||
        (item->role != HAZARD_VERTICES && item->role != HAZARD_BOXES &&
         item->role != HAZARD_INSTANCES))
        return;
    const struct data_read *data = hazard_batch_data(search->current, command, item);
    if (data && trace_search_read(&search->shaders, ACCESS_BUILD_SHADER_READ, data, &hazard))
        hazard_search_found(search, &hazard);
}

/* Whether the access concerns a structure, in the role of dst or src. */
static bool is_of_structure(const struct hazard_entry *item)
{
    return item->object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR &&
           (item->role == HAZARD_DST || item->role == HAZARD_TOP_DST || item->role == HAZARD_SRC);
}

/* A structure is written or read. The journal has only the first byte of the dst of a copy. */
static void judge_structure(struct hazard_search *search, const struct hazard_command *command,
                            const struct hazard_entry *item)
{
    struct hazard_access access = {(enum access_kind)item->access, item->bytes};
    if (item->role == HAZARD_SRC) {
        hazard_search_read_structure(search, &access, item->object);
        return;
    }
    if (item->bytes.end == item->bytes.begin + 1)
        access.bytes =
            hazard_batch_copied(search->current, command->journal, item->object, &item->bytes);
    const uint64_t number = hazards_access(search->hazards, &access);
    hazard_search_note_overwritten(search, &access, number, item->object);
    hazard_search_note_write(search, item->object, number, &access.bytes);
    if (item->role == HAZARD_DST)
        hazard_search_note_bottom_write(search, &access, item->object, number);
}

static void judge_bytes(struct hazard_search *search, const struct hazard_command *command,
                        const struct hazard_entry *item)
{
    const struct hazard_access access = {(enum access_kind)item->access, item->bytes};
    if (is_of_structure(item)) {
        judge_structure(search, command, item);
    } else {
        const uint64_t number = hazards_access(search->hazards, &access);
        if (access_is_write(access.kind))
            hazard_search_note_overwritten(search, &access, number, 0);
    }
    if (access_is_write(access.kind))
        trace_search_write(&search->shaders, &item->bytes);
}

/* ---- entries of a journal */

/* An access at an unknown time leaves nothing known of what it writes. */
static void judge_access(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct hazard_search *search = walk->user;
    const struct hazard_command *command = &search->command;
    if (!is_compared(search)) {
        if (item->role == HAZARD_TOP_DST)
            unknown_set(&search->shaders.tops_unknown, UNKNOWN_TRACED);
        if (is_of_structure(item))
            hazard_search_note_write(search, item->object, 0, NULL);
        return;
    }
    if (item->role == HAZARD_TRACED)
        hazard_search_add_traced(search, item);
    else if (item->role == HAZARD_USED)
        hazard_search_check_used(search, item);
    else if (item->role == HAZARD_SHADER && item->bytes.memory)
        hazards_write_anywhere(search->hazards, (enum access_kind)item->access, &item->bytes);
    else if (item->bytes.memory)
        judge_bytes(search, command, item);
    else
        judge_access_anywhere(search, (enum access_kind)item->access);
    if (item->role == HAZARD_TOP_DST)
        hazard_search_note_top(search, command, item);
    judge_data(search, command, item);
}

/* Each read takes its number, even if nothing is known of it. */
static void judge_vertices(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct hazard_search *search = walk->user;
    const struct hazard_command *command = &search->command;
    struct hazard_bytes vertices[HAZARD_INDEXED_READS];
    if (!is_compared(search) || !command->item)
        return;
    hazard_batch_vertices(search->current, command, item, vertices);
    for (uint32_t i = 0; i < HAZARD_INDEXED_READS; i++)
        hazards_access(search->hazards,
                       &(struct hazard_access){(enum access_kind)item->access, vertices[i]});
    judge_data(search, command, item);
}

/* What level content has found of a structure without a handle, or of a build at addresses. */
static void judge_placed(struct hazard_search *search, const struct hazard_input *input)
{
    const struct hazard_access access = {input->access, input->bytes};
    const uint64_t number = hazards_access(search->hazards, &access);
    if (!access_is_write(input->access))
        return;
    hazard_search_note_overwritten(search, &access, number, 0);
    trace_search_write(&search->shaders, &input->bytes);
}

static void judge_references(struct hazard_search *search, const struct hazard_command *command)
{
    uint32_t count;
    const struct hazard_input *references =
        hazard_batch_references(search->current, command, &count);
    for (uint32_t i = 0; i < count && is_compared(search); i++) {
        if (references[i].is_placed) {
            judge_placed(search, &references[i]);
            continue;
        }
        hazard_search_read_reference(
            search, &(struct hazard_access){ACCESS_BUILD_ACCEL_READ, references[i].bytes},
            references[i].structure, references[i].place.position);
        trace_search_add_reference(
            &search->shaders, command->first, references[i].place.position,
            &(struct top_reference){references[i].structure, references[i].bytes.memory});
    }
}

static void end_command(struct hazard_search *search)
{
    if (search->command.item)
        judge_references(search, &search->command);
    search->command.item = NULL;
    hazard_search_report(search);
}

static void begin_command(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct hazard_search *search = walk->user;
    end_command(search);
    trace_search_begin_command(&search->shaders);
    search->command = (struct hazard_command){hazards_begin_command(search->hazards), walk->journal,
                                              item, walk->place};
    if (!hazard_batch_note(search->current, &search->command))
        unknown_set(&search->unknown, UNKNOWN_HAZARDS);
}

/* Judges barriers, the first of which is `item`: those of a command, or of a wait for an event. */
static void judge_barriers(struct journal_walk *walk, const struct hazard_entry *item,
                           const struct hazard_entry *wait)
{
    struct hazard_search *search = walk->user;
    struct hazard_barrier few[BARRIERS_AT_ONCE], *barriers = few;
    uint32_t count = wait ? wait->barrier_count : item->barrier_count;
    if (count > BARRIERS_AT_ONCE)
        barriers = malloc(count * sizeof(*barriers));
    if (!barriers) {
        unknown_set(&search->unknown, UNKNOWN_HAZARDS);
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
        hazards_wait_event(search->hazards, wait->object, barriers, filled);
    else
        hazards_barriers(search->hazards, barriers, filled);
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
    struct hazard_search *search = walk->user;
    end_command(search);
    hazards_set_event(search->hazards, item->object, item->dependency.src);
}

/* Other uses have entries of setting hazards. */
static void judge_reset_event(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct hazard_search *search = walk->user;
    if (entry->info != EVENT_RESET)
        return;
    end_command(search);
    hazards_reset_event(search->hazards, entry->dst);
}

static void judge_wait_event(struct journal_walk *walk, const struct hazard_entry *item)
{
    end_command(walk->user);
    judge_barriers(walk, item->barrier_count ? hazard_next(walk) : NULL, item);
}

static void judge_journal(struct hazard_search *search, const struct journal *journal);

static void judge_secondary(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct hazard_search *search = walk->user;
    end_command(search);
    judge_journal(search, entry->secondary);
}

/* If entries are missing, nothing is reported, not even of this journal: a barrier may be missing.
 */
static void judge_journal(struct hazard_search *search, const struct journal *journal)
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
        &search->unknown,
        unknown_is_set(
            &journal->accesses_unknown)); /* barriers between its accesses may be missing */
    journal_walk(journal, &judges, search);
    end_command(search);
}

/* ---- a batch */

static void judge_waits(struct hazard_search *search, const struct order_batch *batch)
{
    for (uint32_t i = 0; i < batch->operation_count; i++) {
        const struct semaphore_operation *operation = &batch->operations[i];
        const struct dependency scope = dependency_of_wait(operation->stages);
        if (!operation->is_signal && !operation->is_met)
            hazards_wait(search->hazards, operation->signal, &scope);
    }
}

/* Later signals of the queue include what a fence waits for. */
static void judge_signals(struct hazard_search *search, const struct order_batch *batch)
{
    const struct dependency all = dependency_of_signal(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    for (uint32_t i = 0; i < batch->operation_count; i++) {
        const struct semaphore_operation *operation = &batch->operations[i];
        const struct dependency scope = dependency_of_signal(operation->stages);
        if (operation->is_signal)
            hazards_signal(search->hazards, operation->signal, operation->previous, &scope);
    }
    if (batch->signals_fence)
        hazards_signal(search->hazards, 0, 0, &all);
}

/* Drops what had completed, as the host knew, when the last batch was submitted. The host may know
 * more now, but batches that are yet to be judged may have been submitted before it did. */
static void prune_records(struct hazard_search *search, const struct execution_clock *completed)
{
    const struct order_batch *first;
    hazards_prune(search->hazards, completed->counts, completed->queues);
    while ((first = hazard_search_next(search, NULL)) &&
           execution_clock_has(completed, first->timestamp))
        forget_first(search);
}

static void keep_record(struct hazard_search *search, struct hazard_batch_record *record,
                        const struct execution_clock *completed)
{
    search->current = NULL;
    search->last = record->batch;
    search->judged_count++;
    search->batch_count++;
    prune_records(search, completed);
    if (search->judged_count <= BATCHES_KEPT)
        return;
    unknown_follow(&search->unknown, true);
    reporter_add_unchecked(search->device->instance->reporter,
                           "batches for hazards, because more are pending than the layer tracks",
                           search->judged_count);
}

void hazard_search_end_object(struct hazard_search *search, const struct ended_object *ended)
{
    switch (ended->ended) {
    case MEMORY_FREED:
        hazard_search_end_traced(search, ended);
        hazards_forget_memory(search->hazards, ended->id);
        trace_search_forget_memory(&search->shaders, ended->id);
        break;
    case EVENT_DESTROYED:
        hazards_reset_event(search->hazards, ended->id);
        break;
    case STRUCTURE_DESTROYED:
        hazard_search_end_traced(search, ended);
        hazard_search_note_write(search, ended->id, 0, NULL);
        break;
    }
}

static void judge_commands(struct hazard_search *search, const struct order_batch *batch,
                           const struct execution_clock *completed)
{
    struct execution_clock before;
    const uint64_t forgotten_write = hazards_last_forgotten_write(search->hazards);
    execution_clock_copy(&before, &batch->clock);
    execution_clock_extend(&before, completed->queues);
    hazards_begin_batch(search->hazards, &(struct hazard_batch){
                                             .queue = batch->timestamp.queue,
                                             .number = batch->timestamp.count,
                                             .completed = completed->counts,
                                             .before = before.counts,
                                             .count = before.queues,
                                             .is_certain = batch->predecessors_known,
                                         });
    judge_waits(search, batch);
    for (uint32_t i = 0; i < batch->command_count; i++)
        if (batch->commands[i].captured)
            judge_journal(search, batch->commands[i].captured);
    judge_signals(search, batch);
    hazards_end_batch(search->hazards);
    if (hazards_last_forgotten_write(search->hazards) != forgotten_write)
        reporter_add_unchecked(search->device->instance->reporter,
                               "batches with more writes of shaders than the layer tracks", 1);
}

void hazard_search_batch(struct hazard_search *search, struct hazard_batch_record *record)
{
    const struct order_batch *batch = record->batch;
    struct execution_clock completed;
    execution_clock_copy(&completed, batch->host);
    execution_clock_extend(&completed, batch->clock.queues);
    search->current = record;
    if (unknown_is_set(&search->unknown))
        start_over(search);
    search->unknown = record->inputs_unknown;
    hazard_batch_sort(record);
    judge_commands(search, batch, &completed);
    /* From now on the application may know that the batch is complete. */
    if (batch->signals_foreign_object)
        unknown_set(&search->unknown, UNKNOWN_EXPOSED);
    keep_record(search, record, &completed);
}

/* ---- creation */

bool hazard_search_begin(struct hazard_search *search, struct layer_device *device)
{
    search->device = device;
    search->batches = execution_order_batches(device->order);
    search->hazards = hazards_create(hazard_search_found, search);
    trace_search_begin(&search->shaders, device->instance->reporter, search->hazards);
    /* A shader may trace a null descriptor, or a structure that an unknown command built. */
    unknown_follow(&search->shaders.tops_unknown, device->facts.null_descriptor);
    return search->hazards;
}

void hazard_search_end(struct hazard_search *search)
{
    while (search->judged_count)
        forget_first(search);
    trace_search_end(&search->shaders);
    hazard_search_forget_all_written(search);
    hazards_destroy(search->hazards);
}
