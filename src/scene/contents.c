/* SPDX-License-Identifier: Apache-2.0 */
#include "src/scene/contents.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/bvh/motion.h"
#include "src/view/names.h"

#define TEXT_OF(name, text) text,
const char *const left_out_names[LEFT_OUT] = {LEFT_OUT_LIST(TEXT_OF)};

/* ---- structures */

uint32_t *contents_find_builds(const struct capture *capture, uint32_t command_count)
{
    uint32_t *builds = capture_allocate(NULL, capture->structure_count, sizeof(*builds));
    memset(builds, 0xff, capture->structure_count * sizeof(*builds));
    for (uint32_t i = 0; i < command_count; i++) {
        const struct captured_command *command = &capture->commands[i];
        if (command->dst == CAPTURE_NONE)
            continue;
        if (command->kind == CAPTURE_COMMAND_BUILD)
            builds[command->dst] = i;
        else if (command->kind == CAPTURE_COMMAND_COPY)
            builds[command->dst] =
                command->src == CAPTURE_NONE ? CAPTURE_NONE : builds[command->src];
    }
    return builds;
}

bool contents_is_top(const struct capture *capture, uint32_t command)
{
    const struct captured_command *build = &capture->commands[command];
    return build->kind == CAPTURE_COMMAND_BUILD && build->geometry_count &&
           build->geometries[0].type == CAPTURE_INSTANCES;
}

bool contents_find_top(const struct capture *capture, const uint32_t *builds,
                       uint32_t command_count, const char *wanted, uint32_t *top,
                       struct capture_error *error)
{
    *top = CAPTURE_NONE;
    for (uint32_t i = 0; i < capture->structure_count && wanted; i++) {
        char id[24];
        const struct captured_structure *structure = &capture->structures[i];
        snprintf(id, sizeof(id), "%" PRIu64, structure->id);
        if (builds[i] != CAPTURE_NONE &&
            (strcmp(id, wanted) == 0 || (structure->name && strcmp(structure->name, wanted) == 0)))
            *top = i;
    }
    for (uint32_t i = 0; i < command_count && !wanted; i++)
        if (capture->commands[i].dst != CAPTURE_NONE && contents_is_top(capture, i))
            *top = capture->commands[i].dst;
    if (*top == CAPTURE_NONE && wanted)
        snprintf(error->text, sizeof(error->text),
                 "%s: no structure with that name or id had been built by then", wanted);
    return *top != CAPTURE_NONE || !wanted;
}

/* ---- rows of input data */

struct rows rows_load(struct capture *capture, const struct captured_geometry *geometry,
                      enum capture_role role, struct capture_error *error)
{
    struct rows rows = {.input = capture_input_of(geometry, role)};
    if (!rows.input || rows.input->data == CAPTURE_NONE)
        return rows;
    const struct captured_data *data = &capture->data[rows.input->data];
    rows.bytes = capture_load_data(capture, rows.input->data, error);
    rows.count = rows.bytes ? data->rows : 0;
    rows.size = data->row_size;
    return rows;
}

void rows_release(struct capture *capture, const struct captured_geometry *geometry)
{
    for (uint32_t i = 0; i < geometry->input_count; i++)
        if (geometry->inputs[i].data != CAPTURE_NONE)
            capture_release_data(capture, geometry->inputs[i].data);
}

static const struct vertex_format *find_format(const char *name)
{
    for (int i = 1; name && i <= VK_FORMAT_D32_SFLOAT_S8_UINT; i++) {
        const struct value value = format((VkFormat)i);
        if (value.kind == VALUE_TEXT && strcmp(value.text, name) == 0)
            return vertex_format_find((VkFormat)i);
    }
    return NULL;
}

static uint32_t index_at(const struct rows *rows, uint64_t at)
{
    uint32_t index = 0;
    memcpy(&index, rows->bytes + at * rows->size, rows->size); /* of the lowest bytes */
    return index;
}

