/* SPDX-License-Identifier: Apache-2.0 */
/* Keeps what instances and indices say, and finds accesses again. */
#include "layer/execution/hazards/batches.h"

#include <stdlib.h>

#include "src/base/array.h"

/* ---- creation */

static bool has_references(const struct order_batch *batch)
{
    bool has_any = false;
    for (uint32_t i = 0; i < batch->command_count; i++) {
        const struct journal *journal = batch->commands[i].captured;
        has_any |= journal && journal->awaits_inputs;
    }
    return has_any;
}

struct hazard_batch_record *hazard_batch_create(struct order_batch *batch)
{
    struct hazard_batch_record *record = calloc(1, sizeof(*record));
    if (!record)
        return NULL;
    record->batch = batch;
    record->has_references = has_references(batch);
    return record;
}

void hazard_batch_free(struct hazard_batch_record *batch)
{
    free(batch->references);
    free(batch->indices);
    free(batch->commands);
    free(batch);
}

/* ---- references and indices */

void hazard_batch_refer(struct hazard_batch_record *batch, const struct hazard_reference *reference)
{
    struct hazard_reference *references = array_make_room(
        batch->references, batch->reference_count, &batch->reference_capacity, sizeof(*references));
    if (!references) {
        batch->lacks_references = true;
        return;
    }
    batch->references = references;
    references[batch->reference_count++] = *reference;
}

void hazard_batch_index(struct hazard_batch_record *batch, const struct hazard_indices *indices)
{
    struct hazard_indices *all =
        array_make_room(batch->indices, batch->index_count, &batch->index_capacity, sizeof(*all));
    if (!all) {
        batch->lacks_references = true;
        return;
    }
    batch->indices = all;
    all[batch->index_count++] = *indices;
}

/* References and indices begin with their place. */
static int compare_places(const void *left, const void *right)
{
    const struct hazard_place *a = left, *b = right;
    if (a->journal != b->journal)
        return (uintptr_t)a->journal < (uintptr_t)b->journal ? -1 : 1;
    if (a->position != b->position)
        return a->position < b->position ? -1 : 1;
    return (a->geometry > b->geometry) - (a->geometry < b->geometry);
}

void hazard_batch_sort(struct hazard_batch_record *batch)
{
    if (batch->reference_count)
        qsort(batch->references, batch->reference_count, sizeof(batch->references[0]),
              compare_places);
    if (batch->index_count)
        qsort(batch->indices, batch->index_count, sizeof(batch->indices[0]), compare_places);
}

