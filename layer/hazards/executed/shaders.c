/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/hazards/executed/shaders.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"

/* Inputs beyond so many are forgotten, all at once. */
enum { INPUTS_KEPT = 1 << 16 };

/* ---- top-level structures */

static void remove_top(struct shader_judge *judge, struct top_level *top)
{
    judge->tops[top->index] = judge->tops[--judge->top_count];
    judge->tops[top->index]->index = top->index;
    judge->gone_count -= top->is_gone;
    if (judge->last_built == top)
        judge->last_built = NULL;
    handle_table_remove(&judge->by_handle, top->structure);
    free(top->references);
    free(top);
}

struct top_level *shader_judge_find_top(const struct shader_judge *judge, uint64_t structure)
{
    return handle_table_find(&judge->by_handle, structure);
}

/* The oldest one of those that are destroyed is the one that was built first. */
static void remove_oldest_gone(struct shader_judge *judge)
{
    struct top_level *oldest = NULL;
    for (uint32_t i = 0; i < judge->top_count; i++)
        if (judge->tops[i]->is_gone && (!oldest || judge->tops[i]->command < oldest->command))
            oldest = judge->tops[i];
    if (!oldest)
        return;
    reporter_add_unchecked(judge->reporter,
                           "destroyed top-level structures, of more than the layer remembers", 1);
    remove_top(judge, oldest);
}

/* Returns false if memory runs out. */
static bool keep_top(struct shader_judge *judge, const struct top_level *top)
{
    struct top_level *kept = malloc(sizeof(*kept));
    if (!kept || !ARRAY_HAS_ROOM(judge->tops, judge->top_count, judge->top_capacity) ||
        !handle_table_set(&judge->by_handle, top->structure, kept)) {
        free(kept);
        return false;
    }
    *kept = *top;
    kept->index = judge->top_count;
    judge->tops[judge->top_count++] = kept;
    return true;
}

void shader_judge_add_top(struct shader_judge *judge, const struct top_level *top)
{
    struct top_level *old = shader_judge_find_top(judge, top->structure);
    if (old)
        remove_top(judge, old);
    if (judge->gone_count > GONE_KEPT)
        remove_oldest_gone(judge);
    if (!top->first.memory || !keep_top(judge, top))
        unknown_set(&judge->tops_unknown, UNKNOWN_TRACED);
}

void shader_judge_end_top(struct shader_judge *judge, uint64_t structure,
                          const struct destroyed_structure *destroyed)
{
    struct top_level *top = shader_judge_find_top(judge, structure);
    if (!top)
        return;
    judge->gone_count += !top->is_gone;
    top->is_gone = true;
    top->reference_count = 0;
    top->destroyed = destroyed ? *destroyed : (struct destroyed_structure){0};
}

/* References of one build follow each other. */
static struct top_level *find_built(struct shader_judge *judge, uint64_t command, uint32_t position)
{
    struct top_level *last = judge->last_built;
    if (last && last->command == command && last->position == position)
        return last;
    for (uint32_t i = judge->top_count; i-- > 0;)
        if (judge->tops[i]->command == command && judge->tops[i]->position == position) {
            judge->last_built = judge->tops[i];
            return judge->tops[i];
        }
    return NULL;
}

