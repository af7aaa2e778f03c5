/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the copies of an execution, build by build, and reports the findings. */
#include "layer/execution/input_check_run.h"

#include <stdlib.h>

#include "layer/accel_addresses.h"
#include "layer/build_sizes.h"
#include "layer/compare/comparer.h"
#include "layer/execution/hazards/checks.h"
#include "layer/snapshots/coverage_warnings.h"
#include "layer/snapshots/guard/results.h"
#include "layer/snapshots/marks.h"
#include "src/base/float_environment.h"
#include "src/check/content/executed.h"
#include "src/platform/threads.h"

/* A finding to be reported later, because the execution is locked while its snapshots are read. */
struct pending_finding {
    struct pending_finding *next;
    const struct journal *journal;
    uint32_t first; /* position of the call's first build in the command buffer */
    enum rule rule;
    struct location location;
    struct finding finding;
};

/* One build call of a command buffer. Calls with instances are ended after all locks are released,
 * because their checks look beyond one build. */
struct read_call {
    struct read_call *next;
    struct reading *reading;
    const struct journal *journal;
    uint32_t first;
    enum build_command command;
    bool geometry_by_pointer; /* of the current build */
    struct check_context context;
    struct executed_call *executed;
};

struct reading {
    const struct ran_execution *ran;
    struct replay replay;
    uint32_t next_note, next_used, next_execution_point;
    struct read_call *open_calls;
    struct pending_finding *findings, **findings_last;
    struct guard_results guarded;
    bool has_addresses; /* of all structures, see query_addresses() */
    bool lacks_memory;  /* some inputs could not be validated */
    const char *when;   /* see input_checks_read() */
    bool lacks_marks;   /* the device may not have copied the inputs of some builds */
    bool lacks_copies;  /* the device has not executed some copies */
};

/* ---- findings */

/* For struct replay, too. */
static bool keep_finding(void *user, const struct journal *journal, uint32_t first_build,
                         enum rule rule, const struct location *location,
                         const struct finding *finding)
{
    struct reading *reading = user;
    const struct reporter *reporter = reading->ran->device->instance->reporter;
    struct pending_finding *pending = malloc(sizeof(*pending));
    reading->lacks_memory |= !pending;
    if (pending) {
        *pending = (struct pending_finding){NULL, journal, first_build, rule, *location, *finding};
        *reading->findings_last = pending;
        reading->findings_last = &pending->next;
    }
    return reporter_wants(reporter, rule_infos[rule].vuid[location->command]);
}

static bool found(void *user, enum rule rule, const struct location *location,
                  const struct finding *finding)
{
    const struct read_call *call = user;
    struct location there = *location;
    there.geometry_by_pointer = call->geometry_by_pointer;
    return keep_finding(call->reading, call->journal, call->first, rule, &there, finding);
}

static void report_findings(struct reading *reading)
{
    const struct layer_device *device = reading->ran->device;
    while (reading->findings) {
        struct pending_finding *pending = reading->findings;
        uint32_t position = pending->first + pending->location.build;
        const struct call_origin origin = {
            .device = device->handle,
            .names = device->names,
            .queue = reading->ran->queue,
            .submission = reading->ran->submission,
            .queue_labels = shared_labels_stack(reading->ran->queue_labels),
            .command_buffer = pending->journal->command_buffer,
            .build_index = pending->first,
            .labels = journal_labels_at(pending->journal, position),
            .call_site = journal_call_site_at(pending->journal, position),
            .replaced =
                guard_results_explain(&reading->guarded, pending->journal, position, pending->rule),
            .when = reading->when,
            .destroyed = device->destroyed,
            .submissions = reading->ran->execution->submissions,
        };
        reporter_send(device->instance->reporter, pending->rule, &pending->location, &origin,
                      &pending->finding);
        reading->findings = pending->next;
        free(pending);
    }
}

/* ---- calls */