/* Returns the index of the first item at or behind the place. */
static uint32_t find_place(const void *items, uint32_t count, size_t size,
                           const struct hazard_place *place)
{
    uint32_t low = 0, high = count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (compare_places(place, (const char *)items + middle * size) > 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static uint32_t find_references(const struct hazard_batch_record *batch,
                                const struct journal *journal, uint32_t position)
{
    return find_place(batch->references, batch->reference_count, sizeof(batch->references[0]),
                      &(struct hazard_place){journal, position, 0});
}

const struct hazard_reference *hazard_batch_references(const struct hazard_batch_record *batch,
                                                       const struct hazard_command *command,
                                                       uint32_t *count)
{
    const struct hazard_entry *item = command->item;
    *count = 0;
    if (!item->reads_references || !batch->reference_count)
        return NULL;
    uint32_t first = find_references(batch, command->journal, item->geometry);
    *count = find_references(batch, command->journal, item->geometry + item->info) - first;
    return &batch->references[first];
}

/* Returns NULL if the indices are unknown, or if the build has executed twice. */
static const struct hazard_indices *find_indices(const struct hazard_batch_record *batch,
                                                 const struct hazard_place *place)
{
    const struct hazard_indices *all = batch->indices;
    const uint32_t at = find_place(all, batch->index_count, sizeof(*all), place);
    if (at == batch->index_count || compare_places(place, &all[at]) ||
        (at + 1 < batch->index_count && !compare_places(place, &all[at + 1])))
        return NULL;
    return &all[at];
}

static struct hazard_bytes bytes_of_vertex(const struct hazard_entry *item, uint32_t index)
{
    const uint64_t begin = item->bytes.begin + (uint64_t)index * item->count;
    const uint64_t end = begin + item->labels;
    const bool is_inside = begin >= item->bytes.begin && end <= item->bytes.end;
    return is_inside ? (struct hazard_bytes){item->bytes.memory, begin, end}
                     : (struct hazard_bytes){0};
}

void hazard_batch_vertices(const struct hazard_batch_record *batch,
                           const struct hazard_command *command, const struct hazard_entry *item,
                           struct hazard_bytes vertices[HAZARD_INDEXED_READS])
{
    const struct hazard_place place = {command->journal, command->item->geometry + item->info,
                                       item->geometry};
    const struct hazard_indices *indices = find_indices(batch, &place);
    vertices[0] = vertices[1] = (struct hazard_bytes){0};
    if (!indices)
        return;
    vertices[0] = bytes_of_vertex(item, indices->smallest);
    if (indices->largest != indices->smallest)
        vertices[1] = bytes_of_vertex(item, indices->largest);
}

/* ---- finding accesses again */

bool hazard_batch_note(struct hazard_batch_record *batch, const struct hazard_command *command)
{
    struct hazard_command *commands = array_make_room(batch->commands, batch->command_count,
                                                      &batch->command_capacity, sizeof(*commands));
    if (!commands)
        return false;
    batch->commands = commands;
    commands[batch->command_count++] = *command;
    return true;
}

static const struct hazard_command *find_command(const struct hazard_batch_record *batch,
                                                 uint64_t number)
{
    uint32_t low = 0, high = batch->command_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (batch->commands[middle].first <= number)
            low = middle + 1;
        else
            high = middle;
    }
    return low ? &batch->commands[low - 1] : NULL;
}

static struct call_origin origin_of(const struct hazard_batch_record *batch,
                                    const struct hazard_command *command)
{
    const struct journal *journal = command->journal;
    return (struct call_origin){
        .command_buffer = journal->command_buffer,
        .build_index = command->item->geometry,
        .labels = journal_label_stack(journal, command->item->labels),
        .call_site = command->item->info ? command->item->site : NULL,
        .queue = batch->batch->queue,
        .submission = batch->batch->number,
        .queue_labels = shared_labels_stack(batch->batch->labels),
    };
}

/* Fills the members that all accesses of a command share. */
static void begin_side(const struct hazard_batch_record *batch,
                       const struct hazard_command *command, uint32_t build,
                       struct hazard_access_text *side)
{
    *side = (struct hazard_access_text){
        .command = command->item->command,
        .is_build = command->item->info != 0,
        .info = build,
        .origin = origin_of(batch, command),
    };
}

static void describe_reference(const struct hazard_batch_record *batch,
                               const struct hazard_command *command,
                               const struct hazard_reference *reference,
                               struct hazard_access_text *side)
{
    begin_side(batch, command, reference->place.position - command->item->geometry, side);
    side->role = HAZARD_REFERENCE;
    side->kind = ACCESS_BUILD_ACCEL_READ;
    side->type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    side->object = reference->structure;
}

bool hazard_batch_find(const struct hazard_batch_record *batch, uint64_t number,
                       struct hazard_access_text *side)
{
    const struct hazard_command *command = find_command(batch, number);
    if (!command)
        return false;
    uint64_t left = number - command->first;
    struct journal_cursor cursor =
        journal_start_at(command->journal, command->place, JOURNAL_HAZARDS);
    for (const struct hazard_entry *item;
         (item = hazard_next(&cursor)) && hazard_entry_is_access(item);) {
        const uint64_t count = item->kind == HAZARD_INDEXED ? HAZARD_INDEXED_READS : 1;
        if (left >= count) {
            left -= count;
            continue;
        }
        begin_side(batch, command, item->info, side);
        side->role = (enum hazard_role)item->role;
        side->kind = (enum access_kind)item->access;
        side->geometry = item->geometry;
        side->type = item->object_type;
        side->object = item->object;
        return true;
    }
    uint32_t count;
    const struct hazard_reference *references = hazard_batch_references(batch, command, &count);
    if (left >= count)
        return false;
    describe_reference(batch, command, &references[left], side);
    return true;
}
