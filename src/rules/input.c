/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the addresses of a geometry's inputs. */
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/phrases.h"

const char *input_field(enum input_role role)
{
    return input_name(role, INPUT_OF_DEVICE);
}

bool vertex_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || input_is_given(geometry, finding, input_field(INPUT_VERTEX),
                                        triangles->vertexData.deviceAddress);
}

bool vertex_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || address_is_aligned(finding, input_field(INPUT_VERTEX),
                                            triangles->vertexData.deviceAddress,
                                            format_alignment(triangles->vertexFormat));
}

bool index_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || !index_type_size(triangles->indexType) ||
           input_is_given(geometry, finding, input_field(INPUT_INDEX),
                          triangles->indexData.deviceAddress);
}

bool index_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles ||
           address_is_aligned(finding, input_field(INPUT_INDEX), triangles->indexData.deviceAddress,
                              index_type_size(triangles->indexType));
}

bool transform_address_is_valid(const struct geometry_view *geometry, struct finding *finding)
{
    return geometry->transform.status != ADDRESS_NOWHERE ||
           violated(finding, input_field(INPUT_MATRIX),
                    "{} is not 0, and is in no buffer whose address was retrieved",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, geometry->transform.address));
}

bool transform_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || address_is_aligned(finding, input_field(INPUT_MATRIX),
                                            triangles->transformData.deviceAddress, 16);
}

bool aabb_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry->geometry);
    return !aabbs ||
           input_is_given(geometry, finding, input_field(INPUT_AABBS), aabbs->data.deviceAddress);
}

bool aabb_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry->geometry);
    return !aabbs ||
           address_is_aligned(finding, input_field(INPUT_AABBS), aabbs->data.deviceAddress, 8);
}

bool instance_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        instances_in(geometry->geometry);
    return !instances || input_is_given(geometry, finding, input_field(INPUT_INSTANCES),
                                        instances->data.deviceAddress);
}

bool instance_array_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        instances_in(geometry->geometry);
    return !instances || instances->arrayOfPointers ||
           address_is_aligned(finding, input_field(INPUT_INSTANCES), instances->data.deviceAddress,
                              16);
}

bool instance_pointers_are_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        instances_in(geometry->geometry);
    return !instances || !instances->arrayOfPointers ||
           address_is_aligned(finding, input_field(INPUT_INSTANCES), instances->data.deviceAddress,
                              8);
}

const char *content_field(const struct geometry_view *geometry, enum input_role role)
{
    const enum build_command command = geometry->build->call->command;
    return input_name(role, command == COMMAND_NV     ? INPUT_OF_NV
                            : command == COMMAND_HOST ? INPUT_OF_HOST
                                                      : INPUT_OF_DEVICE);
}
