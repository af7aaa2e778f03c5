/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/hazards/executed/shaders.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"

/* Inputs beyond so many are forgotten, all at once. */
enum { INPUTS_KEPT = 1 << 16 };

/* ---- top-level structures */

static void remove_top(struct trace_search *search, struct top_level *top)
{
    search->tops[top->index] = search->tops[--search->top_count];
    search->tops[top->index]->index = top->index;
    search->gone_count -= top->is_gone;
    if (search->last_built == top)
        search->last_built = NULL;
    handle_table_remove(&search->by_handle, top->structure);
    free(top->references);
    free(top);
}

struct top_level *trace_search_find_top(const struct trace_search *search, uint64_t structure)
{
    return handle_table_find(&search->by_handle, structure);
}

/* The oldest one of those that are destroyed is the one that was built first. */
static void remove_oldest_gone(struct trace_search *search)
{
    struct top_level *oldest = NULL;
    for (uint32_t i = 0; i < search->top_count; i++)
        if (search->tops[i]->is_gone && (!oldest || search->tops[i]->command < oldest->command))
            oldest = search->tops[i];
    if (!oldest)
        return;
    reporter_add_unchecked(search->reporter,
                           "destroyed top-level structures beyond those that the layer remembers",
                           1);
    remove_top(search, oldest);
}

/* Returns false if memory runs out. */
static bool keep_top(struct trace_search *search, const struct top_level *top)
{
    struct top_level *kept = malloc(sizeof(*kept));
    if (!kept || !ARRAY_HAS_ROOM(search->tops, search->top_count, search->top_capacity) ||
        !handle_table_set(&search->by_handle, top->structure, kept)) {
        free(kept);
        return false;
    }
    *kept = *top;
    kept->index = search->top_count;
    search->tops[search->top_count++] = kept;
    return true;
}

void trace_search_add_top(struct trace_search *search, const struct top_level *top)
{
    struct top_level *old = trace_search_find_top(search, top->structure);
    if (old)
        remove_top(search, old);
    if (search->gone_count > GONE_KEPT)
        remove_oldest_gone(search);
    if (!top->first.memory || !keep_top(search, top))
        unknown_set(&search->tops_unknown, UNKNOWN_TRACED);
}

void trace_search_end_top(struct trace_search *search, uint64_t structure,
                          const struct destroyed_structure *destroyed)
{
    struct top_level *top = trace_search_find_top(search, structure);
    if (!top)
        return;
    search->gone_count += !top->is_gone;
    top->is_gone = true;
    top->reference_count = 0;
    top->destroyed = destroyed ? *destroyed : (struct destroyed_structure){0};
}

/* References of one build follow each other. */
static struct top_level *find_built(struct trace_search *search, uint64_t command,
                                    uint32_t position)
{
    struct top_level *last = search->last_built;
    if (last && last->command == command && last->position == position)
        return last;
    for (uint32_t i = search->top_count; i-- > 0;)
        if (search->tops[i]->command == command && search->tops[i]->position == position) {
            search->last_built = search->tops[i];
            return search->tops[i];
        }
    return NULL;
}

void trace_search_add_reference(struct trace_search *search, uint64_t command, uint32_t position,
                                const struct top_reference *reference)
{
    struct top_level *top = find_built(search, command, position);
    if (top && ARRAY_HAS_ROOM(top->references, top->reference_count, top->reference_capacity))
        top->references[top->reference_count++] = *reference;
    if (top)
        top->is_sorted = false;
}

static int compare_references(const void *left, const void *right)
{
    const struct top_reference *a = left, *b = right;
    return (a->structure > b->structure) - (a->structure < b->structure);
}

bool top_level_refers(struct top_level *top, uint64_t structure)
{
    const struct top_reference key = {.structure = structure};
    if (!top->reference_count)
        return false;
    if (!top->is_sorted)
        qsort(top->references, top->reference_count, sizeof(key), compare_references);
    top->is_sorted = true;
    return bsearch(&key, top->references, top->reference_count, sizeof(key), compare_references);
}

uint64_t top_level_drop(struct top_level *top, uint64_t structure, uint64_t memory)
{
    uint64_t first = 0;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < top->reference_count; i++) {
        const struct top_reference reference = top->references[i];
        if (reference.structure != structure && reference.memory != memory)
            top->references[kept++] = reference;
        else if (!first)
            first = reference.structure;
    }
    top->reference_count = kept;
    return first;
}

