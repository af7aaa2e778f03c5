/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that trace rays: what they read is compared with builds, and must not be destroyed. */
#include "layer/hazards/executed/traces.h"

#include <string.h>

#include "layer/consumers.h"
#include "layer/hazards/executed/overwritten.h"

/* ---- reports */

/* Reports that something was destroyed which an access of that number reads, or whose descriptor it
 * uses (`is_used`). */
static void report_destroyed(const struct hazard_search *search, const struct top_level *top,
                             uint64_t number, const struct destroyed_structure *destroyed,
                             bool is_pending, bool is_used)
{
    struct hazard_report report = {
        .hazard = {.type = TRACE_OF_DESTROYED, .is_racing = is_pending},
        .earlier = {.type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                    .object = destroyed->structure},
        .destroyed_name = destroyed->name,
        .is_freed = destroyed->is_freed,
        .write = ACCESS_KINDS,
        .is_used = is_used,
    };
    if (unknown_is_set(&search->unknown) ||
        !reporter_wants_hazard(search->device->instance->reporter, HAZARD_ID_TRACE_DESTROYED) ||
        !hazard_search_find_side(search, number, &report.later))
        return;
    report.earlier.origin = report.later.origin;
    report.later.type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    report.later.object = destroyed->structure == top->structure ? 0 : top->structure;
    reporter_send_hazard(search->device->instance->reporter, &report);
}

static void report_unbuilt(const struct hazard_search *search, uint64_t structure, uint64_t number)
{
    struct hazard_report report = {.hazard = {.type = TRACE_OF_UNBUILT}, .write = ACCESS_KINDS};
    if (unknown_is_set(&search->unknown) ||
        !reporter_wants_hazard(search->device->instance->reporter, HAZARD_ID_TRACE_UNBUILT) ||
        !hazard_search_find_side(search, number, &report.later))
        return;
    report.later.type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    report.later.object = structure;
    reporter_send_hazard(search->device->instance->reporter, &report);
}

/* ---- what is built and traced */

void hazard_search_note_top(struct hazard_search *search, const struct hazard_command *command,
                            const struct hazard_entry *item)
{
    struct top_level top = {.structure = item->object,
                            .first = item->bytes,
                            .is_built = command->item && command->item->build_count,
                            .command = command->first,
                            .batch = search->current->batch->timestamp};
    if (top.is_built)
        top.position = command->item->first_build + item->info;
    top.first.end = top.first.begin + 1;
    if (item->object_type != VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR)
        top.first.memory = 0;
    trace_search_add_top(&search->shaders, &top);
}

void hazard_search_note_bottom_write(struct hazard_search *search,
                                     const struct hazard_access *write, uint64_t structure,
                                     uint64_t number)
{
    for (uint32_t i = 0; i < search->shaders.top_count; i++) {
        struct top_level *top = search->shaders.tops[i];
        if ((top->changed && !top->trace.side.number) || !top_level_refers(top, structure))
            continue;
        top->changed = structure;
        if (top->trace.side.number)
            hazards_write_after(search->hazards, &top->trace.side, number, write);
    }
}

static void note_trace(const struct hazard_search *search, struct top_level *top,
                       const struct hazard_access *access, uint64_t number)
{
    const struct hazard_batch_record *record = search->current;
    const struct timestamp batch = record->batch->timestamp;
    top->trace = (struct top_trace){{batch.queue, number, access->kind}, batch, record->untracked};
    if (top->destroyed.structure)
        report_destroyed(search, top, number, &top->destroyed, false, false);
    else if (top->changed)
        consumers_on_stale_trace(search->device, top->structure, top->changed);
    top->destroyed.structure = top->changed = 0;
}

/* A trace that is too early is reported, and not compared with what follows. */
void hazard_search_check_trace(struct hazard_search *search, enum access_kind kind)
{
    struct top_level *top = trace_search_only_top(&search->shaders);
    struct hazard_access access = {.kind = kind};
    struct hazard hazard;
    const uint64_t unbuilt = trace_search_unbuilt(&search->shaders);
    const bool is_early = !unbuilt && trace_search_trace(&search->shaders, kind, &hazard);
    if (top && !is_early && !top->is_gone)
        access.bytes = hazard_search_written_bytes(search, top->structure, &top->first);
    hazard.later.number = top ? hazard_search_read_structure(search, &access, top->structure)
                              : hazards_access(search->hazards, &access);
    if (is_early)
        hazard_search_found(search, &hazard);
    if (top)
        note_trace(search, top, &access, hazard.later.number);
    if (unbuilt)
        report_unbuilt(search, unbuilt, hazard.later.number);
}

