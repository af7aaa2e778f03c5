/* SPDX-License-Identifier: Apache-2.0 */
/* Keeps what instances and indices say, and finds accesses again. */
#include "layer/hazards/executed/batches.h"

#include <stdlib.h>

#include "layer/layer.h"
#include "src/base/array.h"
#include "src/state/builds/structures.h"

/* ---- creation */

static bool awaits_inputs(const struct order_batch *batch)
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
    record->awaits_inputs = awaits_inputs(batch);
    return record;
}

void hazard_batch_free(struct hazard_batch_record *batch)
{
    free(batch->inputs);
    free(batch->commands);
    free(batch);
}

/* ---- references, indices and data */

void hazard_batch_add(struct hazard_batch_record *batch, const struct hazard_input *input)
{
    if (ARRAY_HAS_ROOM(batch->inputs, batch->input_count, batch->input_capacity))
        batch->inputs[batch->input_count++] = *input;
    else
        unknown_set(&batch->inputs_unknown, UNKNOWN_HAZARDS);
}

/* The references of a command's builds follow each other. Inputs begin with their place. */
static int compare_places(const void *left, const void *right)
{
    const struct hazard_place *a = left, *b = right;
    if (a->journal != b->journal)
        return (uintptr_t)a->journal < (uintptr_t)b->journal ? -1 : 1;
    if (a->kind != b->kind)
        return a->kind < b->kind ? -1 : 1;
    if (a->position != b->position)
        return a->position < b->position ? -1 : 1;
    return (a->geometry > b->geometry) - (a->geometry < b->geometry);
}

void hazard_batch_sort(struct hazard_batch_record *batch)
{
    if (batch->input_count)
        qsort(batch->inputs, batch->input_count, sizeof(batch->inputs[0]), compare_places);
}

