/* SPDX-License-Identifier: Apache-2.0 */
/* Reads every primitive once: which are active, and their bounds. */
#include "build/bounds.h"
#include "build/report.h"
#include "build/tree.h"

uint32_t tree_geometry_of(const struct build_state *state, uint32_t primitive)
{
    uint32_t low = 0, high = state->input->geometry_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (state->sources[middle].first <= primitive)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static enum source_state read_instance(const struct build_state *state, const struct source *source,
                                       uint32_t primitive, struct box *box,
                                       struct instance_record *record)
{
    const struct builder_input *input = state->input;
    enum source_state found = source_instance(source, primitive, &input->memory, record);
    if (found != SOURCE_ACTIVE)
        return found;
    const void *blas = input->resolver.find(input->resolver.context,
                                            record->instance.accelerationStructureReference);
    if (!blas)
        return SOURCE_UNRESOLVED;
    *box = bounds_of_instance(&record->instance.transform, blas);
    return SOURCE_ACTIVE;
}

static enum source_state read_bounds(const struct build_state *state, const struct source *source,
                                     uint32_t primitive, struct box *box, bool *is_singular)
{
    switch (state->kind) {
    case STRUCTURE_TRIANGLES: {
        struct triangle_record record;
        enum source_state found = source_triangle(source, primitive, &record);
        if (found == SOURCE_ACTIVE)
            *box = bounds_of_triangle(&record);
        return found;
    }
    case STRUCTURE_AABBS: {
        struct aabb_record record;
        enum source_state found = source_aabb(source, primitive, &record);
        if (found == SOURCE_ACTIVE)
            *box = (struct box){bounds_point(record.lower), bounds_point(record.upper)};
        return found;
    }
    case STRUCTURE_INSTANCES: {
        struct instance_record record;
        enum source_state found = read_instance(state, source, primitive, box, &record);
        if (found == SOURCE_ACTIVE)
            *is_singular = builder_determinant_sign(&record.instance.transform) == 0;
        return found;
    }
    }
    return SOURCE_INACTIVE;
}

/* Finite bounds in lanes 0 to 2, the primitive's number in lane 3. Bounds without a number (of a
 * triangle that is NaN after its transform) become the origin: nothing can hit it. */
static struct primitive_ref make_ref(struct box box, uint32_t primitive, bool *has_clamped)
{
    float4 limit = float4_all(TREE_COORDINATE_LIMIT);
    struct primitive_ref ref = {float4_max(float4_min(box.lower, limit), -limit),
                                float4_max(float4_min(box.upper, limit), -limit)};
    unsigned changed = int4_mask(ref.lower != box.lower) | int4_mask(ref.upper != box.upper);
    *has_clamped |= (changed & 7) != 0;
    ref.lower[3] = float_from_bits(REF_MARK | primitive);
    ref.upper[3] = 0;
    return ref;
}

static void prepare_chunk(const struct build_state *state, struct prepare_chunk *chunk,
                          uint32_t begin, uint32_t end)
{
    *chunk = (struct prepare_chunk){.bounds = box_empty(), .centers = box_empty()};
    uint32_t geometry = tree_geometry_of(state, begin);
    for (uint32_t number = begin; number < end; number++) {
        while (number - state->sources[geometry].first >= state->sources[geometry].count)
            geometry++;
        const struct source *source = &state->sources[geometry];
        struct builder_place place = {geometry, number - source->first};
        struct box box = box_empty();
        bool is_singular = false;
        enum source_state found = read_bounds(state, source, place.primitive, &box, &is_singular);
        report_state(&chunk->report, found, place);
        if (found != SOURCE_ACTIVE)
            continue;
        if (is_singular)
            report_place(&chunk->report.singular, &chunk->report.first_singular, place);
        struct primitive_ref ref = make_ref(box, number, &chunk->has_clamped);
        float4 center = ref.lower + ref.upper;
        box_add(&chunk->bounds, ref.lower, ref.upper);
        box_add(&chunk->centers, center, center);
        state->refs[begin + chunk->count++] = ref;
    }
}

static void prepare_job(void *context)
{
    struct build_state *state = context;
    for (;;) {
        uint32_t index = __atomic_fetch_add(&state->next_chunk, 1, __ATOMIC_RELAXED);
        if (index >= state->chunk_count)
            return;
        uint32_t begin = index * PREPARE_CHUNK, left = state->primitive_count - begin;
        uint32_t count = left < PREPARE_CHUNK ? left : PREPARE_CHUNK;
        prepare_chunk(state, &state->chunks[index], begin, begin + count);
    }
}

enum builder_result tree_prepare(struct build_state *state, struct builder_report *report)
{
    state->next_chunk = 0;
    workers_run(&state->workers, prepare_job, state);
    state->bounds = state->centers = box_empty();
    for (uint32_t i = 0; i < state->chunk_count; i++) {
        const struct prepare_chunk *chunk = &state->chunks[i];
        report_merge(report, &chunk->report);
        state->has_clamped |= chunk->has_clamped;
        box_add(&state->bounds, chunk->bounds.lower, chunk->bounds.upper);
        box_add(&state->centers, chunk->centers.lower, chunk->centers.upper);
        struct primitive_ref *from = state->refs + (uint64_t)i * PREPARE_CHUNK;
        struct primitive_ref *to = state->refs + state->ref_count;
        if (to != from)
            memmove(to, from, chunk->count * sizeof(*to));
        state->ref_count += chunk->count;
    }
    return report->out_of_range > 0 ? BUILDER_INPUT_OUT_OF_RANGE : BUILDER_OK;
}
