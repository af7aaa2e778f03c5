/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/execution/hazards/shaders.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"

/* Inputs beyond so many are forgotten, all at once. */
enum { INPUTS_KEPT = 1 << 16 };

/* ---- top-level structures */

void shader_judge_remove_top(struct shader_judge *judge, uint64_t structure)
{
    for (uint32_t i = 0; i < judge->top_count; i++)
        if (judge->tops[i].structure == structure) {
            judge->tops[i] = judge->tops[--judge->top_count];
            return;
        }
}

void shader_judge_add_top(struct shader_judge *judge, const struct top_level *top)
{
    shader_judge_remove_top(judge, top->structure);
    if (top->first.memory && judge->top_count < TOP_LEVELS_KEPT)
        judge->tops[judge->top_count++] = *top;
    else
        judge->lacks_tops = true;
}

bool shader_judge_trace(struct shader_judge *judge, enum access_kind kind, struct hazard *hazard)
{
    bool found = false;
    for (uint32_t i = 0; i < judge->top_count && !judge->lacks_tops; i++) {
        const struct top_level *top = &judge->tops[i];
        struct hazard early;
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

/* ---- what builds have read */

struct input_read {
    uint64_t begin, end;
    uint64_t stride, size, hash; /* of the data that the last build read */
    uint64_t first_open; /* see hazards_first_open_write(), at that build; 0: there was none */
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

static void forget_inputs(struct shader_judge *judge)
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

/* Returns the item of exactly these bytes, perhaps a new one. Returns NULL if memory runs out. */
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
    if (judge->input_count >= INPUTS_KEPT)
        forget_inputs(judge);
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
    return before.first_open && before.stride == data->stride && before.size == data->size &&
           before.hash != data->hash &&
           hazards_read_misses_writes(judge->hazards, before.first_open, &read, hazard);
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
}

void shader_judge_begin(struct shader_judge *judge, struct hazards *hazards)
{
    judge->hazards = hazards;
}

void shader_judge_end(struct shader_judge *judge)
{
    forget_inputs(judge);
}