static void find_sizes(void *user, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                       struct size_facts *sizes)
{
    const struct read_call *call = user;
    layer_find_build_sizes(call->reading->ran->device, info, counts, build_type, sizes);
}

/* Once for each execution, because a search costs time. */
static void query_addresses(void *user)
{
    const struct read_call *call = user;
    struct reading *reading = call->reading;
    if (!reading->has_addresses)
        layer_query_accel_address(reading->ran->device, VK_NULL_HANDLE);
    reading->has_addresses = true;
}

static bool of_another_device(void *user, enum resource_kind kind, uint64_t handle)
{
    const struct read_call *call = user;
    return layer_other_device_has(call->reading->ran->device, kind, handle);
}

static void refers(void *user, uint32_t position, const struct accel_facts *referenced)
{
    const struct read_call *call = user;
    const struct ran_execution *ran = call->reading->ran;
    hazard_checks_refer(ran->device->hazard_checks, ran->timestamp, call->journal, position,
                        referenced);
}

static void indexes(void *user, uint32_t build, uint32_t geometry, uint32_t smallest,
                    uint32_t largest)
{
    const struct read_call *call = user;
    const struct ran_execution *ran = call->reading->ran;
    const struct hazard_indices indices = {
        {call->journal, call->first + build, geometry}, smallest, largest};
    hazard_checks_index(ran->device->hazard_checks, ran->timestamp, &indices);
}

static const struct check_hooks hooks = {.found = found,
                                         .find_sizes = find_sizes,
                                         .refers = refers,
                                         .query_addresses = query_addresses,
                                         .indexes = indexes,
                                         .of_another_device = of_another_device};

static struct read_call *begin_call(struct reading *reading, const struct journal *journal,
                                    const struct recorded_place *place)
{
    const struct layer_device *device = reading->ran->device;
    struct read_call *call = calloc(1, sizeof(*call));
    if (!call)
        return NULL;
    call->reading = reading;
    call->journal = journal;
    call->first = place->position - place->info;
    call->command = place->command;
    call->context = (struct check_context){
        .hooks = &hooks,
        .user = call,
        .level = device->level,
        .active = device->active_rules[place->command],
        .resources = device->resources,
        .destroy_count = reading->ran->execution->destroy_count,
        .flags = device->built_flags,
    };
    call->executed = executed_call_begin(&call->context, &device->facts, place->command);
    if (call->executed)
        return call;
    free(call);
    return NULL;
}

static void end_call(struct read_call *call)
{
    struct readable_cache cache = {0};
    call->context.readable = &cache;
    executed_call_end(call->executed);
    free(call);
}

static void leave_call(struct read_call *call)
{
    if (!call)
        return;
    if (!executed_call_has_instances(call->executed)) {
        end_call(call);
        return;
    }
    call->next = call->reading->open_calls;
    call->reading->open_calls = call;
}

static bool is_of_call(const struct read_call *call, const struct recorded_place *place)
{
    return call && call->first == place->position - place->info && call->command == place->command;
}

/* ---- builds */

/* One command buffer, and positions in its journal. */
struct read_buffer {
    struct reading *reading;
    struct execution *execution;
    bool is_known; /* its copies can be read */
    const struct journal *journal;
    struct journal_cursor builds, secondaries;
    struct read_call *call;
};

/* The journal entry of a build. Returns NULL if there is none. */
static const struct journal_entry *find_entry(struct read_buffer *buffer, uint32_t position)
{
    struct journal_cursor cursor = buffer->builds;
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));
         buffer->builds = cursor) {
        if (entry->built.position > position)
            return NULL;
        if (entry->built.position == position)
            return entry;
    }
    return NULL;
}

/* Finds the note of an entry. Each entry has a note, in the order of the builds. Notes in between
 * belong to builds that were not recorded. */
static const struct input_note *find_note(struct reading *reading,
                                          const struct journal_entry *entry)
{
    const struct input_notes *notes = &reading->ran->notes;
    while (entry && entry->built.shapes && reading->next_note < notes->count) {
        const struct input_note *note = &notes->items[reading->next_note++];
        if (note->entry == entry)
            return note;
    }
    return NULL;
}

