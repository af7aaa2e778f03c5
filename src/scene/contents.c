/* SPDX-License-Identifier: Apache-2.0 */
#include "src/scene/contents.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/bvh/motion.h"
#include "src/view/names.h"

enum { BOX_CORNERS = 8, BOX_INDICES = 36 };

#define TEXT_OF(name, text) text,
const char *const left_out_names[LEFT_OUT] = {LEFT_OUT_LIST(TEXT_OF)};

/* ---- structures */

void contents_execute(const struct capture *capture, uint32_t command, uint32_t *builds)
{
    const struct captured_command *executed = &capture->commands[command];
    if (executed->dst == CAPTURE_NONE)
        return;
    if (executed->kind == CAPTURE_COMMAND_BUILD)
        builds[executed->dst] = command;
    else if (executed->kind == CAPTURE_COMMAND_COPY)
        builds[executed->dst] =
            executed->src == CAPTURE_NONE ? CAPTURE_NONE : builds[executed->src];
}

uint32_t *contents_find_builds(const struct capture *capture, uint32_t command_count)
{
    uint32_t *builds = capture_allocate(NULL, capture->structure_count, sizeof(*builds));
    memset(builds, 0xff, capture->structure_count * sizeof(*builds));
    for (uint32_t i = 0; i < command_count; i++)
        contents_execute(capture, i, builds);
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

const struct vertex_format *vertex_format_named(const char *name)
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
        .format = vertex_format_named(geometry->vertex_format),
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

/* ---- meshes */

static uint32_t add_position(struct mesh *mesh, const float position[3])
{
    if (!ARRAY_HAS_ROOM(mesh->positions, mesh->position_count, mesh->position_capacity))
        capture_allocate(NULL, SIZE_MAX, 2);
    memcpy(mesh->positions[mesh->position_count], position, sizeof(*mesh->positions));
    return mesh->position_count++;
}

static void add_index(struct mesh *mesh, uint32_t index)
{
    if (!ARRAY_HAS_ROOM(mesh->indices, mesh->index_count, mesh->index_capacity))
        capture_allocate(NULL, SIZE_MAX, 2);
    mesh->indices[mesh->index_count++] = index;
}

static bool is_finite(const float position[3])
{
    return isfinite(position[0]) && isfinite(position[1]) && isfinite(position[2]);
}

static void transform(const float matrix[12], float position[3])
{
    const double x = position[0], y = position[1], z = position[2];
    for (int i = 0; i < 3; i++)
        position[i] = (float)(matrix[4 * i] * x + matrix[4 * i + 1] * y + matrix[4 * i + 2] * z +
                              matrix[4 * i + 3]);
}

/* Adds a triangle to the mesh, or returns why it is left out. */
/* `places` has the position of each row, once it is in the mesh. */
static enum left_out add_triangle(const struct triangle_rows *triangles, uint32_t *places,
                                  struct mesh *mesh, uint64_t primitive)
{
    float positions[3][3];
    uint64_t rows[3];
    for (uint32_t i = 0; i < 3; i++) {
        if (!triangle_rows_find(triangles, 3 * primitive + i, &rows[i]))
            return NOT_IN_CAPTURE;
        triangles->format->read(triangles->vertices.bytes + rows[i] * triangles->vertices.size,
                                positions[i]);
    }
    if (isnan(positions[0][0]) || isnan(positions[1][0]) || isnan(positions[2][0]))
        return INACTIVE_PRIMITIVES;
    for (int i = 0; i < 3; i++) {
        if (triangles->transform.count) {
            float matrix[12];
            memcpy(matrix, triangles->transform.bytes, sizeof(matrix));
            transform(matrix, positions[i]);
        }
        if (!is_finite(positions[i]))
            return NOT_FINITE;
    }
    for (int i = 0; i < 3; i++) {
        uint32_t *place = &places[rows[i]];
        if (*place == CAPTURE_NONE)
            *place = add_position(mesh, positions[i]);
        add_index(mesh, *place);
    }
    return LEFT_OUT;
}

static enum left_out add_box(const struct rows *boxes, struct mesh *mesh, uint64_t primitive)
{
    static const uint8_t faces[BOX_INDICES] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6,
                                               0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3,
                                               0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    float box[2][3];
    if (primitive >= boxes->count)
        return NOT_IN_CAPTURE;
    memcpy(box, boxes->bytes + primitive * sizeof(box), sizeof(box));
    if (isnan(box[0][0]))
        return INACTIVE_PRIMITIVES;
    if (!is_finite(box[0]) || !is_finite(box[1]))
        return NOT_FINITE;
    const uint32_t first = mesh->position_count;
    for (int i = 0; i < BOX_CORNERS; i++)
        add_position(mesh, (const float[]){box[i & 1][0], box[i >> 1 & 1][1], box[i >> 2][2]});
    for (int i = 0; i < BOX_INDICES; i++)
        add_index(mesh, first + faces[i]);
    return LEFT_OUT;
}

struct mesh mesh_read(struct capture *capture, const struct captured_geometry *geometry,
                      uint64_t left_out[LEFT_OUT], struct capture_error *error)
{
    const bool has_boxes = geometry->type == CAPTURE_AABBS;
    struct mesh mesh = {.each = has_boxes ? BOX_INDICES : 3};
    struct triangle_rows triangles = {.count = 0};
    struct rows boxes = {.bytes = NULL};
    uint64_t count; /* primitives that have data */
    uint32_t *places = NULL;
    if (geometry->type == CAPTURE_TRIANGLES &&
        triangle_rows_load(capture, geometry, &triangles, error)) {
        count = triangles.count;
    } else if (has_boxes) {
        boxes = rows_load(capture, geometry, CAPTURE_BOXES, error);
        count = boxes.count < geometry->primitive_count ? boxes.count : geometry->primitive_count;
    } else {
        left_out[OTHER_GEOMETRIES]++;
        return mesh;
    }
    left_out[NOT_IN_CAPTURE] += geometry->primitive_count - count;
    if (triangles.vertices.count) {
        places = capture_allocate(NULL, triangles.vertices.count, sizeof(*places));
        memset(places, 0xff, triangles.vertices.count * sizeof(*places));
    }
    for (uint32_t i = 0; i < count; i++) {
        const enum left_out why =
            has_boxes ? add_box(&boxes, &mesh, i) : add_triangle(&triangles, places, &mesh, i);
        if (why != LEFT_OUT) {
            left_out[why]++;
            continue;
        }
        if (!ARRAY_HAS_ROOM(mesh.primitives, mesh.primitive_count, mesh.primitive_capacity))
            capture_allocate(NULL, SIZE_MAX, 2);
        mesh.primitives[mesh.primitive_count++] = i;
    }
    free(places);
    rows_release(capture, geometry);
    return mesh;
}

void mesh_release(struct mesh *mesh)
{
    free(mesh->positions);
    free(mesh->indices);
    free(mesh->primitives);
}

/* ---- instances */

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

struct placing *contents_read_instances(struct capture *capture, const uint32_t *builds,
                                        const struct captured_command *build, uint32_t *count,
                                        uint64_t left_out[LEFT_OUT], struct capture_error *error)
{
    const struct captured_geometry *geometry = &build->geometries[0];
    const struct rows rows = rows_load(capture, geometry, CAPTURE_INSTANCE_ROWS, error);
    const uint64_t asked = geometry->primitive_count,
                   known = rows.count < asked ? rows.count : asked;
    struct placing *placings = capture_allocate(NULL, known, sizeof(*placings));
    *count = 0;
    left_out[NOT_IN_CAPTURE] += asked - known;
    for (uint64_t i = 0; i < known; i++) {
        struct placing *placing = &placings[*count];
        const enum left_out why =
            rows_read_instance(&rows, i, placing)
                ? contents_find_instance(capture, builds, build, placing, &placing->structure)
                : LEFT_UNKNOWN;
        if (why == LEFT_OUT)
            ++*count;
        else
            left_out[why]++;
    }
    rows_release(capture, geometry);
    return placings;
}
