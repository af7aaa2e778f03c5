/* SPDX-License-Identifier: Apache-2.0 */
/* Builds: classifies the input, lays out the scratch, and runs the steps in order. */
#include "src/bvh/bvh.h"

#include "src/base/float_environment.h"
#include "src/bvh/input/input.h"
#include "src/bvh/records.h"
#include "src/bvh/tree/tree.h"

/* Lays out the scratch for the state's input and counts. Returns its size in bytes. */
static uint64_t lay_out_scratch(struct build_state *state, const struct input_counts *counts,
                                struct input_tables *tables, void *scratch)
{
    struct scratch_cursor cursor = {(uintptr_t)scratch, 0};
    uint64_t primitives = state->primitive_count;
    enum builder_quality quality = state->input->quality;
    uint64_t chunks = (primitives + PREPARE_CHUNK - 1) / PREPARE_CHUNK;
    cursor.used = input_lay_out(state->input, state->kind, counts, scratch, tables);
    state->sources = tables->sources;
    state->chunk_counts = scratch_take(&cursor, chunks, sizeof(*state->chunk_counts));
    state->refs = scratch_take(&cursor, primitives, sizeof(*state->refs));
    state->tree = scratch_take(&cursor, primitives * 2, sizeof(*state->tree));
    state->tasks = scratch_take(&cursor, primitives / TREE_TASK_SIZE + 1, sizeof(*state->tasks));
    if (quality != BUILDER_FAST)
        state->costs = scratch_take(&cursor, primitives * 2, sizeof(*state->costs));
    if (quality != BUILDER_BALANCED) {
        state->pairs = scratch_take(&cursor, primitives, sizeof(*state->pairs));
        state->pairs_spare = scratch_take(&cursor, primitives, sizeof(*state->pairs_spare));
    }
    if (quality == BUILDER_HIGH) {
        state->refs_spare = scratch_take(&cursor, primitives, sizeof(*state->refs_spare));
        state->areas = scratch_take(&cursor, primitives, sizeof(*state->areas));
    }
    return cursor.used;
}

static void structure_sizes(const struct build_state *state, const struct input_counts *counts,
                            struct builder_sizes *sizes)
{
    struct structure_header header;
    struct build_state measured = *state;
    struct input_tables tables;
    uint32_t geometries = state->input->geometry_count;
    structure_lay_out(&header, state->kind, geometries, state->primitive_count,
                      structure_node_capacity(state->kind, state->primitive_count),
                      input_has_micromaps(state->input));
    sizes->structure = header.size;
    sizes->build_scratch = lay_out_scratch(&measured, counts, &tables, NULL);
    sizes->update_scratch = input_lay_out(state->input, state->kind, counts, NULL, &tables);
    if (structure_is_displaced(state->kind)) /* an update may turn into a build */
        sizes->update_scratch = sizes->build_scratch;
}

/* Determines the kind, the counts and the sizes of a build. */
static enum builder_result begin_build(struct build_state *state, const uint32_t *primitives,
                                       struct input_counts *counts, struct builder_sizes *sizes)
{
    enum builder_result result = input_kind(state->input, &state->kind);
    if (result == BUILDER_OK)
        result = input_count(state->input, state->kind, primitives, counts);
    if (result != BUILDER_OK)
        return result;
    state->primitive_count = state->record_capacity = (uint32_t)counts->primitives;
    structure_sizes(state, counts, sizes);
    return BUILDER_OK;
}

enum builder_result builder_get_sizes(const struct builder_input *input, const uint32_t *counts,
                                      struct builder_sizes *sizes)
{
    *sizes = (struct builder_sizes){0};
    struct build_state state = {.input = input};
    struct input_counts found;
    return begin_build(&state, counts, &found, sizes);
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

/* Clears everything except header, records and nodes, so that the bytes depend on the input
 * alone. */
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
    uint32_t records = state->record_capacity;
    structure_lay_out(state->header, state->kind, input->geometry_count, records,
                      structure_node_capacity(state->kind, records), input_has_micromaps(input));
    state->header->flags = input->flags;
    clear_gaps(state->header);
    input_write_micromaps(input, state->header);
    struct structure_geometry *geometries = structure_geometries(state->header);
    for (uint32_t i = 0; i < input->geometry_count; i++) {
        geometries[i].flags = input->geometries[i].flags;
        geometries[i].primitive_count = input->ranges[i].primitiveCount;
    }
}

/* There may be fewer displaced triangles than the usages declare. */
static void recount_primitives(struct build_state *state)
{
    state->primitive_count = 0;
    for (uint32_t i = 0; i < state->input->geometry_count; i++)
        state->primitive_count += state->sources[i].count;
}

static enum builder_result run_build(struct build_state *state, const struct input_tables *tables,
                                     struct builder_report *report)
{
    enum builder_result result = input_open(state->input, state->kind, tables, report);
    if (result != BUILDER_OK)
        return result;
    recount_primitives(state);
    workers_start(&state->workers, state->input, state->primitive_count);
    pthread_mutex_init(&state->lock, NULL);
    pthread_cond_init(&state->task_wakeup, NULL);
    result = tree_prepare(state, report);
    if (result == BUILDER_OK) {
        write_header(state);
        build_tree(state);
        clear_unused_records(state->header);
    }
    pthread_cond_destroy(&state->task_wakeup);
    pthread_mutex_destroy(&state->lock);
    workers_stop(&state->workers);
    return result;
}

enum builder_result builder_build(const struct builder_input *input, void *structure,
                                  uint64_t structure_size, void *scratch, uint64_t scratch_size,
                                  struct builder_report *report)
{
    struct builder_report discarded;
    report = report ? report : &discarded;
    *report = (struct builder_report){0};
    struct build_state state = {.input = input, .header = structure};
    struct builder_sizes sizes;
    struct input_counts counts;
    struct input_tables tables;
    enum builder_result result = begin_build(&state, NULL, &counts, &sizes);
    if (result != BUILDER_OK)
        return result;
    if (structure_size < sizes.structure || scratch_size < sizes.build_scratch)
        return BUILDER_TOO_SMALL;
    lay_out_scratch(&state, &counts, &tables, scratch);
    fenv_t of_application;
    float_environment_enter(&of_application);
    result = run_build(&state, &tables, report);
    float_environment_leave(&of_application);
    return result;
}
