/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the records of a structure in the order of its tree. */
#include "src/bvh/records.h"

#include "src/bvh/tree/tree.h"

/* Returns the number of the primitive at a position in the order of the tree. */
static inline uint32_t number_at(const struct build_state *state, uint64_t index)
{
    return state->has_bounds ? ref_primitive(&state->refs[index]) : state->pairs[index].index;
}

/* The number of records by which index and vertex prefetches run ahead. */
#define AHEAD_INDICES 32
#define AHEAD_VERTICES 16

static void prefetch(const struct build_state *state, uint64_t index)
{
    if (!structure_has_triangles(state->kind))
        return;
    if (index + AHEAD_INDICES < state->ref_count) {
        uint32_t number = number_at(state, index + AHEAD_INDICES);
        const struct source *source = &state->sources[tree_geometry_of(state, number)];
        source_prefetch_indices(source, number - source->first);
    }
    if (index + AHEAD_VERTICES < state->ref_count) {
        uint32_t number = number_at(state, index + AHEAD_VERTICES);
        const struct source *source = &state->sources[tree_geometry_of(state, number)];
        source_prefetch_vertices(source, number - source->first);
    }
}

/* Every primitive here was read before and found active. */
static ALWAYS_INLINE void write_kind(const struct build_state *state, enum structure_kind kind,
                                     uint32_t begin, uint32_t end)
{
    uint64_t size = structure_record_size(kind);
    uint8_t *records = structure_records(state->header);
    for (uint32_t i = begin; i < end; i++) {
        union any_record *record = (void *)(records + i * size);
        prefetch(state, i);
        uint32_t number = number_at(state, i), geometry = tree_geometry_of(state, number);
        struct builder_place place = {geometry, number - state->sources[geometry].first};
        record_read(state->input, kind, &state->sources[geometry], place.primitive, record);
        record_finish(kind, place, &state->sources[geometry], record);
    }
}

static void write_records(void *context, uint32_t begin, uint32_t end)
{
    const struct build_state *state = context;
    if (state->kind == STRUCTURE_TRIANGLES) /* by far the most frequent kind */
        write_kind(state, STRUCTURE_TRIANGLES, begin, end);
    else
        write_kind(state, state->kind, begin, end);
}

void tree_write_records(struct build_state *state)
{
    workers_each(&state->workers, state->ref_count, RECORD_CHUNK, write_records, state);
    state->header->record_count = state->ref_count;
}
