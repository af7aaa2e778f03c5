/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/hazards/executed/reports.h"

#include "src/state/order/order.h"

struct order_batch *hazard_judge_next(const struct hazard_judge *judge,
                                      const struct order_batch *after)
{
    if (!judge->judged_count || after == judge->last)
        return NULL;
    pthread_mutex_lock(&judge->batches->lock);
    struct order_batch *batch =
        batch_list_next(judge->batches, IN_EXECUTION_ORDER, after, USES_HAZARDS);
    pthread_mutex_unlock(&judge->batches->lock);
    return batch;
}

/* Commands were numbered in execution order, so the last batch with an early enough one has it. */
bool hazard_judge_find_side(const struct hazard_judge *judge, uint64_t number,
                            struct hazard_access_text *side)
{
    bool found = judge->current && hazard_batch_find(judge->device, judge->current, number, side);
    for (struct order_batch *batch = NULL; !found && (batch = hazard_judge_next(judge, batch));) {
        const struct order_batch *behind = hazard_judge_next(judge, batch);
        const struct hazard_batch_record *record = batch->slots[USES_HAZARDS];
        const struct hazard_batch_record *next = behind ? behind->slots[USES_HAZARDS] : NULL;
        if (record->command_count && record->commands[0].first <= number &&
            (!next || !next->command_count || number < next->commands[0].first))
            found = hazard_batch_find(judge->device, record, number, side);
    }
    return found;
}

/* Names the structure that the access of that number traces, if it is known. */
static void name_traced(const struct hazard_judge *judge, uint64_t number,
                        struct hazard_access_text *side)
{
    for (uint32_t i = 0; i < judge->shaders.top_count; i++)
        if (judge->shaders.tops[i]->trace.side.number == number) {
            side->type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
            side->object = judge->shaders.tops[i]->structure;
        }
}

/* Finds where a live object lies. Returns false if that is unknown, or if no live object has the
 * handle. */
static bool find_bytes(struct resources *resources, const struct hazard_access_text *side,
                       struct memory_bytes *bytes)
{
    struct accel_facts accel;
    if (side->type == VK_OBJECT_TYPE_BUFFER)
        return resources_find_buffer_bytes(resources, (VkBuffer)(uintptr_t)side->object, bytes);
    if (side->type == VK_OBJECT_TYPE_MICROMAP_EXT)
        return resources_find_micromap_bytes(resources, (VkMicromapEXT)(uintptr_t)side->object,
                                             bytes);
    if (side->type != VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR)
        return false;
    resources_look_up_accel(resources, (VkAccelerationStructureKHR)(uintptr_t)side->object, &accel);
    *bytes = (struct memory_bytes){resources_find_memory_id(resources, accel.memory), accel.begin,
                                   accel.size};
    return bytes->memory_id;
}

static enum resource_kind kind_of(VkObjectType type)
{
    return type == VK_OBJECT_TYPE_BUFFER                      ? RESOURCE_BUFFER
           : type == VK_OBJECT_TYPE_MICROMAP_EXT              ? RESOURCE_MICROMAP
           : type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV ? RESOURCE_ACCEL_NV
                                                              : RESOURCE_ACCEL;
}

/* Entries have handles. An object that got the handle later lies elsewhere, in all likelihood. */
static bool is_destroyed(const struct hazard_judge *judge, const struct hazard *hazard,
                         const struct hazard_access_text *side)
{
    struct resources *resources = judge->device->resources;
    const struct hazard_bytes *touched = &hazard->bytes;
    struct memory_bytes bytes;
    if (!side->object)
        return false;
    if (!resources_find_id(resources, kind_of(side->type), side->object))
        return true;
    return touched->memory && find_bytes(resources, side, &bytes) &&
           (bytes.memory_id != touched->memory || bytes.begin >= touched->end ||
            touched->begin >= bytes.begin + bytes.size);
}

static bool has_number(const struct hazard_batch_record *record, uint64_t number)
{
    return record->command_count && record->commands[0].first <= number;
}

const struct order_batch *hazard_judge_find_batch(const struct hazard_judge *judge, uint64_t number)
{
    const struct order_batch *found = NULL;
    if (has_number(judge->current, number))
        return judge->current->batch;
    for (struct order_batch *batch = NULL; (batch = hazard_judge_next(judge, batch));)
        if (has_number(batch->slots[USES_HAZARDS], number))
            found = batch;
    return found;
}

