/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of spheres and linear swept spheres. */
#include "src/base/chain.h"

#include "src/check/assemble/extended.h"
#include "src/check/assemble/views.h"
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/model/inputs.h"

/* Copies the spheres of a geometry from the structure that its chain has. */
static void copy_found(const VkAccelerationStructureGeometryKHR *geometry, const void *found,
                       struct chained_input *copy)
{
    if (type_is_swept_spheres(geometry->geometryType))
        copy->spheres = *(const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *)found;
    else
        copy->spheres = spheres_as_swept(found);
}

static VkStructureType type_of_spheres(const VkAccelerationStructureGeometryKHR *geometry)
{
    return type_is_swept_spheres(geometry->geometryType)
               ? VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_LINEAR_SWEPT_SPHERES_DATA_NV
               : VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV;
}

/* A build without primitives reads nothing. */
static bool is_unreadable(struct check_context *context, const struct geometry_view *geometry,
                          const void *address)
{
    uint32_t count;
    return address && view_primitive_count(geometry->build, geometry->index, &count) && count &&
           !host_memory_is_there(context, address, 1);
}

void view_sphere_addresses(struct check_context *context, struct geometry_view *geometry,
                           struct sphere_data *data)
{
    const bool has_indices = index_type_size(data->chained.spheres.indexType) != 0;
    const enum input_role first = data->is_swept ? INPUT_SWEPT_VERTEX : INPUT_SPHERE_VERTEX;
    const enum input_role end = first + (has_indices ? 3 : 2);
    for (enum input_role role = first; role < end; role++) {
        const VkDeviceOrHostAddressConstKHR address =
            *input_place(geometry->geometry, &data->chained, role);
        if (geometry->build->call->command != COMMAND_HOST) {
            if (context->level >= LEVEL_STATE)
                chained_input(context, geometry, role, address.deviceAddress);
        } else if (is_unreadable(context, geometry, address.hostAddress)) {
            data->unreadable |= 1U << role;
        }
    }
}

void view_sphere_formats(struct check_context *context, struct sphere_data *data)
{
    const struct check_hooks *hooks = context->hooks;
    data->vertex_format_supported =
        hooks->vertex_format_supported(context->user, data->chained.spheres.vertexFormat);
    data->radius_format_supported =
        hooks->radius_format_supported(context->user, data->chained.spheres.radiusFormat);
}

void view_spheres(const struct geometry_view *geometry, struct sphere_data *data)
{
    const VkAccelerationStructureGeometryKHR *given = geometry->geometry;
    const void *found = chain_member(given->pNext, &geometry->chain, type_of_spheres(given));
    *data = (struct sphere_data){.geometry = geometry,
                                 .is_swept = type_is_swept_spheres(given->geometryType),
                                 .given = found,
                                 .missing = !found && extended_data_is_missing(geometry)};
    if (found)
        copy_found(given, found, &data->chained);
}

bool spheres_are_well_formed(const VkAccelerationStructureGeometryKHR *geometry)
{
    const void *found = chain_find(geometry->pNext, type_of_spheres(geometry));
    struct chained_input copy;
    if (!found)
        return false;
    copy_found(geometry, found, &copy);
    return format_is_known(copy.spheres.vertexFormat) &&
           format_is_known(copy.spheres.radiusFormat) &&
           (index_type_size(copy.spheres.indexType) ||
            copy.spheres.indexType == VK_INDEX_TYPE_NONE_KHR);
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
