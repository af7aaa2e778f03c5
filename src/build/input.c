/* SPDX-License-Identifier: Apache-2.0 */
/* A build's input as a whole. */
#include "build/input.h"

#include "build/dense.h"

static bool triangles_are_known(const struct builder_triangles *triangles)
{
    return vertex_format_find(triangles->vertex_format) &&
           source_index_is_known(triangles->index_type) &&
           (!triangles->opacity || source_index_is_known(triangles->opacity->index_type));
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

/* A bottom level without geometries is one of triangles without triangles. */
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

enum builder_result input_open(const struct builder_input *input, struct source *sources,
                               struct dense_triangle *dense, struct builder_report *report)
{
    bool has_motion = input->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    uint32_t first = 0;
    for (uint32_t i = 0; i < input->geometry_count; i++) {
        sources[i].first = first;
        if (!source_open(&sources[i], has_motion, &input->geometries[i], &input->ranges[i])) {
            report->out_of_range = 1;
            report->first_out_of_range = (struct builder_place){i, 0};
            return BUILDER_INPUT_OUT_OF_RANGE;
        }
        if (input->geometries[i].type == VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX) {
            sources[i].dense = dense + first;
            dense_decode(&input->geometries[i].dense, sources[i].count, dense + first);
        }
        first += sources[i].count;
        if (sources[i].has_transform)
            report->transformed += 3ull * sources[i].count;
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