/* Returns the index of the first input at or behind the place. */
static uint32_t find_place(const struct hazard_batch_record *batch,
                           const struct hazard_place *place)
{
    uint32_t low = 0, high = batch->input_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (compare_places(place, &batch->inputs[middle]) > 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

const struct hazard_input *hazard_batch_references(const struct hazard_batch_record *batch,
                                                   const struct hazard_command *command,
                                                   uint32_t *count)
{
    const struct hazard_entry *item = command->item;
    *count = 0;
    if (!(item->reads_references || item->has_accesses) || !batch->input_count)
        return NULL;
    struct hazard_place place = {.journal = command->journal,
                                 .kind = item->has_accesses ? INPUT_ACCESS : INPUT_REFERENCE,
                                 .position = item->first_build};
    uint32_t first = find_place(batch, &place);
    place.position += item->has_accesses ? 1 : item->build_count;
    *count = find_place(batch, &place) - first;
    return &batch->inputs[first];
}

/* Returns NULL if the input is unknown, or if the build has executed twice. */
static const struct hazard_input *find_input(const struct hazard_batch_record *batch,
                                             const struct hazard_place *place)
{
    const struct hazard_input *all = batch->inputs;
    const uint32_t at = find_place(batch, place);
    if (at == batch->input_count || compare_places(place, &all[at]) ||
        (at + 1 < batch->input_count && !compare_places(place, &all[at + 1])))
        return NULL;
    return &all[at];
}

static struct hazard_place place_of(const struct hazard_command *command,
                                    const struct hazard_entry *item, enum hazard_input_kind kind)
{
    return (struct hazard_place){command->journal, command->item->first_build + item->info, kind,
                                 item->geometry & ((UINT32_C(1) << 29) - 1)};
}

/* ---- copies */

/* Returns where hazard_batch_copied() finds the copy that writes a structure. */
static struct hazard_place place_of_copy(const struct journal *journal, uint64_t structure)
{
    return (struct hazard_place){journal, (uint32_t)(structure ^ structure >> 32), COPIED_BYTES, 0};
}

struct copy_search {
    struct hazard_batch_record *batch;
    const struct structures *structures;
};

/* Src and dst share what the host has read of a build's sizes, unless one of them was written again
 * in this batch. No structure is smaller than its compacted size. */
static void add_copy(struct journal_walk *walk, const struct journal_entry *copy)
{
    const struct copy_search *search = walk->user;
    const struct structure *src = structures_find(search->structures, copy->src_id);
    const struct structure *dst = structures_find(search->structures, copy->dst_id);
    const struct compacted_size *sizes = src && dst ? dst->built.compacted_size : NULL;
    if (!sizes || src->built.compacted_size != sizes || dst->built.state != BUILT_BEFORE)
        return;
    hazard_batch_add(search->batch, &(struct hazard_input){
                                        .place = place_of_copy(walk->journal, copy->dst),
                                        .structure = copy->dst,
                                        .bytes.end = smaller_of(sizes->size, copy->read.dst_size)});
}

void hazard_batch_add_copies(struct hazard_batch_record *batch, const struct structures *structures)
{
    static const struct journal_events copies = {.copy = add_copy,
                                                 .execute = journal_walk_secondary};
    struct copy_search search = {batch, structures};
    for (uint32_t i = 0; i < batch->batch->command_count; i++) {
        const struct journal *journal = batch->batch->commands[i].captured;
        if (journal && journal->has_copies)
            journal_walk(journal, &copies, &search);
    }
}

struct hazard_bytes hazard_batch_copied(const struct hazard_batch_record *batch,
                                        const struct journal *journal, uint64_t structure,
                                        const struct hazard_bytes *first)
{
    const struct hazard_place place = place_of_copy(journal, structure);
    const struct hazard_input *copied = batch->input_count ? find_input(batch, &place) : NULL;
    struct hazard_bytes bytes = *first;
    if (copied && copied->structure == structure && copied->bytes.end)
        bytes.end = bytes.begin + copied->bytes.end;
    return bytes;
}

/* ---- data and indices */

const struct data_read *hazard_batch_data(const struct hazard_batch_record *batch,
                                          const struct hazard_command *command,
                                          const struct hazard_entry *item)
{
    const struct hazard_place place = place_of(command, item, INPUT_DATA);
    const struct hazard_input *input = find_input(batch, &place);
    return input ? &input->data : NULL;
}

static struct hazard_bytes bytes_of_vertex(const struct hazard_entry *item, uint32_t index)
{
    const uint64_t begin = item->bytes.begin + (uint64_t)index * item->vertex_stride;
    const uint64_t end = begin + item->vertex_size;
    const bool is_inside = begin >= item->bytes.begin && end <= item->bytes.end;
    return is_inside ? (struct hazard_bytes){item->bytes.memory, begin, end}
                     : (struct hazard_bytes){0};
}

void hazard_batch_vertices(const struct hazard_batch_record *batch,
                           const struct hazard_command *command, const struct hazard_entry *item,
                           struct hazard_bytes vertices[HAZARD_INDEXED_READS])
{
    const struct hazard_place place = place_of(command, item, INPUT_INDICES);
    const struct hazard_input *indices = find_input(batch, &place);
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
    if (!ARRAY_HAS_ROOM(batch->commands, batch->command_count, batch->command_capacity))
        return false;
    batch->commands[batch->command_count++] = *command;
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

/* Fills the members that all accesses of a command share. */
static void begin_side(const struct layer_device *device, const struct hazard_batch_record *batch,
                       const struct hazard_command *command, uint32_t build,
                       struct hazard_access_text *side)
{
    *side = (struct hazard_access_text){
        .command = command->item->command,
        .is_build = command->item->build_count != 0,
        .info = build,
        .origin = layer_origin_of(device, &batch->batch->origin, command->journal,
                                  command->item->build_count ? command->item->first_build : 0,
                                  command->item->origin),
    };
}

static void describe_reference(const struct layer_device *device,
                               const struct hazard_batch_record *batch,
                               const struct hazard_command *command,
                               const struct hazard_input *reference,
                               struct hazard_access_text *side)
{
    begin_side(device, batch, command, reference->place.position - command->item->first_build,
               side);
    side->role = reference->is_placed ? reference->role : HAZARD_REFERENCE;
    side->kind = reference->is_placed ? reference->access : ACCESS_BUILD_ACCEL_READ;
    side->type =
        reference->is_placed ? VK_OBJECT_TYPE_BUFFER : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    side->object = reference->structure;
}

struct access_search {
    uint64_t left; /* accesses before the one that is searched */
    const struct hazard_entry *found;
};

static void pass_access(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct access_search *search = walk->user;
    const uint64_t count = journal_is_hazard_indexed(item) ? HAZARD_INDEXED_READS : 1;
    walk->is_over = search->left < count;
    if (walk->is_over)
        search->found = item;
    else
        search->left -= count;
}

static void end_search(struct journal_walk *walk, const struct hazard_entry *item)
{
    (void)item;
    walk->is_over = true;
}

bool hazard_batch_find(const struct layer_device *device, const struct hazard_batch_record *batch,
                       uint64_t number, struct hazard_access_text *side)
{
    static const struct journal_events passes = {
        .hazard_access = pass_access, .hazard_indexed = pass_access, .hazard_command = end_search};
    const struct hazard_command *command = find_command(batch, number);
    if (!command)
        return false;
    struct access_search search = {.left = number - command->first};
    struct journal_walk walk = journal_start(command->journal, &passes, &search);
    walk.place = command->place;
    journal_go_on(&walk);
    if (search.found) {
        const struct hazard_entry *item = search.found;
        begin_side(device, batch, command, item->info, side);
        side->role = (enum hazard_role)item->role;
        side->kind = (enum access_kind)item->access;
        side->geometry = item->geometry;
        side->type = item->object_type;
        side->object = item->object;
        return true;
    }
    uint32_t count;
    const struct hazard_input *references = hazard_batch_references(batch, command, &count);
    if (search.left >= count)
        return false;
    describe_reference(device, batch, command, &references[search.left], side);
    return true;
}
