/* SPDX-License-Identifier: Apache-2.0 */
/* Functions for all geometries of extensions, and for the compressed triangles of dense
 * geometry. */
#include "src/check/assemble/extended.h"

#include "src/base/chain.h"
#include "src/state/builds/build_info.h"
#include "src/view/geometry_data.h"

bool extended_geometry_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry)
{
    switch ((int)geometry->geometryType) {
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        return spheres_are_well_formed(geometry);
    case VK_GEOMETRY_TYPE_MICROMAP_KHR:
        return micromap_is_well_formed(geometry);
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        return dense_is_well_formed(geometry);
    default:
        return false;
    }
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
        geometry_is_dense(geometry) ? chain_find(geometry->pNext, dense_type) : NULL;
    if (data)
        *count = data->numTriangles;
    return data != NULL;
}
