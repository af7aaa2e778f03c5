/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of spheres and linear swept spheres. */
#include "src/base/chain.h"
#include "src/check/assemble/chains.h"
#include "src/check/assemble/extended.h"
#include "src/check/assemble/host_memory.h"
#include "src/check/assemble/views.h"
#include "src/view/formats.h"
#include "src/view/geometry_data.h"

static const VkStructureType spheres_type =
    VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV;
static const VkStructureType swept_type =
    VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_LINEAR_SWEPT_SPHERES_DATA_NV;

#define COMMON_MEMBERS(s)                                                                          \
    .given = true, .vertex_format = (s)->vertexFormat, .radius_format = (s)->radiusFormat,         \
    .vertex_stride = (s)->vertexStride, .radius_stride = (s)->radiusStride,                        \
    .index_stride = (s)->indexStride, .index_type = (s)->indexType, .vertices = (s)->vertexData,   \
    .radii = (s)->radiusData, .indices = (s)->indexData

/* A build without primitives reads nothing. */
static bool is_unreadable(struct check_context *context, const struct geometry_view *geometry,
                          const void *address)
{
    uint32_t count;
    return address && view_primitive_count(geometry->build, geometry->index, &count) && count &&
           !host_memory_is_there(context, address, 1);
}

static bool has_indices(const struct sphere_data *data)
{
    return index_type_size(data->index_type) != 0;
}

void view_sphere_addresses(struct check_context *context, struct geometry_view *geometry,
                           bool is_swept, struct sphere_data *data)
{
    if (geometry->build->call->command == COMMAND_HOST) {
        data->vertices_unreadable = is_unreadable(context, geometry, data->vertices.hostAddress);
        data->radii_unreadable = is_unreadable(context, geometry, data->radii.hostAddress);
        data->indices_unreadable =
            has_indices(data) && is_unreadable(context, geometry, data->indices.hostAddress);
    } else if (context->level >= LEVEL_STATE) {
        chained_input(context, geometry, is_swept ? INPUT_SWEPT_VERTEX : INPUT_SPHERE_VERTEX,
                      data->vertices.deviceAddress);
        chained_input(context, geometry, is_swept ? INPUT_SWEPT_RADIUS : INPUT_SPHERE_RADIUS,
                      data->radii.deviceAddress);
        if (has_indices(data))
            chained_input(context, geometry, is_swept ? INPUT_SWEPT_INDEX : INPUT_SPHERE_INDEX,
                          data->indices.deviceAddress);
    }
}

void view_sphere_formats(struct check_context *context, struct sphere_data *data)
{
    data->vertex_format_supported =
        context->hooks->vertex_format_supported(context->user, data->vertex_format);
    data->radius_format_supported =
        context->hooks->radius_format_supported(context->user, data->radius_format);
}

void view_spheres(const struct geometry_view *geometry, struct swept_spheres_view *view)
{
    const void *chain = geometry->geometry->pNext;
    *view = (struct swept_spheres_view){.data.missing = extended_data_is_missing(geometry)};
    if (geometry->geometry->geometryType == VK_GEOMETRY_TYPE_SPHERES_NV) {
        const VkAccelerationStructureGeometrySpheresDataNV *s =
            chain_member(chain, &geometry->chain, spheres_type);
        if (s)
            view->data = (struct sphere_data){COMMON_MEMBERS(s)};
    } else if (geometry->geometry->geometryType == VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV) {
        const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *s =
            chain_member(chain, &geometry->chain, swept_type);
        if (s)
            *view = (struct swept_spheres_view){.data = {COMMON_MEMBERS(s)},
                                                .indexing_mode = s->indexingMode,
                                                .end_caps_mode = s->endCapsMode};
    }
    view->data.geometry = geometry;
}

void view_chained_spheres(const struct geometry_view *geometry,
                          const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *chained,
                          struct swept_spheres_view *view)
{
    *view = (struct swept_spheres_view){0};
    if (chained->sType)
        *view = (struct swept_spheres_view){.data = {COMMON_MEMBERS(chained)},
                                            .indexing_mode = chained->indexingMode,
                                            .end_caps_mode = chained->endCapsMode};
    view->data.geometry = geometry;
}

static bool members_are_well_formed(const struct sphere_data *data)
{
    return format_is_known(data->vertex_format) && format_is_known(data->radius_format) &&
           (has_indices(data) || data->index_type == VK_INDEX_TYPE_NONE_KHR);
}

bool spheres_are_well_formed(const VkAccelerationStructureGeometryKHR *geometry)
{
    if (geometry->geometryType == VK_GEOMETRY_TYPE_SPHERES_NV) {
        const VkAccelerationStructureGeometrySpheresDataNV *s =
            chain_find(geometry->pNext, spheres_type);
        return s && members_are_well_formed(&(struct sphere_data){COMMON_MEMBERS(s)});
    }
    const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *s =
        chain_find(geometry->pNext, swept_type);
    return s && members_are_well_formed(&(struct sphere_data){COMMON_MEMBERS(s)});
}
