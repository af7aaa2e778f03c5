/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the records of a structure in its tree's order. */
#include "build/records.h"

#include "build/expansion.h"
#include "build/tree.h"

/* Products of two floats are exact in double, so each cofactor is rounded once; the determinant is
 * exact before it is rounded. So every element is within 2^-51 of its value however close to
 * singular the matrix is, and nothing overflows: floats to the third power fit double's range. */
void record_invert(const VkTransformMatrixKHR *transform, double inverse[9])
{
    double determinant = transform_determinant(transform);
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) {
            int i = (column + 1) % 3, j = (column + 2) % 3, k = (row + 1) % 3, l = (row + 2) % 3;
            double a = (double)transform->matrix[i][k] * transform->matrix[j][l];
            double b = (double)transform->matrix[i][l] * transform->matrix[j][k];
            inverse[3 * row + column] = determinant == 0 ? 0 : (a - b) / determinant;
        }
}

/* In the tree's order. */
static inline uint32_t number_at(const struct build_state *state, uint64_t index)
{
    return state->has_bounds ? ref_primitive(&state->refs[index]) : state->pairs[index].index;
}

static void write_record(struct build_state *state, uint32_t index)
{
    uint32_t number = number_at(state, index);
    uint32_t geometry = tree_geometry_of(state, number);
    const struct source *source = &state->sources[geometry];
    uint32_t primitive = number - source->first;
    void *records = structure_records(state->header);
    switch (state->kind) {
    case STRUCTURE_TRIANGLES: {
        struct triangle_record *record = (struct triangle_record *)records + index;
        source_triangle(source, primitive, record);
        record->geometry = geometry;
        record->primitive = primitive;
        record->spare = 0;
        break;
    }
    case STRUCTURE_AABBS: {
        struct aabb_record *record = (struct aabb_record *)records + index;
        source_aabb(source, primitive, record);
        record->geometry = geometry;
        record->primitive = primitive;
        break;
    }
    case STRUCTURE_INSTANCES: {
        struct instance_record *record = (struct instance_record *)records + index;
        source_instance(source, primitive, &state->input->memory, record);
        record_invert(&record->instance.transform, record->inverse);
        record->primitive = primitive;
        record->spare = 0;
        break;
    }
    }
}

/* How many records ahead indices and vertices are asked for. */
#define AHEAD_INDICES 32
#define AHEAD_VERTICES 16

static void prefetch(const struct build_state *state, uint64_t index)
{
    if (state->kind != STRUCTURE_TRIANGLES)
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

static void write_records(void *context, uint32_t begin, uint32_t end)
{
    struct build_state *state = context;
    for (uint32_t i = begin; i < end; i++) {
        prefetch(state, i);
        write_record(state, i);
    }
}

void tree_write_records(struct build_state *state)
{
    workers_each(&state->workers, state->ref_count, RECORD_CHUNK, write_records, state);
    state->header->record_count = state->ref_count;
}
