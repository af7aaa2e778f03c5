/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the addresses of a geometry's inputs. */
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/formats.h"
#include "src/view/geometry_data.h"
#include "src/view/phrases.h"

const char *input_field(enum input_role role)
{
    switch (role) {
    case INPUT_VERTEX:
        return "geometry.triangles.vertexData.deviceAddress";
    case INPUT_INDEX:
        return "geometry.triangles.indexData.deviceAddress";
    case INPUT_MATRIX:
        return "geometry.triangles.transformData.deviceAddress";
    case INPUT_AABBS:
        return "geometry.aabbs.data.deviceAddress";
    case INPUT_INSTANCES:
        return "geometry.instances.data.deviceAddress";
    case INPUT_MOTION_VERTEX:
        return MOTION_DATA "vertexData.deviceAddress";
    case INPUT_SPHERE_VERTEX:
        return SPHERES_DATA "vertexData.deviceAddress";
    case INPUT_SPHERE_RADIUS:
        return SPHERES_DATA "radiusData.deviceAddress";
    case INPUT_SPHERE_INDEX:
        return SPHERES_DATA "indexData.deviceAddress";
    case INPUT_SWEPT_VERTEX:
        return SWEPT_DATA "vertexData.deviceAddress";
    case INPUT_SWEPT_RADIUS:
        return SWEPT_DATA "radiusData.deviceAddress";
    case INPUT_SWEPT_INDEX:
        return SWEPT_DATA "indexData.deviceAddress";
    case INPUT_MICROMAP_DATA:
        return MICROMAP_DATA "data";
    case INPUT_MICROMAP_TRIANGLES:
        return MICROMAP_DATA "triangleArray";
    case INPUT_OPACITY_INDEX:
        return OPACITY_DATA "indexBuffer";
    case INPUT_OPACITY_EXT_INDEX:
        return OPACITY_EXT_DATA "indexBuffer.deviceAddress";
    case INPUT_DENSE_DATA:
        return DENSE_DATA "compressedData.deviceAddress";
    case INPUT_INDIRECT:
        return "pIndirectDeviceAddresses";
    case INPUT_SCRATCH:
    case INPUT_UPDATE_SCRATCH:
        break;
    }
    return "scratchData.deviceAddress";
}

static const char *nv_data_field(enum input_role role)
{
    switch ((int)role) {
    case INPUT_MATRIX:
        return "geometry.triangles.transformData";
    case INPUT_AABBS:
        return "geometry.aabbs.aabbData";
    default:
        return "instanceData";
    }
}

static const char *input_data_field(enum build_command command, enum input_role role)
{
    if (command == COMMAND_NV)
        return nv_data_field(role);
    if (command != COMMAND_HOST)
        return input_field(role);
    switch ((int)role) {
    case INPUT_MATRIX:
        return "geometry.triangles.transformData.hostAddress";
    case INPUT_AABBS:
        return "geometry.aabbs.data.hostAddress";
    case INPUT_INSTANCES:
        return "geometry.instances.data.hostAddress";
    case INPUT_SPHERE_RADIUS:
        return SPHERES_DATA "radiusData.hostAddress";
    case INPUT_SWEPT_RADIUS:
        return SWEPT_DATA "radiusData.hostAddress";
    default:
        return input_field(role);
    }
}

bool vertex_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles ||
           input_is_given(geometry, finding, "geometry.triangles.vertexData.deviceAddress",
                          triangles->vertexData.deviceAddress);
}

bool vertex_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || address_is_aligned(finding, "geometry.triangles.vertexData.deviceAddress",
                                            triangles->vertexData.deviceAddress,
                                            format_alignment(triangles->vertexFormat));
}

bool index_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || !index_type_size(triangles->indexType) ||
           input_is_given(geometry, finding, "geometry.triangles.indexData.deviceAddress",
                          triangles->indexData.deviceAddress);
}

bool index_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || address_is_aligned(finding, "geometry.triangles.indexData.deviceAddress",
                                            triangles->indexData.deviceAddress,
                                            index_type_size(triangles->indexType));
}

bool transform_address_is_valid(const struct geometry_view *geometry, struct finding *finding)
{
    return geometry->transform.status != ADDRESS_NOWHERE ||
           violated(finding, "geometry.triangles.transformData.deviceAddress",
                    "{} is not 0, and is in no buffer whose address was retrieved",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, geometry->transform.address));
}

bool transform_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles ||
           address_is_aligned(finding, "geometry.triangles.transformData.deviceAddress",
                              triangles->transformData.deviceAddress, 16);
}

bool aabb_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry->geometry);
    return !aabbs || input_is_given(geometry, finding, "geometry.aabbs.data.deviceAddress",
                                    aabbs->data.deviceAddress);
}

bool aabb_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry->geometry);
    return !aabbs || address_is_aligned(finding, "geometry.aabbs.data.deviceAddress",
                                        aabbs->data.deviceAddress, 8);
}

bool instance_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        instances_in(geometry->geometry);
    return !instances || input_is_given(geometry, finding, "geometry.instances.data.deviceAddress",
                                        instances->data.deviceAddress);
}

bool instance_array_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        instances_in(geometry->geometry);
    return !instances || instances->arrayOfPointers ||
           address_is_aligned(finding, "geometry.instances.data.deviceAddress",
                              instances->data.deviceAddress, 16);
}

bool instance_pointers_are_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        instances_in(geometry->geometry);
    return !instances || !instances->arrayOfPointers ||
           address_is_aligned(finding, "geometry.instances.data.deviceAddress",
                              instances->data.deviceAddress, 8);
}

const char *content_field(const struct geometry_view *geometry, enum input_role role)
{
    return input_data_field(geometry->build->call->command, role);
}
