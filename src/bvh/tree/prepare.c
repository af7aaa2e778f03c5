/* SPDX-License-Identifier: Apache-2.0 */
/* Reads every primitive once; determines the active ones and their bounds. */
#include "src/bvh/bounds.h"
#include "src/bvh/input/report.h"
#include "src/bvh/records.h"
#include "src/bvh/tree/tree.h"

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

/* A ref holds finite bounds in lanes 0 to 2 and the primitive's number in lane 3. NaN bounds (of a
 * triangle that is NaN after its transform) become the origin: no ray can hit such a primitive. */
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

/* The contribution of a chunk to the whole. Chunks may be merged in any order. */
struct findings {
    struct box bounds, centers;
    struct builder_report report;
    bool has_clamped;
};

/* Writes the refs of [begin, end) without gaps from position `begin` on. Returns their count. */
static ALWAYS_INLINE uint32_t prepare_kind(const struct build_state *state,
                                           enum structure_kind kind, uint32_t begin, uint32_t end,
                                           struct findings *findings)
{
    struct primitive_ref *to = state->refs + begin;
    uint32_t geometry = tree_geometry_of(state, begin);
    for (uint32_t number = begin; number < end; number++) {
        while (number - state->sources[geometry].first >= state->sources[geometry].count)
            geometry++;
        const struct source *source = &state->sources[geometry];
        struct builder_place place = {geometry, number - source->first};
        union any_record record;
        const void *blas;
        enum source_state found =
            record_resolve(state->input, kind, source, place.primitive, &record, &blas);
        if (found != SOURCE_ACTIVE) {
            if (structure_is_displaced(kind))
                place.primitive = displaced_base_of(source, place.primitive);
            report_state(&findings->report, found, place);
            continue;
        }
        findings->report.active++;
        if (structure_is_top(kind) &&
            builder_determinant_sign(&record.instance.instance.transform) == 0)
            report_place(&findings->report.singular, &findings->report.first_singular, place);
        struct box box = bounds_of_record(kind, &record, blas);
        struct primitive_ref ref = make_ref(box, number, &findings->has_clamped);
        float4 center = ref.lower + ref.upper;
        box_add(&findings->bounds, ref.lower, ref.upper);
        box_add(&findings->centers, center, center);
        *to++ = ref;
    }
    return (uint32_t)(to - state->refs) - begin;
}

static uint32_t prepare_refs(const struct build_state *state, uint32_t begin, uint32_t end,
                             struct findings *findings)
{
    if (state->kind == STRUCTURE_TRIANGLES) /* by far the most frequent kind */
        return prepare_kind(state, STRUCTURE_TRIANGLES, begin, end, findings);
    return prepare_kind(state, state->kind, begin, end, findings);
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
