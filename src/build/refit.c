/* SPDX-License-Identifier: Apache-2.0 */
/* Updates: new positions and instances in the tree that a build made, bounds from the leaves up.
 * Equal input gives bounds bit-equal to any other pass, so refits don't drift. */
#include "build/bounds.h"
#include "build/input.h"
#include "build/records.h"
#include "build/report.h"

#include <fenv.h>

static bool shape_is_same(const struct builder_input *input, const struct structure_header *header)
{
    const struct structure_geometry *geometries = structure_geometries(header);
    enum structure_kind kind;
    if (input_kind(input, &kind) != BUILDER_OK || kind != header->kind ||
        input->geometry_count != header->geometry_count)
        return false;
    for (uint32_t i = 0; i < input->geometry_count; i++)
        if (input->ranges[i].primitiveCount != geometries[i].primitive_count)
            return false;
    return true;
}

/* How many records ahead indices and vertices are asked for; never beyond `end`, where another
 * thread may write. */
#define AHEAD_INDICES 32
#define AHEAD_VERTICES 16

static void prefetch(const struct structure_header *header, const struct source *sources,
                     uint32_t index, uint32_t end)
{
    const struct triangle_record *records = structure_records(header);
    if (index + AHEAD_INDICES < end) {
        const struct triangle_record *record = &records[index + AHEAD_INDICES];
        source_prefetch_indices(&sources[record->geometry], record->primitive);
    }
    if (index + AHEAD_VERTICES < end) {
        const struct triangle_record *record = &records[index + AHEAD_VERTICES];
        source_prefetch_vertices(&sources[record->geometry], record->primitive);
    }
}

struct refit {
    const struct builder_input *input;
    struct structure_header *header;
    const struct source *sources;
    struct builder_report *report; /* under `lock` */
    pthread_mutex_t lock;
};

/* A primitive that isn't active any more, or can't be read, keeps what it had. */
static void refit_triangles(const struct refit *refit, uint32_t begin, uint32_t end,
                            struct builder_report *report)
{
    struct triangle_record *records = structure_records(refit->header);
    for (uint32_t i = begin; i < end; i++) {
        prefetch(refit->header, refit->sources, i, end);
        struct triangle_record *record = &records[i], fresh = *record;
        enum source_state found =
            source_triangle(&refit->sources[record->geometry], record->primitive, &fresh);
        if (found == SOURCE_ACTIVE)
            *record = fresh;
        else
            report_state(report, found,
                         (struct builder_place){record->geometry, record->primitive});
    }
}

static void refit_aabbs(const struct refit *refit, uint32_t begin, uint32_t end,
                        struct builder_report *report)
{
    struct aabb_record *records = structure_records(refit->header);
    for (uint32_t i = begin; i < end; i++) {
        struct aabb_record *record = &records[i], fresh = *record;
        enum source_state found =
            source_aabb(&refit->sources[record->geometry], record->primitive, &fresh);
        if (found == SOURCE_ACTIVE)
            *record = fresh;
        else
            report_state(report, found,
                         (struct builder_place){record->geometry, record->primitive});
    }
}

static void refit_instances(const struct refit *refit, uint32_t begin, uint32_t end,
                            struct builder_report *report)
{
    const struct builder_resolver *resolver = &refit->input->resolver;
    struct instance_record *records = structure_records(refit->header);
    for (uint32_t i = begin; i < end; i++) {
        struct instance_record *record = &records[i], fresh = *record;
        enum source_state found =
            source_instance(refit->sources, record->primitive, &refit->input->memory, &fresh);
        struct builder_place place = {0, record->primitive};
        uint64_t reference = fresh.instance.accelerationStructureReference;
        if (found == SOURCE_ACTIVE && !resolver->find(resolver->context, reference))
            found = SOURCE_UNRESOLVED;
        if (found != SOURCE_ACTIVE) {
            report_state(report, found, place);
            continue;
        }
        record_invert(&fresh.instance.transform, fresh.inverse);
        *record = fresh;
        if (builder_determinant_sign(&fresh.instance.transform) == 0)
            report_place(&report->singular, &report->first_singular, place);
    }
}

static void refit_records(void *context, uint32_t begin, uint32_t end)
{
    struct refit *refit = context;
    struct builder_report report = {0};
    switch ((enum structure_kind)refit->header->kind) {
    case STRUCTURE_TRIANGLES:
        refit_triangles(refit, begin, end, &report);
        break;
    case STRUCTURE_AABBS:
        refit_aabbs(refit, begin, end, &report);
        break;
    case STRUCTURE_INSTANCES:
        refit_instances(refit, begin, end, &report);
        break;
    }
    pthread_mutex_lock(&refit->lock);
    report_merge(refit->report, &report);
    pthread_mutex_unlock(&refit->lock);
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

enum builder_result builder_refit(const struct builder_input *input, const void *source,
                                  void *structure, uint64_t structure_size, void *scratch,
                                  uint64_t scratch_size, struct builder_report *report)
{
    struct builder_report unread;
    report = report ? report : &unread;
    *report = (struct builder_report){0};
    const struct structure_header *before = source;
    if (!shape_is_same(input, before))
        return BUILDER_INCOMPATIBLE;
    if (structure_size < before->size ||
        scratch_size < (uint64_t)input->geometry_count * sizeof(struct source))
        return BUILDER_TOO_SMALL;
    enum builder_result result = input_open(input, scratch, report);
    if (result != BUILDER_OK)
        return result;
    if (structure != source)
        memcpy(structure, source, before->size);
    fenv_t environment;
    feholdexcept(&environment);
    fesetenv(FE_DFL_ENV);
    struct refit refit = {
        .input = input, .header = structure, .sources = scratch, .report = report};
    run_refit(&refit);
    fesetenv(&environment);
    return report->out_of_range > 0 ? BUILDER_INPUT_OUT_OF_RANGE : BUILDER_OK;
}
