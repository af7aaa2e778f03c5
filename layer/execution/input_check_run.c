/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the copies of an execution, build by build, and reports the findings. */
#include "layer/execution/input_checks.h"

#include <stdlib.h>

#include "layer/consumers.h"
#include "layer/execution/build_records.h"
#include "layer/hazards/executed/checks.h"
#include "layer/physical_device.h"
#include "layer/snapshots/executions.h"
#include "layer/snapshots/guard/execution.h"
#include "layer/snapshots/marks.h"
#include "layer/snapshots/size_queries.h"
#include "src/base/float_environment.h"
#include "src/check/content/executed.h"
#include "src/check/replay/entry_rules.h"
#include "src/platform/threads.h"
#include "src/rules/predicates.h"
#include "src/state/resources/destroyed.h"

/* A finding to be reported later, because the execution is locked while its snapshots are read. */
struct pending_finding {
    struct pending_finding *next;
    const struct journal *journal;
    uint32_t first;  /* position of the call's first build in the command buffer */
    uint32_t origin; /* see journal_note_origin() */
    enum rule rule;
    struct location location;
    struct finding finding;
};

/* One build call of a command buffer, or a deserialization. Some are ended after all locks are
 * released, because their checks look beyond one build, and call down. */
struct read_call {
    struct read_call *next;
    struct reading *reading;
    const struct journal *journal;
    uint32_t first;
    enum build_command command;
    bool geometry_by_pointer;       /* of the current build */
    VkAccelerationStructureKHR dst; /* of the current build */
    struct check_context context;
    struct executed_call *executed;
};

struct reading {
    const struct ran_execution *ran;
    struct replay replay;
    uint32_t next_note, next_used, next_point, next_place; /* of ran->notes */
    struct read_call *open_calls;
    struct pending_finding *findings, **findings_last;
    struct guard_results guarded;
    bool has_addresses;       /* of all structures, see query_addresses() */
    bool notes_are_of_others; /* the notes are not those of the entries */
    bool lacks_memory;        /* some inputs could not be validated */
    const char *when;         /* see input_checks_read() */
    bool lacks_marks;         /* the device may not have copied the inputs of some builds */
    bool lacks_copies;        /* the device has not executed some copies */
};

/* ---- findings */

/* For struct replay, too. */
static bool keep_finding(void *user, const struct journal *journal, uint32_t first_build,
                         uint32_t origin, enum rule rule, const struct location *location,
                         const struct finding *finding)
{
    struct reading *reading = user;
    struct recording *recording = journal->work;
    atomic_store(&recording->has_findings, true);
    const struct reporter *reporter = reading->ran->device->instance->reporter;
    struct pending_finding *pending = malloc(sizeof(*pending));
    reading->lacks_memory |= !pending;
    if (pending) {
        *pending =
            (struct pending_finding){NULL, journal, first_build, origin, rule, *location, *finding};
        *reading->findings_last = pending;
        reading->findings_last = &pending->next;
    }
    return reporter_wants(reporter, rule_infos[rule].vuid[location->command]);
}

/* Commands that build no structures have no position among the builds. */
static uint32_t origin_of(const struct read_call *call, uint32_t build)
{
    return call->first == POSITION_OF_OTHERS
               ? 0
               : journal_origin_at(call->journal, call->first + build);
}

static bool note_found(void *user, enum rule rule, const struct location *location,
                       const struct finding *finding)
{
    const struct read_call *call = user;
    struct location there = *location;
    there.geometry_by_pointer = call->geometry_by_pointer;
    return keep_finding(call->reading, call->journal, call->first, origin_of(call, location->build),
                        rule, &there, finding);
}