struct top_level *trace_search_find_top_at(const struct trace_search *search, uint64_t structure,
                                           const struct hazard_bytes *first)
{
    struct top_level *top = trace_search_find_top(search, structure);
    const bool is_there = top && (first->memory ? top->first.memory == first->memory &&
                                                      top->first.begin == first->begin
                                                : top->is_gone);
    return is_there ? top : NULL;
}

/* Whether something that is known was written where a structure begins. */
static bool is_place_of_top(const struct trace_search *search, const struct hazard_bytes *first)
{
    for (uint32_t i = 0; i < search->top_count; i++)
        if (search->tops[i]->first.memory == first->memory &&
            search->tops[i]->first.begin == first->begin)
            return true;
    return false;
}

/* A structure that is not among those that were written, alive, and where no other one was written,
 * is one that nothing has built. */
void trace_search_add_traced(struct trace_search *search, uint64_t structure,
                             const struct hazard_bytes *first, bool is_alive)
{
    struct top_level *top = trace_search_find_top_at(search, structure, first);
    const bool is_unbuilt = is_alive && first->memory && !unknown_is_set(&search->tops_unknown) &&
                            !trace_search_find_top(search, structure) &&
                            !is_place_of_top(search, first);
    for (uint32_t i = 0; top && i < search->traced.count; i++)
        if (search->traced.tops[i] == top)
            return;
    if (top && search->traced.count < TRACED_KEPT)
        search->traced.tops[search->traced.count++] = top;
    else if (is_unbuilt && search->traced.unbuilt != structure)
        search->traced.unbuilt_count++;
    else if (!is_unbuilt)
        search->traced.is_unknown = true;
    if (is_unbuilt)
        search->traced.unbuilt = structure;
}

/* Whether it is known from descriptors what the command may trace. */
static bool has_candidates(const struct trace_search *search)
{
    return search->traced.count || search->traced.unbuilt_count || search->traced.is_unknown;
}

struct top_level *trace_search_only_top(struct trace_search *search)
{
    struct top_level *only = search->traced.tops[0];
    uint32_t count = search->traced.count + search->traced.unbuilt_count;
    if (search->traced.is_unknown || (has_candidates(search) && count != 1))
        return NULL;
    if (!has_candidates(search)) {
        if (unknown_is_set(&search->tops_unknown))
            return NULL;
        for (uint32_t i = 0; i < search->top_count; i++)
            if (!search->tops[i]->is_gone) {
                only = search->tops[i];
                count++;
            }
    }
    return count == 1 && only && only->is_built ? only : NULL;
}

uint64_t trace_search_unbuilt(const struct trace_search *search)
{
    const bool is_certain =
        !search->traced.is_unknown && !search->traced.count && search->traced.unbuilt_count == 1;
    return is_certain ? search->traced.unbuilt : 0;
}

bool trace_search_trace(struct trace_search *search, enum access_kind kind, struct hazard *hazard)
{
    const bool has_all = !has_candidates(search);
    const uint32_t count = has_all ? search->top_count : search->traced.count;
    struct top_level *const *tops = has_all ? search->tops : search->traced.tops;
    bool found = false;
    if (search->traced.is_unknown || (has_all && unknown_is_set(&search->tops_unknown)))
        return false;
    for (uint32_t i = 0; i < count; i++) {
        const struct top_level *top = tops[i];
        struct hazard early;
        if (top->is_gone)
            continue;
        if (!hazards_read_is_early(search->hazards, &(struct hazard_access){kind, top->first},
                                   &early))
            return false;
        if (!top->is_built || (found && early.earlier.number < hazard->earlier.number))
            continue;
        found = true;
        *hazard = early;
        hazard->type = EARLY_TRACE;
    }
    return found;
}

void trace_search_overwrite(struct trace_search *search, const struct hazard_access *write,
                            uint64_t structure, uint64_t number)
{
    for (uint32_t i = 0; i < search->top_count; i++) {
        struct top_level *top = search->tops[i];
        if (top->trace.side.number && top_level_refers(top, structure))
            hazards_write_after(search->hazards, &top->trace.side, number, write);
    }
}

/* ---- what builds have read */

struct input_read {
    uint64_t begin, end;
    uint64_t stride, size, hash; /* of the data that the last build read */
    uint64_t first_open;     /* see hazards_first_open_write(), at that build; 0: there was none */
    struct hazard_side side; /* the read of that build */
};

/* What builds have read of one VkDeviceMemory, in ascending order of `begin`. */
struct memory_inputs {
    struct input_read *items;
    uint32_t count, capacity;
    uint64_t longest; /* no item has more bytes */
};

static void memory_inputs_free(void *record)
{
    struct memory_inputs *inputs = record;
    free(inputs->items);
    free(inputs);
}

