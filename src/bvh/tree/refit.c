/* SPDX-License-Identifier: Apache-2.0 */
/* Updates: writes new positions and instances into the tree of a build, and recomputes the bounds
 * from the leaves up. Equal input gives bit-identical bounds in every pass, so repeated refits do
 * not drift. */
#include "src/base/float_environment.h"
#include "src/bvh/input/input.h"
#include "src/bvh/records.h"
#include "src/bvh/tree/tree.h"

static bool shape_is_same(const struct builder_input *input, const struct structure_header *header)
{
    const struct structure_geometry *geometries = structure_geometries(header);
    enum structure_kind kind;
    if (input_kind(input, &kind) != BUILDER_OK || kind != header->kind ||
        input->geometry_count != header->geometry_count ||
        input_has_micromaps(input) != (header->micromap_count > 0))
        return false;
    for (uint32_t i = 0; i < input->geometry_count; i++)
        if (input->ranges[i].primitiveCount != geometries[i].primitive_count)
            return false;
    return true;
}

/* The number of records by which index and vertex prefetches run ahead. They never reach beyond
 * `end`, where another thread may write. */
#define AHEAD_INDICES 32
#define AHEAD_VERTICES 16

struct refit {
    const struct builder_input *input;
    struct structure_header *header;
    const struct source *sources;
    struct builder_report *report; /* guarded by `lock` */
    pthread_mutex_t lock;
};

/* Returns the primitive that a record was built from. */
static struct builder_place place_of(enum structure_kind kind, const void *record)
{
    const struct instance_record *instance = record;
    /* All other records store the numbers where triangles do. */
    const struct triangle_record *other = record;
    return structure_is_top(kind) ? (struct builder_place){0, instance->primitive}
                                  : (struct builder_place){other->geometry, other->primitive};
}

static void prefetch(const struct refit *refit, enum structure_kind kind, const uint8_t *record,
                     uint32_t left)
{
    uint64_t size = structure_record_size(kind);
    if (!structure_has_triangles(kind))
        return;
    if (left > AHEAD_INDICES) {
        const struct triangle_record *ahead = (const void *)(record + AHEAD_INDICES * size);
        source_prefetch_indices(&refit->sources[ahead->geometry], ahead->primitive);
    }
    if (left > AHEAD_VERTICES) {
        const struct triangle_record *ahead = (const void *)(record + AHEAD_VERTICES * size);
        source_prefetch_vertices(&refit->sources[ahead->geometry], ahead->primitive);
    }
}

static ALWAYS_INLINE enum source_state read_again(const struct refit *refit,
                                                  enum structure_kind kind,
                                                  struct builder_place place, const void *record,
                                                  union any_record *fresh, const void **blas)
{
    const struct source *source = &refit->sources[place.geometry];
    if (kind == STRUCTURE_DISPLACED)
        return displaced_read_part(source, place.primitive, *structure_part(kind, record),
                                   &fresh->displaced);
    if (kind == STRUCTURE_MOTION_DISPLACED)
        return displaced_read_motion_part(source, place.primitive, *structure_part(kind, record),
                                          &fresh->motion_displaced);
    return record_resolve(refit->input, kind, source, place.primitive, fresh, blas);
}

/* A primitive that has become inactive or unreadable keeps its old record. */
static ALWAYS_INLINE void refit_kind(const struct refit *refit, enum structure_kind kind,
                                     uint32_t begin, uint32_t end, struct builder_report *report)
{
    uint64_t size = structure_record_size(kind);
    uint8_t *record = (uint8_t *)structure_records(refit->header) + begin * size;
    for (uint32_t i = begin; i < end; i++, record += size) {
        prefetch(refit, kind, record, end - i);
        struct builder_place place = place_of(kind, record);
        union any_record fresh;
        const void *blas;
        enum source_state found = read_again(refit, kind, place, record, &fresh, &blas);
        if (found != SOURCE_ACTIVE) {
            report_state(report, found, place);
            continue;
        }
        record_finish(kind, place, &refit->sources[place.geometry], &fresh);
        memcpy(record, &fresh, size);
        if (structure_is_top(kind) &&
            builder_determinant_sign(&fresh.instance.instance.transform) == 0)
            report_place(&report->singular, &report->first_singular, place);
    }
}