static void report_findings(struct reading *reading)
{
    const struct layer_device *device = reading->ran->device;
    while (reading->findings) {
        struct pending_finding *pending = reading->findings;
        uint32_t position = pending->first + pending->location.build;
        struct call_origin origin =
            layer_origin_of(device, &reading->ran->batch->origin, pending->journal, pending->first,
                            pending->origin);
        origin.replaced =
            guard_results_explain(&reading->guarded, pending->journal, position, pending->rule);
        origin.when = reading->when;
        origin.submissions = reading->ran->execution->submissions;
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

static void on_reference(void *user, uint32_t position, const struct accel_facts *referenced)
{
    const struct read_call *call = user;
    const struct ran_execution *ran = call->reading->ran;
    hazard_checks_add_reference(ran->device->hazard_checks, ran->batch, call->journal, position,
                                referenced);
}

static void on_instances(void *user, uint32_t position, const struct instance_uses *uses)
{
    const struct read_call *call = user;
    const struct ran_execution *ran = call->reading->ran;
    const struct recorded_instances recorded = {ran->device, ran->batch,
                                                call->journal->command_buffer, position, call->dst};
    if (ran->device->records_builds)
        build_records_add_instances(&recorded, uses);
}

static void on_index_range(void *user, uint32_t build, uint32_t geometry, uint32_t smallest,
                           uint32_t largest)
{
    const struct read_call *call = user;
    const struct ran_execution *ran = call->reading->ran;
    const struct hazard_input indices = {
        .place = {call->journal, call->first + build, INPUT_INDICES, geometry},
        .smallest = smallest,
        .largest = largest,
    };
    hazard_checks_add_input(ran->device->hazard_checks, ran->batch, &indices);
}

/* Data in memory that only commands write which are known, and only as part of buffers. */
static void on_read(void *user, uint32_t build, uint32_t geometry, const struct elements_read *read)
{
    const struct read_call *call = user;
    const struct ran_execution *ran = call->reading->ran;
    struct resources *resources = ran->device->resources;
    const uint64_t end = (read->count - 1) * read->stride + read->size;
    struct address_facts facts;
    resources_look_up_address(resources, read->address, &facts);
    const struct memory_facts memory = resources_find_memory(resources, facts.memory);
    const uint64_t id = resources_find_memory_id(resources, facts.memory);
    if (facts.status != ADDRESS_IN_BUFFER || end > facts.bytes_left || facts.is_sparse || !id ||
        memory.is_shared || ran->device->facts.newer_than_registry)
        return;
    const struct hazard_input input = {
        .place = {call->journal, call->first + build, INPUT_DATA, geometry},
        .data = {{id, facts.begin, facts.begin + end}, read->stride, read->size, read->hash},
    };
    hazard_checks_add_input(ran->device->hazard_checks, ran->batch, &input);
}

/* Finds bytes behind an address, and their VkBuffer. */
static bool find_bytes_of(const struct layer_device *device, VkDeviceAddress address, uint64_t size,
                          struct hazard_input *input)
{
    struct address_facts facts;
    resources_look_up_address(device->resources, address, &facts);
    input->structure = handle_number(facts.buffer);
    input->bytes = (struct hazard_bytes){resources_find_memory_id(device->resources, facts.memory),
                                         facts.begin, facts.begin + size};
    return facts.status == ADDRESS_IN_BUFFER && size <= facts.bytes_left && !facts.is_sparse &&
           input->bytes.memory;
}

/* The first byte is certain. */
static void on_placed_reference(void *user, uint32_t build, VkDeviceAddress reference)
{
    const struct read_call *call = user;
    const struct ran_execution *ran = call->reading->ran;
    struct hazard_input input = {
        .place = {.journal = call->journal, .position = call->first + build},
        .is_placed = true,
        .access = ACCESS_BUILD_ACCEL_READ,
        .role = HAZARD_REFERENCE};
    if (call->command != COMMAND_NV && find_bytes_of(ran->device, reference, 1, &input))
        hazard_checks_add_input(ran->device->hazard_checks, ran->batch, &input);
}

/* Adds the first and the last one of elements that are apart, as hazards_add_elements() does. */
static void on_access(void *user, uint32_t number, bool is_partitioned,
                      const struct addressed_range *range)
{
    const struct read_call *call = user;
    const struct ran_execution *ran = call->reading->ran;
    const struct addressed_access access = hazard_access_of(is_partitioned, range);
    const uint64_t size = input_extent(0, range->count - 1, range->stride, range->size);
    struct hazard_input input = {.place = {call->journal, number, INPUT_ACCESS, 0},
                                 .is_placed = true,
                                 .access = access.kind,
                                 .role = access.role};
    if (!access.is_certain || !find_bytes_of(ran->device, range->address, size, &input))
        return;
    if (range->stride > range->size && range->count > 1) {
        struct hazard_input first = input;
        first.bytes.end = first.bytes.begin + range->size;
        hazard_checks_add_input(ran->device->hazard_checks, ran->batch, &first);
        input.bytes.begin = input.bytes.end - range->size;
    }
    hazard_checks_add_input(ran->device->hazard_checks, ran->batch, &input);
}

/* The finding is about the destruction, in which the build had a part. */
static void refers_to_destroyed(void *user, uint32_t build, uint32_t instance, uint64_t reference)
{
    const struct read_call *call = user;
    const struct execution *execution = call->reading->ran->execution;
    const struct layer_device *device = call->reading->ran->device;
    const enum build_command destroys = COMMAND_DestroyAccelerationStructureKHR;
    const uint64_t last = atomic_load(&call->reading->ran->batch->last_destroyed);
    struct destroyed_object object;
    struct finding finding;
    if (!last || call->command == COMMAND_NV ||
        !device->active_rules[destroys][RULE_destroyed_object_is_not_in_use] ||
        !resources_reference_is_destroyed(device->resources, reference, execution->destroy_count) ||
        !destroyed_objects_report(device->destroyed, reference, execution->submissions, last,
                                  &object))
        return;
    const struct pending_instance refers = {call->command, instance, reference};
    const struct destroyed_view view = {
        .object = {.object_type = object.type, .handle = object.handle, .id = object.id},
        .instance = &refers};
    const struct location location = {
        .command = destroys, .subject = SUBJECT_ARGUMENT, .build = build};
    if (!destroyed_object_is_not_in_use(&view, &finding))
        keep_finding(call->reading, call->journal, call->first, origin_of(call, build),
                     RULE_destroyed_object_is_not_in_use, &location, &finding);
}

static enum tristate is_compatible(void *user, bool is_micromap,
                                   const uint8_t version[2 * VK_UUID_SIZE])
{
    const struct read_call *call = user;
    return layer_find_compatibility(call->reading->ran->device, is_micromap, version);
}

static void on_all_references(void *user, const struct instance_uses *uses)
{
    const struct read_call *call = user;
    consumers_on_all_references(call->reading->ran->device, call->command, uses);
}

#define HOOKS                                                                                      \
    .found = note_found, .find_sizes = find_sizes, .query_addresses = query_addresses,             \
    .of_another_device = of_another_device, .refers_to_destroyed = refers_to_destroyed,            \
    .is_compatible = is_compatible, .on_instances = on_instances,                                  \
    .on_all_references = on_all_references

static const struct check_hooks hooks = {HOOKS};
#define HAZARD_HOOKS                                                                               \
    HOOKS, .on_reference = on_reference, .on_index_range = on_index_range, .on_access = on_access, \
           .on_placed_reference = on_placed_reference
static const struct check_hooks hazard_hooks = {HAZARD_HOOKS};
static const struct check_hooks write_hooks = {HAZARD_HOOKS, .on_read = on_read};

/* What builds read is compared for writes of shaders alone. */
static const struct check_hooks *hooks_of(const struct layer_device *device)
{
    if (!device->hazard_checks)
        return &hooks;
    return atomic_load(&device->shaders_write) ? &write_hooks : &hazard_hooks;
}

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
        .hooks = hooks_of(device),
        .user = call,
        .level = device->level,
        .active = device->active_rules[place->command],
        .resources = device->resources,
        .destroy_count = reading->ran->execution->destroy_count,
        .places = device->places,
        .structures = device->structures,
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
    if (!executed_call_ends_unlocked(call->executed)) {
        end_call(call);
        return;
    }
    call->next = call->reading->open_calls;
    call->reading->open_calls = call;
}

/* ---- builds */

/* One command buffer. */
struct read_buffer {
    struct reading *reading;
    struct execution *execution;
    bool is_known; /* its copies can be read */
    const struct journal *journal;
    uint32_t used_count; /* micromaps that the next build uses */
    uint64_t place;      /* of the next build at addresses: see places_execute() */
    uint32_t places;     /* builds at addresses that were passed */
    uint32_t child;      /* index of the next execution of a secondary */
    struct read_call *call;
};

/* What the replay noted of one build; the pointers may be NULL. */
struct found_notes {
    const struct input_note *inputs;
    const struct execution_point *point;
    const struct used_micromap_note *used;
    uint32_t used_count;
};

/* Takes the next notes. The replay visited the same entries in the same order, and each entry has
 * the same notes in each execution, so none is searched for. An application that records further
 * after a submission breaks that: then no more notes are taken. */
static struct found_notes take_notes(struct read_buffer *buffer, const struct journal_entry *entry)
{
    struct reading *reading = buffer->reading;
    const struct input_notes *notes = &reading->ran->notes;
    struct found_notes found = {.used_count = buffer->used_count};
    bool has_inputs = entry->built.shapes && notes->count;
    bool has_point =
        entry->built.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR && notes->point_count;
    buffer->used_count = 0;
    if (unknown_is_set(&notes->unknown) || reading->notes_are_of_others)
        return (struct found_notes){0};
    reading->notes_are_of_others =
        (has_inputs &&
         (reading->next_note >= notes->count || notes->items[reading->next_note].entry != entry)) ||
        (has_point && reading->next_point >= notes->point_count) ||
        found.used_count > notes->used_count - reading->next_used;
    if (reading->notes_are_of_others)
        return (struct found_notes){0};
    if (has_inputs)
        found.inputs = &notes->items[reading->next_note++];
    if (has_point)
        found.point = &notes->points[reading->next_point++];
    if (found.used_count)
        found.used = &notes->used[reading->next_used];
    reading->next_used += found.used_count;
    return found;
}

/* `dst_id` of an entry without a known structure is 0. */
static void read_copies(struct read_buffer *buffer, const struct journal_entry *entry,
                        const struct found_notes *notes)
{
    struct recorded_build *build = journal_copies(entry);
    const struct journal_entry *known = entry->dst_id ? entry : NULL;
    const struct input_note *note = notes->inputs;
    struct reading *reading = buffer->reading;
    struct pending_finding **const before = reading->findings_last;
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
        .dst_id = entry->dst_id,
        .memory = snapshot_memory_of(&memory),
        .inputs = note ? note->inputs : NULL,
        .source_inputs = note ? note->source.inputs : NULL,
        .point = notes->point,
        .used = notes->used,
        .used_count = notes->used_count,
        .place = buffer->place,
        .number = buffer->places - 1,
    };
    buffer->call->geometry_by_pointer = build->place.geometry_by_pointer;
    buffer->call->dst = recorded_build_given(build)->info.dstAccelerationStructure;
    const struct executed_input input = {
        .journal = buffer->execution->recording->journal,
        .entry = known,
        .build = build,
        .memory = &executed.memory,
        .point = notes->point,
        .destroy_count = buffer->execution->destroy_count,
        .batch = reading->ran->batch,
        .command = reading->ran->command,
        .is_in_order = !reading->when,
    };
    executed.readers = consumers_on_build(reading->ran->device, &input);
    executed_call_read(buffer->call->executed, &executed);
    consumers_end_readers(executed.readers);
    guard_results_add(&reading->guarded, buffer->journal, build, buffer->execution->bases);
    if (!reading->when)
        consumers_keep(reading->ran->device, &input);
    snapshot_memory_close(&memory);
    if (note)
        replay_judge_inputs(&reading->replay, note);
    if (reading->findings_last != before)
        atomic_store(&build->has_findings, true);
}

