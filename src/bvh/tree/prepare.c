/* SPDX-License-Identifier: Apache-2.0 */
/* Reads every primitive once, determines the active ones and their bounds, reports what is wrong
 * with the input, and writes the records. */
#include "src/bvh/tree/tree.h"

#include "src/bvh/records.h"

/* Bounds are clamped to this magnitude, so that sums and differences of two coordinates stay
 * finite. If clamping changed any bounds, the bounds of the tree are recomputed from the records
 * (`has_clamped`). */
#define TREE_COORDINATE_LIMIT 4e37f

static void add_count(uint64_t *count, struct builder_place *first, uint64_t more,
                      struct builder_place its_first)
{
    bool is_before =
        its_first.geometry < first->geometry ||
        (its_first.geometry == first->geometry && its_first.primitive < first->primitive);
    if (more > 0 && (*count == 0 || is_before))
        *first = its_first;
    *count += more;
}

void report_place(uint64_t *count, struct builder_place *first, struct builder_place place)
{
    add_count(count, first, 1, place);
}

void report_state(struct builder_report *report, enum source_state found,
                  struct builder_place place)
{
    switch (found) {
    case SOURCE_ACTIVE:
        report->active++;
        return;
    case SOURCE_INACTIVE:
        break;
    case SOURCE_UNDEFINED:
        report_place(&report->undefined, &report->first_undefined, place);
        break;
    case SOURCE_OUT_OF_RANGE:
        report_place(&report->out_of_range, &report->first_out_of_range, place);
        break;
    case SOURCE_UNRESOLVED:
        report_place(&report->unresolved, &report->first_unresolved, place);
        break;
    }
    report->inactive++;
}

void report_merge(struct builder_report *report, const struct builder_report *more)
{
    report->active += more->active;
    report->inactive += more->inactive;
    add_count(&report->undefined, &report->first_undefined, more->undefined, more->first_undefined);
    add_count(&report->out_of_range, &report->first_out_of_range, more->out_of_range,
              more->first_out_of_range);
    add_count(&report->unresolved, &report->first_unresolved, more->unresolved,
              more->first_unresolved);
    add_count(&report->singular, &report->first_singular, more->singular, more->first_singular);
}

/* ---- reads every primitive once; determines the active ones and their bounds */

static uint32_t tree_geometry_of(const struct build_state *state, uint32_t primitive)
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

/* ---- writes the records of a structure in the order of its tree */

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