void shader_judge_add_reference(struct shader_judge *judge, uint64_t command, uint32_t position,
                                const struct top_reference *reference)
{
    struct top_level *top = find_built(judge, command, position);
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

struct top_level *shader_judge_find_top_at(const struct shader_judge *judge, uint64_t structure,
                                           const struct hazard_bytes *first)
{
    struct top_level *top = shader_judge_find_top(judge, structure);
    const bool is_there = top && (first->memory ? top->first.memory == first->memory &&
                                                      top->first.begin == first->begin
                                                : top->is_gone);
    return is_there ? top : NULL;
}

/* Whether something that is known was written where a structure begins. */
static bool is_place_of_top(const struct shader_judge *judge, const struct hazard_bytes *first)
{
    for (uint32_t i = 0; i < judge->top_count; i++)
        if (judge->tops[i]->first.memory == first->memory &&
            judge->tops[i]->first.begin == first->begin)
            return true;
    return false;
}

/* A structure that is not among those that were written, alive, and where no other one was written,
 * is one that nothing has built. */
void shader_judge_add_traced(struct shader_judge *judge, uint64_t structure,
                             const struct hazard_bytes *first, bool is_alive)
{
    struct top_level *top = shader_judge_find_top_at(judge, structure, first);
    const bool is_unbuilt = is_alive && first->memory && !unknown_is_set(&judge->tops_unknown) &&
                            !shader_judge_find_top(judge, structure) &&
                            !is_place_of_top(judge, first);
    for (uint32_t i = 0; top && i < judge->traced.count; i++)
        if (judge->traced.tops[i] == top)
            return;
    if (top && judge->traced.count < TRACED_KEPT)
        judge->traced.tops[judge->traced.count++] = top;
    else if (is_unbuilt && judge->traced.unbuilt != structure)
        judge->traced.unbuilt_count++;
    else if (!is_unbuilt)
        judge->traced.is_unknown = true;
    if (is_unbuilt)
        judge->traced.unbuilt = structure;
}

/* Whether it is known from descriptors what the command may trace. */
static bool has_candidates(const struct shader_judge *judge)
{
    return judge->traced.count || judge->traced.unbuilt_count || judge->traced.is_unknown;
}

struct top_level *shader_judge_only_top(struct shader_judge *judge)
{
    struct top_level *only = judge->traced.tops[0];
    uint32_t count = judge->traced.count + judge->traced.unbuilt_count;
    if (judge->traced.is_unknown || (has_candidates(judge) && count != 1))
        return NULL;
    if (!has_candidates(judge)) {
        if (unknown_is_set(&judge->tops_unknown))
            return NULL;
        for (uint32_t i = 0; i < judge->top_count; i++)
            if (!judge->tops[i]->is_gone) {
                only = judge->tops[i];
                count++;
            }
    }
    return count == 1 && only && only->is_built ? only : NULL;
}

uint64_t shader_judge_unbuilt(const struct shader_judge *judge)
{
    const bool is_certain =
        !judge->traced.is_unknown && !judge->traced.count && judge->traced.unbuilt_count == 1;
    return is_certain ? judge->traced.unbuilt : 0;
}

bool shader_judge_trace(struct shader_judge *judge, enum access_kind kind, struct hazard *hazard)
{
    const bool has_all = !has_candidates(judge);
    const uint32_t count = has_all ? judge->top_count : judge->traced.count;
    struct top_level *const *tops = has_all ? judge->tops : judge->traced.tops;
    bool found = false;
    if (judge->traced.is_unknown || (has_all && unknown_is_set(&judge->tops_unknown)))
        return false;
    for (uint32_t i = 0; i < count; i++) {
        const struct top_level *top = tops[i];
        struct hazard early;
        if (top->is_gone)
            continue;
        if (!hazards_read_is_early(judge->hazards, &(struct hazard_access){kind, top->first},
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

void shader_judge_overwrite(struct shader_judge *judge, const struct hazard_access *write,
                            uint64_t structure, uint64_t number)
{
    for (uint32_t i = 0; i < judge->top_count; i++) {
        struct top_level *top = judge->tops[i];
        if (top->trace.side.number && top_level_refers(top, structure))
            hazards_write_after(judge->hazards, &top->trace.side, number, write);
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

void shader_judge_forget_inputs(struct shader_judge *judge)
{
    handle_table_drop(&judge->inputs, memory_inputs_free);
    judge->input_count = 0;
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

void shader_judge_write(struct shader_judge *judge, const struct hazard_bytes *bytes)
{
    struct memory_inputs *inputs =
        judge->input_count ? handle_table_find(&judge->inputs, bytes->memory + 1) : NULL;
    if (!inputs)
        return;
    const uint64_t before = bytes->begin < inputs->longest ? 0 : bytes->begin - inputs->longest;
    uint32_t kept = find_begin(inputs, before), i = kept;
    for (; i < inputs->count && inputs->items[i].begin < bytes->end; i++)
        if (inputs->items[i].end <= bytes->begin)
            inputs->items[kept++] = inputs->items[i];
    judge->input_count -= i - kept;
    memmove(&inputs->items[kept], &inputs->items[i], (inputs->count - i) * sizeof(*inputs->items));
    inputs->count -= i - kept;
}

static struct memory_inputs *inputs_of(struct shader_judge *judge, uint64_t memory)
{
    struct memory_inputs *inputs = handle_table_find(&judge->inputs, memory + 1);
    if (inputs)
        return inputs;
    inputs = calloc(1, sizeof(*inputs));
    if (inputs && !handle_table_set(&judge->inputs, memory + 1, inputs)) {
        free(inputs);
        inputs = NULL;
    }
    return inputs;
}

/* Returns the item of exactly these bytes; adds one if there is none. Returns NULL if memory runs
 * out. */
static struct input_read *input_at(struct shader_judge *judge, const struct hazard_bytes *bytes)
{
    struct memory_inputs *inputs = inputs_of(judge, bytes->memory);
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
    judge->input_count++;
    return &inputs->items[at];
}

bool shader_judge_read(struct shader_judge *judge, enum access_kind kind,
                       const struct data_read *data, struct hazard *hazard)
{
    const struct hazard_access read = {kind, data->bytes};
    if (judge->input_count >= INPUTS_KEPT) {
        reporter_add_unchecked(judge->reporter,
                               "inputs of builds, of more than the layer remembers",
                               judge->input_count);
        shader_judge_forget_inputs(judge);
    }
    if (!judge->first_open)
        judge->first_open = hazards_first_open_write(judge->hazards, kind);
    struct input_read *input = input_at(judge, &data->bytes);
    if (!input)
        return false;
    const struct input_read before = *input;
    input->stride = data->stride;
    input->size = data->size;
    input->hash = data->hash;
    input->first_open = judge->first_open;
    input->side = hazards_last_access(judge->hazards);
    return before.first_open && before.stride == data->stride && before.size == data->size &&
           before.hash != data->hash &&
           hazards_read_misses_writes(judge->hazards, before.first_open, &before.side, &read,
                                      hazard);
}

void shader_judge_forget_memory(struct shader_judge *judge, uint64_t memory)
{
    struct memory_inputs *inputs = handle_table_remove(&judge->inputs, memory + 1);
    if (!inputs)
        return;
    judge->input_count -= inputs->count;
    memory_inputs_free(inputs);
}

/* ---- commands */

void shader_judge_begin_command(struct shader_judge *judge)
{
    judge->first_open = 0;
    if (has_candidates(judge))
        memset(&judge->traced, 0, sizeof(judge->traced));
}

void shader_judge_begin(struct shader_judge *judge, struct reporter *reporter,
                        struct hazards *hazards)
{
    judge->reporter = reporter;
    judge->hazards = hazards;
}

void shader_judge_end(struct shader_judge *judge)
{
    while (judge->top_count)
        remove_top(judge, judge->tops[0]);
    free(judge->tops);
    handle_table_release(&judge->by_handle);
    shader_judge_forget_inputs(judge);
}