/* Whether this thread is to validate the build now. The device executes the calls of a command
 * buffer in order, so one number says which builds were validated before completion. After the
 * device was lost, several threads may read the same execution: one of them validates a build. */
static bool is_of_this_thread(struct read_buffer *buffer, const struct recorded_build *build)
{
    struct execution *execution = buffer->execution;
    const uint32_t position = build->place.position;
    if (position == POSITION_OF_OTHERS)
        return !buffer->reading->when;
    unsigned judged_end = atomic_load(&execution->judged_end);
    if (position < judged_end)
        return false;
    if (!buffer->reading->when)
        return true;
    if (recording_mark_state(execution->recording, build->mark, execution->ticket->number) <
        MARK_HAS_COPIES) {
        buffer->reading->lacks_marks = true;
        return false;
    }
    return atomic_compare_exchange_strong(&execution->judged_end, &judged_end, position + 1);
}

/* `notes` are taken for each build, also for one that is not read. */
static void read_entry(struct read_buffer *buffer, const struct journal_entry *entry,
                       const struct found_notes *notes)
{
    const struct recorded_build *build = journal_copies(entry);
    if (!build)
        return;
    if (build->begins_call) {
        leave_call(buffer->call);
        buffer->call = NULL;
    }
    if (!buffer->is_known || !is_of_this_thread(buffer, build))
        return;
    if (!buffer->call)
        buffer->call = begin_call(buffer->reading, buffer->journal, &build->place);
    if (buffer->call)
        read_copies(buffer, entry, notes);
    else
        buffer->reading->lacks_memory = true;
}