bool triangle_rows_load(struct capture *capture, const struct captured_geometry *geometry,
                        struct triangle_rows *triangles, struct capture_error *error)
{
    *triangles = (struct triangle_rows){
        .geometry = geometry,
        .format = find_format(geometry->vertex_format),
        .vertices = rows_load(capture, geometry, CAPTURE_VERTICES, error),
        .indices = rows_load(capture, geometry, CAPTURE_INDICES, error),
        .transform = rows_load(capture, geometry, CAPTURE_TRANSFORM, error),
    };
    const uint64_t known =
        (triangles->indices.input ? triangles->indices.count : triangles->vertices.count) / 3;
    triangles->count = known < geometry->primitive_count ? known : geometry->primitive_count;
    return triangles->format &&
           (!triangles->vertices.count || triangles->vertices.size >= triangles->format->size);
}

bool triangle_rows_find(const struct triangle_rows *triangles, uint64_t corner, uint64_t *row)
{
    const struct captured_geometry *geometry = triangles->geometry;
    const struct captured_input *input = triangles->vertices.input;
    const bool is_indexed = triangles->indices.input;
    if (!triangles->vertices.count || (is_indexed && corner >= triangles->indices.count))
        return false;
    const uint64_t vertex =
        (is_indexed ? index_at(&triangles->indices, corner) : corner) + geometry->first_vertex;
    const unsigned __int128 at =
        (is_indexed ? 0 : geometry->primitive_offset) + (unsigned __int128)vertex * input->stride;
    if (at < input->first || !input->stride)
        return false;
    *row = (uint64_t)((at - input->first) / input->stride);
    return *row < triangles->vertices.count;
}

bool rows_read_instance(const struct rows *rows, uint64_t at, struct placing *placing)
{
    VkAccelerationStructureMotionInstanceNV motion;
    struct motion_instance_record record = {.type = 0};
    struct instance_record first;
    placing->number = (uint32_t)at;
    const uint8_t *row = rows->bytes + at * rows->size;
    if (rows->size == sizeof(placing->instance)) {
        memcpy(&placing->instance, row, sizeof(placing->instance));
        return true;
    }
    memcpy(&motion, row, sizeof(motion));
    record.type = motion.type;
#define TAKE(from)                                                                                 \
    record.base.instance = (VkAccelerationStructureInstanceKHR)                                    \
    {                                                                                              \
        .instanceCustomIndex = (from).instanceCustomIndex, .mask = (from).mask,                    \
        .instanceShaderBindingTableRecordOffset = (from).instanceShaderBindingTableRecordOffset,   \
        .flags = (from).flags,                                                                     \
        .accelerationStructureReference = (from).accelerationStructureReference                    \
    }
    switch ((int)motion.type) {
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV:
        placing->instance = motion.data.staticInstance;
        return true;
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV:
        TAKE(motion.data.matrixMotionInstance);
        record.at.matrix[0] = motion.data.matrixMotionInstance.transformT0;
        record.at.matrix[1] = motion.data.matrixMotionInstance.transformT1;
        break;
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV:
        TAKE(motion.data.srtMotionInstance);
        record.at.srt[0] = motion.data.srtMotionInstance.transformT0;
        record.at.srt[1] = motion.data.srtMotionInstance.transformT1;
        break;
    default:
        return false;
    }
#undef TAKE
    motion_instance_at(&record, 0, &first);
    placing->instance = first.instance;
    return true;
}

enum left_out contents_find_instance(const struct capture *capture, const uint32_t *builds,
                                     const struct captured_command *build,
                                     const struct placing *placing, uint32_t *structure)
{
    const uint64_t address = placing->instance.accelerationStructureReference;
    const float(*m)[4] = placing->instance.transform.matrix;
    if (!address)
        return LEFT_NULL_INSTANCES;
    const struct captured_reference *reference = capture_reference_of(build, address);
    if (reference && reference->is_dead)
        return LEFT_DESTROYED;
    if (!reference || reference->structure == CAPTURE_NONE)
        return LEFT_UNKNOWN;
    *structure = reference->structure;
    for (int i = 0; i < 3; i++)
        if (!isfinite(m[i][0]) || !isfinite(m[i][1]) || !isfinite(m[i][2]) || !isfinite(m[i][3]))
            return NOT_FINITE;
    return builds[*structure] == CAPTURE_NONE || contents_is_top(capture, builds[*structure])
               ? LEFT_NOT_BUILT
               : LEFT_OUT;
}
