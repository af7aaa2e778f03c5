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

/* How many records ahead indices and vertices are asked for. */
#define AHEAD_INDICES 32
#define AHEAD_VERTICES 16

static void prefetch(const struct structure_header *header, const struct source *sources,
                     uint32_t index)
{
    const struct triangle_record *records = structure_records(header);
    if (index + AHEAD_INDICES < header->record_count) {
        const struct triangle_record *record = &records[index + AHEAD_INDICES];
        source_prefetch_indices(&sources[record->geometry], record->primitive);
    }
    if (index + AHEAD_VERTICES < header->record_count) {
        const struct triangle_record *record = &records[index + AHEAD_VERTICES];
        source_prefetch_vertices(&sources[record->geometry], record->primitive);
    }
}

/* A primitive that isn't active any more, or can't be read, keeps what it had. */
static void refit_triangles(const struct structure_header *header, const struct source *sources,
                            struct builder_report *report)
{
    struct triangle_record *records = structure_records(header);
    for (uint32_t i = 0; i < header->record_count; i++) {
        prefetch(header, sources, i);
        struct triangle_record *record = &records[i], fresh = *record;
        enum source_state found =
            source_triangle(&sources[record->geometry], record->primitive, &fresh);
        if (found == SOURCE_ACTIVE)
            *record = fresh;
        else
            report_state(report, found,
                         (struct builder_place){record->geometry, record->primitive});
    }
}

static void refit_aabbs(const struct structure_header *header, const struct source *sources,
                        struct builder_report *report)
{
    struct aabb_record *records = structure_records(header);
    for (uint32_t i = 0; i < header->record_count; i++) {
        struct aabb_record *record = &records[i], fresh = *record;
        enum source_state found =
            source_aabb(&sources[record->geometry], record->primitive, &fresh);
        if (found == SOURCE_ACTIVE)
            *record = fresh;
        else
            report_state(report, found,
                         (struct builder_place){record->geometry, record->primitive});
    }
}

static void refit_instances(const struct builder_input *input,
                            const struct structure_header *header, const struct source *sources,
                            struct builder_report *report)
{
    struct instance_record *records = structure_records(header);
    for (uint32_t i = 0; i < header->record_count; i++) {
        struct instance_record *record = &records[i], fresh = *record;
        enum source_state found =
            source_instance(sources, record->primitive, &input->memory, &fresh);
        struct builder_place place = {0, record->primitive};
        uint64_t reference = fresh.instance.accelerationStructureReference;
        if (found == SOURCE_ACTIVE && !input->resolver.find(input->resolver.context, reference))
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

static void refit_records(const struct builder_input *input, struct structure_header *header,
                          const struct source *sources, struct builder_report *report)
{
    switch ((enum structure_kind)header->kind) {
    case STRUCTURE_TRIANGLES:
        refit_triangles(header, sources, report);
        break;
    case STRUCTURE_AABBS:
        refit_aabbs(header, sources, report);
        break;
    case STRUCTURE_INSTANCES:
        refit_instances(input, header, sources, report);
        break;
    }
    report->active = header->record_count - report->inactive;
    bounds_update(header, &input->resolver);
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
    refit_records(input, structure, scratch, report);
    fesetenv(&environment);
    return report->out_of_range > 0 ? BUILDER_INPUT_OUT_OF_RANGE : BUILDER_OK;
}