/* ---- command buffers */

static void read_execution(struct reading *reading, struct execution *execution);

static void count_micromap(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct read_buffer *buffer = walk->user;
    buffer->used_count += !entry->micromap.is_ext;
}

static void read_place(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct read_buffer *buffer = walk->user;
    struct reading *reading = buffer->reading;
    const struct input_notes *notes = &reading->ran->notes;
    (void)entry;
    buffer->places++;
    buffer->place = reading->next_place < notes->place_count ? notes->places[reading->next_place++]
                                                             : PLACE_UNNUMBERED;
}

static void read_child(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct read_buffer *buffer = walk->user;
    struct execution *child = buffer->execution->children[buffer->child++];
    (void)entry;
    if (child)
        read_execution(buffer->reading, child);
}

static void read_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct found_notes notes = take_notes(walk->user, entry);
    read_entry(walk->user, entry, &notes);
}

static void read_unknown_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    read_entry(walk->user, entry, &(struct found_notes){0});
}

static void read_execution(struct reading *reading, struct execution *execution)
{
    static const struct journal_events reads_builds = {.use_micromap = count_micromap,
                                                       .execute = read_child,
                                                       ON_BUILDS(read_build),
                                                       .place = read_place,
                                                       .inputs = read_unknown_build};
    struct read_buffer buffer = {
        .reading = reading, .execution = execution, .journal = execution->recording->journal};
    shared_lock_read(&execution->lock);
    buffer.is_known = !execution->has_no_snapshots && !atomic_load(&execution->is_overwritten);
    execution_walk(execution, &reads_builds, &buffer);
    shared_lock_release(&execution->lock);
    leave_call(buffer.call);
}

/* ---- compacting copies */

/* Called without locks: it calls down. */
static void read_sizes(struct reading *reading)
{
    const struct ran_execution *ran = reading->ran;
    for (uint32_t i = 0; i < ran->notes.copy_count && !reading->when; i++) {
        const struct input_note *note = &ran->notes.copies[i];
        compacted_size_update(
            note->source.compacted_size,
            size_query_read(ran->device, note->journal, note->entry, ran->execution->ticket));
        judge_copy_size(&reading->replay, note->journal, note->entry, &note->source);
    }
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
    read_execution(&reading, ran->execution);
    while (reading.open_calls) {
        struct read_call *call = reading.open_calls;
        reading.open_calls = call->next;
        end_call(call);
    }
    float_environment_leave(&of_application);
    read_sizes(&reading);
    report_findings(&reading);
    consumers_report(ran->device, when ? NULL : ran->batch, ran->command);
    guard_results_end(&reading.guarded, ran->device);
    missed->device_lost += reading.lacks_marks;
    if (reading.lacks_copies && !when)
        warn_lack_of_copies(ran->device);
    missed->no_memory += reading.lacks_memory;
    if (!when)
        consumers_run(ran->device);
}