/* Finds the micromaps of a build. They are consecutive, in the order of the build's geometries. */
static uint32_t find_used(struct read_buffer *buffer, const struct recorded_build *build,
                          const struct used_micromap_note **used)
{
    const struct input_notes *notes = &buffer->reading->ran->notes;
    uint32_t first = buffer->reading->next_used, position = build->place.position;
    if (!build->parameters.chained)
        return 0;
    while (first < notes->used_count && (notes->used[first].journal != buffer->journal ||
                                         notes->used[first].position != position))
        first++;
    uint32_t end = first;
    while (end < notes->used_count && notes->used[end].journal == buffer->journal &&
           notes->used[end].position == position &&
           (end == first || notes->used[end].geometry > notes->used[end - 1].geometry))
        end++;
    if (end > first)
        buffer->reading->next_used = end;
    *used = end > first ? &notes->used[first] : NULL;
    return end - first;
}

static const struct execution_point *find_execution_point(struct read_buffer *buffer,
                                                          const struct recorded_build *build)
{
    const struct input_notes *notes = &buffer->reading->ran->notes;
    if (build->parameters.info.type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR)
        return NULL;
    for (uint32_t i = buffer->reading->next_execution_point; i < notes->point_count; i++) {
        const struct execution_point_note *note = &notes->points[i];
        if (note->journal != buffer->journal || note->position != build->place.position)
            continue;
        buffer->reading->next_execution_point = i + 1;
        return &note->point;
    }
    return NULL;
}

/* What the replay noted of one build. */
struct found_notes {
    const struct journal_entry *entry; /* may be NULL, as may the pointers below */
    const struct input_note *inputs;
    const struct execution_point *point;
    const struct used_micromap_note *used;
    uint32_t used_count;
};

/* Called for each build of the execution in turn, also for those that are not read: a secondary
 * command buffer that was executed twice has the same entries twice. */
static struct found_notes find_notes(struct read_buffer *buffer, const struct recorded_build *build)
{
    struct found_notes found = {.entry = find_entry(buffer, build->place.position)};
    if (buffer->reading->ran->notes.lacks_memory)
        return found;
    found.inputs = find_note(buffer->reading, found.entry);
    found.point = find_execution_point(buffer, build);
    found.used_count = find_used(buffer, build, &found.used);
    return found;
}

static void read_build(struct read_buffer *buffer, const struct recorded_item *item,
                       const struct found_notes *notes)
{
    const struct recorded_build *build = item->build;
    const struct input_note *note = notes->inputs;
    struct reading *reading = buffer->reading;
    struct snapshot_memory memory = {
        .snapshots = build->snapshots,
        .count = build->snapshot_count,
        .bases = buffer->execution->bases,
        .gathering = &build->gathering,
        .omits_unread = true,
    };
    bool is_open = snapshot_memory_open(&memory);
    if (!is_open || memory.lacks_copies) {
        reading->lacks_memory |= !is_open;
        reading->lacks_copies |= memory.lacks_copies;
        snapshot_memory_close(&memory);
        return;
    }
    struct executed_build executed = {
        .build = build,
        .dst_id = notes->entry ? notes->entry->dst_id : 0,
        .memory = snapshot_memory_of(&memory),
        .inputs = note ? note->inputs : NULL,
        .source_inputs = note ? note->source.inputs : NULL,
        .point = notes->point,
        .used = notes->used,
        .used_count = notes->used_count,
    };
    buffer->call->geometry_by_pointer = build->place.geometry_by_pointer;
    executed_call_read(buffer->call->executed, &executed);
    guard_results_add(&reading->guarded, buffer->journal, build, buffer->execution->bases);
    const struct executed_input input = {buffer->journal, notes->entry, item, &executed.memory,
                                         buffer->execution->destroy_count};
    if (!reading->when)
        comparer_keep(reading->ran->device->comparer, &input);
    snapshot_memory_close(&memory);
    if (note)
        replay_judge_inputs(&reading->replay, note);
}

