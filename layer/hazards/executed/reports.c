/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/hazards/executed/reports.h"

#include "src/state/order/order.h"

struct order_batch *hazard_search_next(const struct hazard_search *search,
                                       const struct order_batch *after)
{
    if (!search->judged_count || after == search->last)
        return NULL;
    pthread_mutex_lock(&search->batches->lock);
    struct order_batch *batch =
        batch_list_next(search->batches, IN_EXECUTION_ORDER, after, USES_HAZARDS);
    pthread_mutex_unlock(&search->batches->lock);
    return batch;
}

/* Commands were numbered in execution order, so the last batch with an early enough one has it. */
bool hazard_search_find_side(const struct hazard_search *search, uint64_t number,
                             struct hazard_access_text *side)
{
    bool found =
        search->current && hazard_batch_find(search->device, search->current, number, side);
    for (struct order_batch *batch = NULL; !found && (batch = hazard_search_next(search, batch));) {
        const struct order_batch *behind = hazard_search_next(search, batch);
        const struct hazard_batch_record *record = batch->slots[USES_HAZARDS];
        const struct hazard_batch_record *next = behind ? behind->slots[USES_HAZARDS] : NULL;
        if (record->command_count && record->commands[0].first <= number &&
            (!next || !next->command_count || number < next->commands[0].first))
            found = hazard_batch_find(search->device, record, number, side);
    }
    return found;
}

/* Names the structure that the access of that number traces, if it is known. */
static void name_traced(const struct hazard_search *search, uint64_t number,
                        struct hazard_access_text *side)
{
    for (uint32_t i = 0; i < search->shaders.top_count; i++)
        if (search->shaders.tops[i]->trace.side.number == number) {
            side->type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
            side->object = search->shaders.tops[i]->structure;
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
static bool is_destroyed(const struct hazard_search *search, const struct hazard *hazard,
                         const struct hazard_access_text *side)
{
    struct resources *resources = search->device->resources;
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

const struct order_batch *hazard_search_find_batch(const struct hazard_search *search,
                                                   uint64_t number)
{
    const struct order_batch *found = NULL;
    if (has_number(search->current, number))
        return search->current->batch;
    for (struct order_batch *batch = NULL; (batch = hazard_search_next(search, batch));)
        if (has_number(batch->slots[USES_HAZARDS], number))
            found = batch;
    return found;
}

/* Returns the timeout of a wait that returned VK_TIMEOUT between the submissions of both sides. */
static uint64_t find_timeout(const struct hazard_search *search, const struct hazard *hazard)
{
    const struct order_batch *earlier = hazard_search_find_batch(search, hazard->earlier.number);
    return earlier ? execution_order_find_timeout(search->device->order, earlier->timed_out_waits,
                                                  search->current->batch->timed_out_waits)
                   : 0;
}

static void report_kind(const struct hazard_search *search, const struct kind_of_hazard *kind)
{
    const struct device_facts *facts = &search->device->facts;
    struct hazard_report report = {.hazard = kind->first,
                                   .features = {.synchronization2 = facts->synchronization2,
                                                .structures = facts->acceleration_structure,
                                                .structure_copies = facts->ray_tracing_maintenance1,
                                                .micromaps = facts->micromap.ext},
                                   .more = kind->count - 1,
                                   .is_own_write =
                                       kind->first.earlier.number >= search->command.first,
                                   .write = kind->write};
    report.earlier = kind->earlier;
    if (!hazard_search_find_side(search, kind->first.later.number, &report.later) ||
        (!kind->earlier_is_known &&
         !hazard_search_find_side(search, kind->first.earlier.number, &report.earlier)))
        return;
    if (report.later.role == HAZARD_SHADER && !report.later.object)
        name_traced(search, kind->first.later.number, &report.later);
    if (kind->first.type == EARLY_TRACE) {
        report.later.type = report.earlier.type;
        report.later.object = report.earlier.object;
    }
    hazard_search_find_barrier(search, &kind->first, &report.barrier);
    report.timeout = find_timeout(search, &kind->first);
    report.later.object_is_destroyed = is_destroyed(search, &kind->first, &report.later);
    report.earlier.object_is_destroyed = is_destroyed(search, &kind->first, &report.earlier);
    reporter_send_hazard(search->device->instance->reporter, &report);
}

void hazard_search_report(struct hazard_search *search)
{
    for (uint32_t i = 0; i < search->kind_count; i++)
        report_kind(search, &search->kinds[i]);
    search->kind_count = 0;
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

void hazard_search_found_after(struct hazard_search *search, const struct hazard *hazard,
                               const struct hazard_access_text *earlier)
{
    if (unknown_is_set(&search->unknown) ||
        !reporter_wants_hazard(search->device->instance->reporter, hazard_id_of(hazard)))
        return;
    for (uint32_t i = 0; i < search->kind_count; i++)
        if (add_to_kind(&search->kinds[i], hazard))
            return;
    if (search->kind_count == HAZARD_KINDS_REPORTED)
        return;
    struct kind_of_hazard *kind = &search->kinds[search->kind_count++];
    *kind = (struct kind_of_hazard){.first = *hazard,
                                    .count = 1,
                                    .last_earlier = hazard->earlier.number,
                                    .write = ACCESS_KINDS,
                                    .earlier_is_known = earlier != NULL};
    if (earlier)
        kind->earlier = *earlier;
}

/* The engine's callback. */
void hazard_search_found(void *user, const struct hazard *hazard)
{
    hazard_search_found_after(user, hazard, NULL);
}