/* Returns the timeout of a wait that returned VK_TIMEOUT between the submissions of both sides. */
static uint64_t find_timeout(const struct hazard_judge *judge, const struct hazard *hazard)
{
    const struct order_batch *earlier = hazard_judge_find_batch(judge, hazard->earlier.number);
    return earlier ? execution_order_find_timeout(judge->device->order, earlier->timed_out_waits,
                                                  judge->current->batch->timed_out_waits)
                   : 0;
}

static void report_kind(const struct hazard_judge *judge, const struct kind_of_hazard *kind)
{
    const struct device_facts *facts = &judge->device->facts;
    struct hazard_report report = {.hazard = kind->first,
                                   .features = {.synchronization2 = facts->synchronization2,
                                                .structures = facts->acceleration_structure,
                                                .structure_copies = facts->ray_tracing_maintenance1,
                                                .micromaps = facts->micromap.ext},
                                   .more = kind->count - 1,
                                   .is_own_write =
                                       kind->first.earlier.number >= judge->command.first,
                                   .write = kind->write};
    report.earlier = kind->earlier;
    if (!hazard_judge_find_side(judge, kind->first.later.number, &report.later) ||
        (!kind->knows_earlier &&
         !hazard_judge_find_side(judge, kind->first.earlier.number, &report.earlier)))
        return;
    if (report.later.role == HAZARD_SHADER && !report.later.object)
        name_traced(judge, kind->first.later.number, &report.later);
    if (kind->first.type == EARLY_TRACE) {
        report.later.type = report.earlier.type;
        report.later.object = report.earlier.object;
    }
    hazard_judge_find_barrier(judge, &kind->first, &report.barrier);
    report.timeout = find_timeout(judge, &kind->first);
    report.later.object_is_destroyed = is_destroyed(judge, &kind->first, &report.later);
    report.earlier.object_is_destroyed = is_destroyed(judge, &kind->first, &report.earlier);
    reporter_send_hazard(judge->device->instance->reporter, &report);
}

void hazard_judge_report(struct hazard_judge *judge)
{
    for (uint32_t i = 0; i < judge->kind_count; i++)
        report_kind(judge, &judge->kinds[i]);
    judge->kind_count = 0;
}

static bool is_same_kind(const struct hazard *a, const struct hazard *b)
{
    return hazard_id_of(a) == hazard_id_of(b) && a->earlier.kind == b->earlier.kind &&
           a->later.kind == b->later.kind;
}

/* An update in place reads and writes a structure, and needs one barrier for both. */
static bool is_write_of_what_is_read(const struct kind_of_hazard *read, const struct hazard *hazard)
{
    return read->first.type == READ_AFTER_WRITE && hazard->type == WRITE_AFTER_WRITE &&
           read->last_earlier == hazard->earlier.number;
}

static bool add_to_kind(struct kind_of_hazard *kind, const struct hazard *hazard)
{
    if (is_write_of_what_is_read(kind, hazard)) {
        kind->write = hazard->later.kind;
        return true;
    }
    if (!is_same_kind(&kind->first, hazard))
        return false;
    kind->count++;
    kind->last_earlier = hazard->earlier.number;
    return true;
}

void hazard_judge_found_after(struct hazard_judge *judge, const struct hazard *hazard,
                              const struct hazard_access_text *earlier)
{
    if (unknown_is_set(&judge->unknown) ||
        !reporter_wants_hazard(judge->device->instance->reporter, hazard_id_of(hazard)))
        return;
    for (uint32_t i = 0; i < judge->kind_count; i++)
        if (add_to_kind(&judge->kinds[i], hazard))
            return;
    if (judge->kind_count == HAZARD_KINDS_REPORTED)
        return;
    struct kind_of_hazard *kind = &judge->kinds[judge->kind_count++];
    *kind = (struct kind_of_hazard){.first = *hazard,
                                    .count = 1,
                                    .last_earlier = hazard->earlier.number,
                                    .write = ACCESS_KINDS,
                                    .knows_earlier = earlier != NULL};
    if (earlier)
        kind->earlier = *earlier;
}

/* The engine's callback. */
void hazard_judge_found(void *user, const struct hazard *hazard)
{
    hazard_judge_found_after(user, hazard, NULL);
}