/* Whether this thread is to validate the build now. The device executes the calls of a command
 * buffer in order, so one number says which builds were validated before completion. After the
 * device was lost, several threads may read the same execution: one of them validates a build. */
static bool is_readable(struct read_buffer *buffer, uint32_t position)
{
    struct execution *execution = buffer->execution;
    unsigned judged_end = atomic_load(&execution->judged_end);
    if (position < judged_end)
        return false;
    if (!buffer->reading->when)
        return true;
    if (recording_mark_state(execution->recording, position, execution->ticket->number) <
        MARK_HAS_COPIES) {
        buffer->reading->lacks_marks = true;
        return false;
    }
    return atomic_compare_exchange_strong(&execution->judged_end, &judged_end, position + 1);
}

static void read_item(struct read_buffer *buffer, const struct recorded_item *item)
{
    const struct recorded_place *place = &item->build->place;
    const struct found_notes notes = find_notes(buffer, item->build);
    if (!buffer->is_known || !is_readable(buffer, place->position))
        return;
    if (!is_of_call(buffer->call, place)) {
        leave_call(buffer->call);
        buffer->call = begin_call(buffer->reading, buffer->journal, place);
    }
    if (buffer->call)
        read_build(buffer, item, &notes);
    else
        buffer->reading->lacks_memory = true;
}

/* ---- command buffers */

static const struct journal *find_secondary(struct read_buffer *buffer,
                                            const struct recording *recording)
{
    for (const struct journal_entry *entry; (entry = journal_next(&buffer->secondaries));)
        if (entry->secondary->work == recording)
            return entry->secondary;
    return NULL;
}

static void read_execution(struct reading *reading, struct execution *execution,
                           const struct journal *journal)
{
    struct read_buffer buffer = {.reading = reading,
                                 .execution = execution,
                                 .journal = journal,
                                 .builds = journal_start(journal, JOURNAL_BUILDS),
                                 .secondaries =
                                     journal_start(journal, JOURNAL_BIT(JOURNAL_EXECUTE))};
    uint32_t child = 0;
    shared_lock_read(&execution->lock);
    buffer.is_known = !execution->has_no_snapshots && !atomic_load(&execution->is_overwritten);
    for (const struct recorded_item *item = NULL; (item = execution_next(execution, item));) {
        if (item->kind == ITEM_BUILD || item->kind == ITEM_UPDATE)
            read_item(&buffer, item);
        if (item->kind != ITEM_EXECUTE)
            continue;
        const struct journal *secondary = find_secondary(&buffer, item->secondary);
        if (secondary)
            read_execution(reading, execution->children[child], secondary);
        child++;
    }
    shared_lock_release(&execution->lock);
    leave_call(buffer.call);
}

void input_checks_read(const struct ran_execution *ran, const char *when,
                       struct missed_executions *missed)
{
    if (!when && !ran->is_complete)
        when = "read after the device was lost";
    struct reading reading = {.ran = ran,
                              .when = when,
                              .replay = {.active = ran->device->active_rules,
                                         .resources = ran->device->resources,
                                         .found = keep_finding,
                                         .user = &reading},
                              .findings_last = &reading.findings};
    fenv_t of_application;
    float_environment_enter(&of_application);
    read_execution(&reading, ran->execution, ran->journal);
    while (reading.open_calls) {
        struct read_call *call = reading.open_calls;
        reading.open_calls = call->next;
        end_call(call);
    }
    float_environment_leave(&of_application);
    report_findings(&reading);
    guard_results_end(&reading.guarded, ran->device);
    missed->device_lost += reading.lacks_marks;
    if (reading.lacks_copies && !when)
        warn_lack_of_copies(ran->device);
    missed->no_memory += reading.lacks_memory;
    if (!when)
        comparer_run(ran->device->comparer, ran->queue);
}
