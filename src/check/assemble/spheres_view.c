/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of spheres and linear swept spheres. */
#include "src/base/chain.h"

#include "src/check/assemble/extended.h"
#include "src/check/assemble/views.h"
#include "src/model/formats.h"
#include "src/model/geometry.h"

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
    if (type_is_spheres(geometry->geometry->geometryType)) {
        const VkAccelerationStructureGeometrySpheresDataNV *s =
            chain_member(chain, &geometry->chain, spheres_type);
        if (s)
            view->data = (struct sphere_data){COMMON_MEMBERS(s)};
    } else if (type_is_swept_spheres(geometry->geometry->geometryType)) {
        const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *s =
            chain_member(chain, &geometry->chain, swept_type);
        if (s)
            *view = (struct swept_spheres_view){.data = {COMMON_MEMBERS(s)},
                                                .indexing_mode = s->indexingMode,
                                                .end_caps_mode = s->endCapsMode};
    }
    view->data.geometry = geometry;
}

static bool members_are_well_formed(const struct sphere_data *data)
{
    return format_is_known(data->vertex_format) && format_is_known(data->radius_format) &&
           (has_indices(data) || data->index_type == VK_INDEX_TYPE_NONE_KHR);
}

bool spheres_are_well_formed(const VkAccelerationStructureGeometryKHR *geometry)
{
    if (type_is_spheres(geometry->geometryType)) {
        const VkAccelerationStructureGeometrySpheresDataNV *s =
            chain_find(geometry->pNext, spheres_type);
        return s && members_are_well_formed(&(struct sphere_data){COMMON_MEMBERS(s)});
    }
    const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *s =
        chain_find(geometry->pNext, swept_type);
    return s && members_are_well_formed(&(struct sphere_data){COMMON_MEMBERS(s)});
}

/* ---- all geometries of extensions */

bool extended_geometry_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkGeometryTypeKHR type = geometry->geometryType;
    if (type_is_spheres(type) || type_is_swept_spheres(type))
        return spheres_are_well_formed(geometry);
    if (type_is_micromap(type))
        return micromap_is_well_formed(geometry);
    return type_is_dense(type) && dense_is_well_formed(geometry);
}

bool extended_data_is_missing(const struct geometry_view *geometry)
{
    const struct chain_facts *chain = &geometry->chain;
    return !chain->unreadable && !chain->has_duplicate && !chain->has_stray &&
           !geometry->build->call->device->newer_than_registry;
}

const struct address_facts *chained_input(struct check_context *context,
                                          struct geometry_view *geometry, enum input_role role,
                                          VkDeviceAddress address)
{
    struct chained_inputs *chained = geometry->chained;
    uint32_t i = chained->count++;
    chained->items[i].role = role;
    chained->items[i].facts = (struct address_facts){.status = ADDRESS_UNKNOWN};
    if (!geometry_is_empty(geometry))
        resources_look_up_address(context->resources, address, &chained->items[i].facts);
    return &chained->items[i].facts;
}

/* ---- dense geometry */

static const VkStructureType dense_type =
    VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX;

bool dense_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *data =
        chain_find(geometry->pNext, dense_type);
    return data && dense_format_is_known(data->format);
}

bool dense_triangle_count(const VkAccelerationStructureGeometryKHR *geometry, uint32_t *count)
{
    const VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *data =
        type_is_dense(geometry->geometryType) ? chain_find(geometry->pNext, dense_type) : NULL;
    if (data)
        *count = data->numTriangles;
    return data != NULL;
}
