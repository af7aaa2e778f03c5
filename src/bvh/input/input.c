/* SPDX-License-Identifier: Apache-2.0 */
/* The input of a build as a whole. */
#include "src/bvh/input/input.h"

static bool displacement_is_known(const struct builder_displacement *displacement)
{
    return source_index_is_known(displacement->index_type) &&
           (!displacement->micromap || vertex_format_find(displacement->vector_format)) &&
           (!displacement->biases_and_scales ||
            vertex_format_find(displacement->bias_and_scale_format));
}

static bool triangles_are_known(const struct builder_triangles *triangles)
{
    return vertex_format_find(triangles->vertex_format) &&
           source_index_is_known(triangles->index_type) &&
           (!triangles->opacity || source_index_is_known(triangles->opacity->index_type)) &&
           (!triangles->displacement || displacement_is_known(triangles->displacement));
}

static bool is_displaced(const struct builder_input *input)
{
    for (uint32_t i = 0; i < input->geometry_count; i++)
        if (input->geometries[i].type == VK_GEOMETRY_TYPE_TRIANGLES_KHR &&
            input->geometries[i].triangles.displacement)
            return true;
    return false;
}

static bool geometry_is_known(const struct builder_geometry *geometry, VkGeometryTypeKHR type)
{
    if (geometry->type != type)
        return false;
    switch ((int)type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        return triangles_are_known(&geometry->triangles);
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        return !geometry->dense.opacity ||
               source_index_is_known(geometry->dense.opacity->index_type);
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        return sphere_formats_are_known(&geometry->spheres);
    default:
        return true;
    }
}

/* A BLAS without geometries has kind STRUCTURE_TRIANGLES. */
enum builder_result input_kind(const struct builder_input *input, enum structure_kind *kind)
{
    VkGeometryTypeKHR type =
        input->geometry_count > 0 ? input->geometries[0].type : VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    bool is_top = input->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    if (is_top && input->geometry_count == 0)
        type = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    if (is_top != (type == VK_GEOMETRY_TYPE_INSTANCES_KHR))
        return BUILDER_UNKNOWN_FORMAT;
    bool has_motion = input->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    switch ((int)type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        *kind = has_motion ? STRUCTURE_MOTION_TRIANGLES : STRUCTURE_TRIANGLES;
        if (is_displaced(input))
            *kind = has_motion ? STRUCTURE_MOTION_DISPLACED : STRUCTURE_DISPLACED;
        break;
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        *kind = STRUCTURE_AABBS;
        break;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        *kind = STRUCTURE_DENSE;
        break;
    case VK_GEOMETRY_TYPE_SPHERES_NV:
        *kind = STRUCTURE_SPHERES;
        break;
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        *kind = STRUCTURE_SWEPT_SPHERES;
        break;
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        *kind = has_motion ? STRUCTURE_MOTION_INSTANCES : STRUCTURE_INSTANCES;
        break;
    default:
        return BUILDER_UNKNOWN_FORMAT;
    }
    for (uint32_t i = 0; i < input->geometry_count; i++)
        if (!geometry_is_known(&input->geometries[i], type))
            return BUILDER_UNKNOWN_FORMAT;
    return BUILDER_OK;
}

static enum builder_result count_geometry(const struct builder_input *input,
                                          enum structure_kind kind, uint32_t geometry,
                                          uint32_t primitives, struct input_counts *found)
{
    if (!structure_is_displaced(kind)) {
        found->primitives += primitives;
        return BUILDER_OK;
    }
    enum builder_result result = displaced_count(input->geometries[geometry].triangles.displacement,
                                                 primitives, &found->displaced);
    found->primitives = found->displaced.parts;
    return result;
}

enum builder_result input_count(const struct builder_input *input, enum structure_kind kind,
                                const uint32_t *counts, struct input_counts *found)
{
    *found = (struct input_counts){0};
    for (uint32_t i = 0; i < input->geometry_count; i++) {
        enum builder_result result = count_geometry(
            input, kind, i, counts ? counts[i] : input->ranges[i].primitiveCount, found);
        if (result != BUILDER_OK)
            return result;
    }
    return found->primitives > BUILDER_MAX_PRIMITIVES ? BUILDER_TOO_MANY_PRIMITIVES : BUILDER_OK;
}

uint64_t input_lay_out(const struct builder_input *input, enum structure_kind kind,
                       const struct input_counts *counts, void *scratch,
                       struct input_tables *tables)
{
    struct scratch_cursor cursor = {(uintptr_t)scratch, 0};
    *tables = (struct input_tables){0};
    tables->sources = scratch_take(&cursor, input->geometry_count, sizeof(*tables->sources));
    if (kind == STRUCTURE_DENSE)
        tables->dense = scratch_take(&cursor, counts->primitives, sizeof(*tables->dense));
    if (!structure_is_displaced(kind))
        return cursor.used;
    struct displaced_room *room = &tables->displaced;
    room->left = counts->displaced;
    room->bases = scratch_take(&cursor, room->left.bases, sizeof(*room->bases));
    room->points = scratch_take(&cursor, room->left.points, sizeof(*room->points));
    if (kind == STRUCTURE_MOTION_DISPLACED)
        room->motion_points = scratch_take(&cursor, room->left.points, sizeof(*room->points));
    return cursor.used;
}

static enum builder_result out_of_range(struct builder_report *report, uint32_t geometry,
                                        uint32_t primitive)
{
    report->out_of_range = 1;
    report->first_out_of_range = (struct builder_place){geometry, primitive};
    return BUILDER_INPUT_OUT_OF_RANGE;
}

enum builder_result input_open(const struct builder_input *input, enum structure_kind kind,
                               const struct input_tables *tables, struct builder_report *report)
{
    bool has_motion = input->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    struct displaced_room room = tables->displaced;
    uint32_t first = 0;
    for (uint32_t i = 0; i < input->geometry_count; i++) {
        const struct builder_geometry *geometry = &input->geometries[i];
        struct source *source = &tables->sources[i];
        uint32_t primitive;
        source->first = first;
        if (!source_open(source, has_motion, geometry, &input->ranges[i]))
            return out_of_range(report, i, 0);
        if (source->has_transform)
            report->transformed += 3ull * source->count;
        if (kind == STRUCTURE_DENSE) {
            source->dense = tables->dense + first;
            dense_decode(&geometry->dense, source->count, tables->dense + first);
        }
        if (structure_is_displaced(kind) &&
            !displaced_cut(source, geometry->triangles.displacement, input->ranges[i].firstVertex,
                           &input->micromaps, &room, &primitive))
            return out_of_range(report, i, primitive);
        first += source->count;
    }
    return BUILDER_OK;
}

static const struct builder_opacity *opacity_of(const struct builder_geometry *geometry)
{
    switch ((int)geometry->type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        return geometry->triangles.opacity;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        return geometry->dense.opacity;
    default:
        return NULL;
    }
}

bool input_has_micromaps(const struct builder_input *input)
{
    for (uint32_t i = 0; i < input->geometry_count; i++)
        if (opacity_of(&input->geometries[i]))
            return true;
    return false;
}

void input_write_micromaps(const struct builder_input *input, struct structure_header *header)
{
    uint64_t *references = structure_micromaps(header);
    for (uint32_t i = 0; i < header->micromap_count; i++) {
        const struct builder_opacity *opacity = opacity_of(&input->geometries[i]);
        references[i] = opacity ? opacity->micromap : 0;
    }
}