void trace_search_forget_inputs(struct trace_search *search)
{
    handle_table_drop(&search->inputs, memory_inputs_free);
    search->input_count = 0;
}

/* Returns the first item that begins at `begin` or behind it. */
static uint32_t find_begin(const struct memory_inputs *inputs, uint64_t begin)
{
    uint32_t low = 0, high = inputs->count;
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (inputs->items[middle].begin < begin)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

void trace_search_write(struct trace_search *search, const struct hazard_bytes *bytes)
{
    struct memory_inputs *inputs =
        search->input_count ? handle_table_find(&search->inputs, bytes->memory + 1) : NULL;
    if (!inputs)
        return;
    const uint64_t before = bytes->begin < inputs->longest ? 0 : bytes->begin - inputs->longest;
    uint32_t kept = find_begin(inputs, before), i = kept;
    for (; i < inputs->count && inputs->items[i].begin < bytes->end; i++)
        if (inputs->items[i].end <= bytes->begin)
            inputs->items[kept++] = inputs->items[i];
    search->input_count -= i - kept;
    memmove(&inputs->items[kept], &inputs->items[i], (inputs->count - i) * sizeof(*inputs->items));
    inputs->count -= i - kept;
}

static struct memory_inputs *inputs_of(struct trace_search *search, uint64_t memory)
{
    struct memory_inputs *inputs = handle_table_find(&search->inputs, memory + 1);
    if (inputs)
        return inputs;
    inputs = calloc(1, sizeof(*inputs));
    if (inputs && !handle_table_set(&search->inputs, memory + 1, inputs)) {
        free(inputs);
        inputs = NULL;
    }
    return inputs;
}

/* Returns the item of exactly these bytes; adds one if there is none. Returns NULL if memory runs
 * out. */
static struct input_read *input_at(struct trace_search *search, const struct hazard_bytes *bytes)
{
    struct memory_inputs *inputs = inputs_of(search, bytes->memory);
    if (!inputs)
        return NULL;
    uint32_t at = find_begin(inputs, bytes->begin);
    for (; at < inputs->count && inputs->items[at].begin == bytes->begin; at++)
        if (inputs->items[at].end == bytes->end)
            return &inputs->items[at];
    if (!ARRAY_HAS_ROOM(inputs->items, inputs->count, inputs->capacity))
        return NULL;
    memmove(&inputs->items[at + 1], &inputs->items[at],
            (inputs->count - at) * sizeof(*inputs->items));
    inputs->items[at] = (struct input_read){.begin = bytes->begin, .end = bytes->end};
    if (inputs->longest < bytes->end - bytes->begin)
        inputs->longest = bytes->end - bytes->begin;
    inputs->count++;
    search->input_count++;
    return &inputs->items[at];
}

bool trace_search_read(struct trace_search *search, enum access_kind kind,
                       const struct data_read *data, struct hazard *hazard)
{
    const struct hazard_access read = {kind, data->bytes};
    if (search->input_count >= INPUTS_KEPT) {
        reporter_add_unchecked(search->reporter,
                               "inputs of builds beyond those that the layer remembers",
                               search->input_count);
        trace_search_forget_inputs(search);
    }
    if (!search->first_open)
        search->first_open = hazards_first_open_write(search->hazards, kind);
    struct input_read *input = input_at(search, &data->bytes);
    if (!input)
        return false;
    const struct input_read before = *input;
    input->stride = data->stride;
    input->size = data->size;
    input->hash = data->hash;
    input->first_open = search->first_open;
    input->side = hazards_last_access(search->hazards);
    return before.first_open && before.stride == data->stride && before.size == data->size &&
           before.hash != data->hash &&
           hazards_read_misses_writes(search->hazards, before.first_open, &before.side, &read,
                                      hazard);
}

void trace_search_forget_memory(struct trace_search *search, uint64_t memory)
{
    struct memory_inputs *inputs = handle_table_remove(&search->inputs, memory + 1);
    if (!inputs)
        return;
    search->input_count -= inputs->count;
    memory_inputs_free(inputs);
}

/* ---- commands */

void trace_search_begin_command(struct trace_search *search)
{
    search->first_open = 0;
    if (has_candidates(search))
        memset(&search->traced, 0, sizeof(search->traced));
}

void trace_search_begin(struct trace_search *search, struct reporter *reporter,
                        struct hazards *hazards)
{
    search->reporter = reporter;
    search->hazards = hazards;
}

void trace_search_end(struct trace_search *search)
{
    while (search->top_count)
        remove_top(search, search->tops[0]);
    free(search->tops);
    handle_table_release(&search->by_handle);
    trace_search_forget_inputs(search);
}