static void refit_records(void *context, uint32_t begin, uint32_t end)
{
    struct refit *refit = context;
    struct builder_report report = {0};
    enum structure_kind kind = refit->header->kind;
    if (kind == STRUCTURE_TRIANGLES) /* by far the most frequent kind */
        refit_kind(refit, STRUCTURE_TRIANGLES, begin, end, &report);
    else
        refit_kind(refit, kind, begin, end, &report);
    pthread_mutex_lock(&refit->lock);
    report_merge(refit->report, &report);
    pthread_mutex_unlock(&refit->lock);
}

/* Returns whether displaced triangles have the same subdivision as before. */
static bool levels_match(const struct structure_header *before, const struct source *sources)
{
    uint64_t size = structure_record_size(before->kind);
    const uint8_t *record = structure_records(before);
    if (!structure_is_displaced(before->kind))
        return true;
    for (uint32_t i = 0; i < before->record_count; i++, record += size) {
        struct builder_place place = place_of(before->kind, record);
        if (!displaced_level_matches(&sources[place.geometry], place.primitive,
                                     *structure_part(before->kind, record)))
            return false;
    }
    return true;
}

static void run_refit(struct refit *refit)
{
    struct workers workers;
    uint32_t count = refit->header->record_count;
    workers_start(&workers, refit->input, count);
    pthread_mutex_init(&refit->lock, NULL);
    workers_each(&workers, count, RECORD_CHUNK, refit_records, refit);
    refit->report->active = count - refit->report->inactive;
    bounds_update(refit->header, &refit->input->resolver, &workers);
    pthread_mutex_destroy(&refit->lock);
    workers_stop(&workers);
}

/* Changes nothing if the tree has to change. */
static enum builder_result open_and_run(struct refit *refit, const struct structure_header *before,
                                        const struct input_tables *tables, bool *same_levels)
{
    enum builder_result result = input_open(refit->input, before->kind, tables, refit->report);
    if (result != BUILDER_OK)
        return result;
    *same_levels = levels_match(before, tables->sources);
    if (!*same_levels)
        return BUILDER_OK;
    if (refit->header != before)
        memcpy(refit->header, before, before->size);
    input_write_micromaps(refit->input, refit->header);
    run_refit(refit);
    return refit->report->out_of_range > 0 ? BUILDER_INPUT_OUT_OF_RANGE : BUILDER_OK;
}

enum builder_result builder_refit(const struct builder_input *input, const void *source,
                                  void *structure, uint64_t structure_size, void *scratch,
                                  uint64_t scratch_size, struct builder_report *report)
{
    struct builder_report discarded;
    report = report ? report : &discarded;
    *report = (struct builder_report){0};
    const struct structure_header *before = source;
    if (!shape_is_same(input, before))
        return BUILDER_INCOMPATIBLE;
    struct input_counts counts;
    struct input_tables tables;
    bool same_levels = true;
    enum builder_result result = input_count(input, before->kind, NULL, &counts);
    if (result != BUILDER_OK)
        return result;
    if (structure_size < before->size ||
        scratch_size < input_lay_out(input, before->kind, &counts, scratch, &tables))
        return BUILDER_TOO_SMALL;
    fenv_t of_application;
    float_environment_enter(&of_application);
    struct refit refit = {
        .input = input, .header = structure, .sources = tables.sources, .report = report};
    result = open_and_run(&refit, before, &tables, &same_levels);
    float_environment_leave(&of_application);
    return same_levels
               ? result
               : builder_build(input, structure, structure_size, scratch, scratch_size, report);
}
