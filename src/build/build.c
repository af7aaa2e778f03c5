/* SPDX-License-Identifier: Apache-2.0 */
/* Builds: what the input is, where in the scratch everything lies, and the order of the steps. */
#include "build/build.h"

#include <fenv.h>

#include "build/bounds.h"
#include "build/input.h"
#include "build/tree.h"

/* What each part of the scratch takes; `base` may be NULL to learn the size alone. */
struct scratch_cursor {
    uintptr_t base;
    uint64_t used;
};

static void *take(struct scratch_cursor *cursor, uint64_t count, uint64_t size)
{
    uint64_t at = cursor->used;
    cursor->used += (count * size + BUILDER_ALIGNMENT - 1) & ~(uint64_t)(BUILDER_ALIGNMENT - 1);
    return cursor->base ? (void *)(cursor->base + at) : NULL; // NOLINT(performance-no-int-to-ptr)
}

/* From the state's input and primitive count. */
static uint64_t lay_out_scratch(struct build_state *state, void *scratch)
{
    struct scratch_cursor cursor = {(uintptr_t)scratch, 0};
    uint64_t primitives = state->primitive_count;
    enum builder_quality quality = state->input->quality;
    uint64_t chunks = (primitives + PREPARE_CHUNK - 1) / PREPARE_CHUNK;
    state->sources = take(&cursor, state->input->geometry_count, sizeof(*state->sources));
    if (state->kind == STRUCTURE_DENSE)
        state->dense = take(&cursor, primitives, sizeof(*state->dense));
    state->chunk_counts = take(&cursor, chunks, sizeof(*state->chunk_counts));
    state->refs = take(&cursor, primitives, sizeof(*state->refs));
    state->tree = take(&cursor, primitives * 2, sizeof(*state->tree));
    state->tasks = take(&cursor, primitives / TREE_TASK_SIZE + 1, sizeof(*state->tasks));
    if (quality != BUILDER_FAST)
        state->costs = take(&cursor, primitives * 2, sizeof(*state->costs));
    if (quality != BUILDER_BALANCED) {
        state->pairs = take(&cursor, primitives, sizeof(*state->pairs));
        state->pairs_spare = take(&cursor, primitives, sizeof(*state->pairs_spare));
    }
    if (quality == BUILDER_HIGH) {
        state->refs_spare = take(&cursor, primitives, sizeof(*state->refs_spare));
        state->areas = take(&cursor, primitives, sizeof(*state->areas));
    }
    return cursor.used;
}

/* The counts of the ranges, or `counts` where sizes are asked for. */
static enum builder_result count_primitives(const struct builder_input *input,
                                            const uint32_t *counts, uint32_t *total)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < input->geometry_count; i++)
        sum += counts ? counts[i] : input->ranges[i].primitiveCount;
    *total = (uint32_t)sum;
    return sum > BUILDER_MAX_PRIMITIVES ? BUILDER_TOO_MANY_PRIMITIVES : BUILDER_OK;
}

static void structure_sizes(const struct build_state *state, struct builder_sizes *sizes)
{
    struct structure_header header;
    struct build_state measured = *state;
    uint32_t geometries = state->input->geometry_count;
    structure_lay_out(&header, state->kind, geometries, state->primitive_count,
                      structure_node_capacity(state->kind, state->primitive_count),
                      input_has_micromaps(state->input));
    sizes->structure = header.size;
    sizes->build_scratch = lay_out_scratch(&measured, NULL);
    sizes->update_scratch = refit_scratch(state->kind, geometries, state->primitive_count);
}

enum builder_result builder_get_sizes(const struct builder_input *input, const uint32_t *counts,
                                      struct builder_sizes *sizes)
{
    *sizes = (struct builder_sizes){0};
    struct build_state state = {.input = input};
    enum builder_result result = input_kind(input, &state.kind);
    if (result == BUILDER_OK)
        result = count_primitives(input, counts, &state.primitive_count);
    if (result == BUILDER_OK)
        structure_sizes(&state, sizes);
    return result;
}

static void clear_unused_records(const struct structure_header *header)
{
    uint64_t size = structure_record_size(header->kind), used = header->record_count * size;
    memset((uint8_t *)structure_records(header) + used, 0, header->nodes - header->records - used);
}

static void build_tree(struct build_state *state)
{
    if (state->ref_count == 0) {
        struct structure_header *header = state->header;
        memset(structure_nodes(header), 0, header->node_capacity * sizeof(struct wide_node));
        bounds_update(header, &state->input->resolver, &state->workers);
        return;
    }
    switch (state->input->quality) {
    case BUILDER_FAST:
        tree_build_morton(state);
        break;
    case BUILDER_BALANCED:
        tree_build_binned(state);
        break;
    case BUILDER_HIGH:
        tree_build_sweep(state);
        break;
    }
    tree_write_records(state);
    tree_emit(state);
}

/* All that is neither header, record nor node, so that the bytes depend on the input alone. */
static void clear_gaps(struct structure_header *header)
{
    uint8_t *bytes = (uint8_t *)header;
    uint64_t end = header->nodes + header->node_capacity * sizeof(struct wide_node);
    memset(bytes + sizeof(*header), 0, header->records - sizeof(*header));
    memset(bytes + end, 0, header->size - end);
}

static void write_header(struct build_state *state)
{
    const struct builder_input *input = state->input;
    uint32_t primitives = state->primitive_count;
    structure_lay_out(state->header, state->kind, input->geometry_count, primitives,
                      structure_node_capacity(state->kind, primitives), input_has_micromaps(input));
    state->header->flags = input->flags;
    clear_gaps(state->header);
    input_write_micromaps(input, state->header);
    struct structure_geometry *geometries = structure_geometries(state->header);
    for (uint32_t i = 0; i < input->geometry_count; i++) {
        geometries[i].flags = input->geometries[i].flags;
        geometries[i].primitive_count = state->sources[i].count;
    }
}

static enum builder_result run_build(struct build_state *state, struct builder_report *report)
{
    enum builder_result result = input_open(state->input, state->sources, state->dense, report);
    if (result != BUILDER_OK)
        return result;
    workers_start(&state->workers, state->input, state->primitive_count);
    pthread_mutex_init(&state->lock, NULL);
    pthread_cond_init(&state->task_news, NULL);
    result = tree_prepare(state, report);
    if (result == BUILDER_OK) {
        write_header(state);
        build_tree(state);
        clear_unused_records(state->header);
    }
    pthread_cond_destroy(&state->task_news);
    pthread_mutex_destroy(&state->lock);
    workers_stop(&state->workers);
    return result;
}

enum builder_result builder_build(const struct builder_input *input, void *structure,
                                  uint64_t structure_size, void *scratch, uint64_t scratch_size,
                                  struct builder_report *report)
{
    struct builder_report unread;
    report = report ? report : &unread;
    *report = (struct builder_report){0};
    struct build_state state = {.input = input, .header = structure};
    struct builder_sizes sizes;
    enum builder_result result = input_kind(input, &state.kind);
    if (result == BUILDER_OK)
        result = count_primitives(input, NULL, &state.primitive_count);
    if (result != BUILDER_OK)
        return result;
    structure_sizes(&state, &sizes);
    if (structure_size < sizes.structure || scratch_size < sizes.build_scratch)
        return BUILDER_TOO_SMALL;
    lay_out_scratch(&state, scratch);
    /* Rounding to nearest, subnormals kept, whatever the application has set. */
    fenv_t before;
    feholdexcept(&before);
    fesetenv(FE_DFL_ENV);
    result = run_build(&state, report);
    fesetenv(&before);
    return result;
}
