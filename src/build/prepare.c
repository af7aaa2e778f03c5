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

/* What a chunk adds to the whole, in any order. */
struct findings {
    struct box bounds, centers;
    struct builder_report report;
    bool has_clamped;
};

/* Refs of [begin, end) to the place of the first, without gaps; returns their count. */
static uint32_t prepare_refs(const struct build_state *state, uint32_t begin, uint32_t end,
                             struct findings *findings)
{
    struct primitive_ref *to = state->refs + begin;
    uint32_t geometry = tree_geometry_of(state, begin);
    for (uint32_t number = begin; number < end; number++) {
        while (number - state->sources[geometry].first >= state->sources[geometry].count)
            geometry++;
        const struct source *source = &state->sources[geometry];
        struct builder_place place = {geometry, number - source->first};
        struct box box = box_empty();
        bool is_singular = false;
        enum source_state found = read_bounds(state, source, place.primitive, &box, &is_singular);
        if (found != SOURCE_ACTIVE) {
            report_state(&findings->report, found, place);
            continue;
        }
        findings->report.active++;
        if (is_singular)
            report_place(&findings->report.singular, &findings->report.first_singular, place);
        struct primitive_ref ref = make_ref(box, number, &findings->has_clamped);
        float4 center = ref.lower + ref.upper;
        box_add(&findings->bounds, ref.lower, ref.upper);
        box_add(&findings->centers, center, center);
        *to++ = ref;
    }
    return (uint32_t)(to - state->refs) - begin;
}

struct prepare_job {
    struct build_state *state;
    struct builder_report *report;
};

static void prepare_chunk(void *context, uint32_t begin, uint32_t end)
{
    const struct prepare_job *job = context;
    struct build_state *state = job->state;
    struct findings findings = {.bounds = box_empty(), .centers = box_empty()};
    state->chunk_counts[begin / PREPARE_CHUNK] = prepare_refs(state, begin, end, &findings);
    pthread_mutex_lock(&state->lock);
    report_merge(job->report, &findings.report);
    state->has_clamped |= findings.has_clamped;
    box_add(&state->bounds, findings.bounds.lower, findings.bounds.upper);
    box_add(&state->centers, findings.centers.lower, findings.centers.upper);
    pthread_mutex_unlock(&state->lock);
}

enum builder_result tree_prepare(struct build_state *state, struct builder_report *report)
{
    struct prepare_job job = {state, report};
    state->bounds = state->centers = box_empty();
    workers_each(&state->workers, state->primitive_count, PREPARE_CHUNK, prepare_chunk, &job);
    for (uint32_t begin = 0; begin < state->primitive_count; begin += PREPARE_CHUNK) {
        uint32_t count = state->chunk_counts[begin / PREPARE_CHUNK];
        if (state->ref_count != begin)
            memmove(state->refs + state->ref_count, state->refs + begin,
                    count * sizeof(*state->refs));
        state->ref_count += count;
    }
    return report->out_of_range > 0 ? BUILDER_INPUT_OUT_OF_RANGE : BUILDER_OK;
}