/* Whether the structure of a handle lies there now. */
static bool is_alive_at(const struct hazard_search *search, uint64_t structure,
                        const struct hazard_bytes *first)
{
    struct accel_facts facts;
    resources_look_up_accel(search->device->resources,
                            (VkAccelerationStructureKHR)(uintptr_t)structure, &facts);
    return facts.alive == YES && facts.memory && facts.begin == first->begin &&
           resources_find_memory_id(search->device->resources, facts.memory) == first->memory;
}

/* The structure may be the one that the trace behind it reads. */
void hazard_search_add_traced(struct hazard_search *search, const struct hazard_entry *item)
{
    hazards_access(search->hazards,
                   &(struct hazard_access){.kind = (enum access_kind)item->access});
    trace_search_add_traced(&search->shaders, item->object, &item->bytes,
                            is_alive_at(search, item->object, &item->bytes));
}

void hazard_search_check_used(struct hazard_search *search, const struct hazard_entry *item)
{
    const struct hazard_access none = {.kind = (enum access_kind)item->access};
    const uint64_t number = hazards_access(search->hazards, &none);
    struct top_level *top = trace_search_find_top_at(&search->shaders, item->object, &item->bytes);
    if (!top || !top->is_gone || top->destroyed.structure != top->structure)
        return;
    report_destroyed(search, top, number, &top->destroyed, false, true);
    top->destroyed.structure = 0;
}

/* ---- what is destroyed */

/* Whether the structure was traced by a command that need not be complete, and was built by one
 * that is. If that is not complete either, the destruction has an error of its own. */
static bool is_trace_pending(const struct top_level *top, const struct ended_object *ended)
{
    return top->trace.side.number && ended->observed_clock_is_known &&
           ended->untracked == top->trace.untracked &&
           execution_clock_has(&ended->observed, top->batch) &&
           !execution_clock_has(&ended->observed, top->trace.batch);
}

/* Finds what the end of an object takes from a structure: itself, or one of its references. */
static bool find_destroyed(struct top_level *top, const struct ended_object *ended,
                           struct destroyed_structure *destroyed)
{
    const bool is_freed = ended->ended == MEMORY_FREED;
    const uint64_t structure = is_freed ? 0 : ended->id, memory = is_freed ? ended->id : 0;
    const bool is_itself = is_freed ? top->first.memory == memory : top->structure == structure;
    *destroyed = (struct destroyed_structure){
        .structure = is_itself ? top->structure : top_level_drop(top, structure, memory),
        .is_freed = is_freed};
    memcpy(destroyed->name, ended->name, sizeof(destroyed->name));
    return destroyed->structure;
}

/* What follows may trace the structures again. */
static void note_destroyed(struct hazard_search *search, struct top_level *top,
                           const struct ended_object *ended,
                           const struct destroyed_structure *destroyed)
{
    const bool is_pending = is_trace_pending(top, ended);
    const bool is_reported = is_pending || !execution_clock_has(&ended->observed, top->batch);
    if (is_pending)
        report_destroyed(search, top, top->trace.side.number, destroyed, true, false);
    if (ended->ended == STRUCTURE_DESTROYED && destroyed->structure == top->structure)
        trace_search_end_top(&search->shaders, top->structure, is_reported ? NULL : destroyed);
    else if (!is_reported)
        top->destroyed = *destroyed;
}

void hazard_search_end_traced(struct hazard_search *search, const struct ended_object *ended)
{
    for (uint32_t i = 0; i < search->shaders.top_count; i++) {
        struct top_level *top = search->shaders.tops[i];
        struct destroyed_structure destroyed;
        if (!top->is_gone && find_destroyed(top, ended, &destroyed))
            note_destroyed(search, top, ended, &destroyed);
    }
}
