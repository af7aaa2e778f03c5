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

/* These two are about an input that the geometry has. */

static bool role_is_given(const struct geometry_view *geometry, struct finding *finding,
                          enum input_role role)
{
    return input_is_given(geometry, finding, input_field(role),
                          input_address(geometry->geometry, role));
}

static bool role_is_aligned(const struct geometry_view *geometry, struct finding *finding,
                            enum input_role role, uint32_t alignment)
{
    return address_is_aligned(finding, input_field(role), input_address(geometry->geometry, role),
                              alignment);
}

bool vertex_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    return !triangles_in(geometry->geometry) || role_is_given(geometry, finding, INPUT_VERTEX);
}

bool vertex_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || role_is_aligned(geometry, finding, INPUT_VERTEX,
                                         format_alignment(triangles->vertexFormat));
}

bool index_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || !index_type_size(triangles->indexType) ||
           role_is_given(geometry, finding, INPUT_INDEX);
}

bool index_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles ||
           role_is_aligned(geometry, finding, INPUT_INDEX, index_type_size(triangles->indexType));
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
    return !triangles_in(geometry->geometry) ||
           role_is_aligned(geometry, finding, INPUT_MATRIX, 16);
}

bool aabb_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    return !aabbs_in(geometry->geometry) || role_is_given(geometry, finding, INPUT_AABBS);
}

bool aabb_address_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    return !aabbs_in(geometry->geometry) || role_is_aligned(geometry, finding, INPUT_AABBS, 8);
}

bool instance_address_is_given(const struct geometry_view *geometry, struct finding *finding)
{
    return !instances_in(geometry->geometry) || role_is_given(geometry, finding, INPUT_INSTANCES);
}

bool instance_array_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    return !instances_in(geometry->geometry) || has_instance_pointers(geometry->geometry) ||
           role_is_aligned(geometry, finding, INPUT_INSTANCES, 16);
}

bool instance_pointers_are_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    return !instances_in(geometry->geometry) || !has_instance_pointers(geometry->geometry) ||
           role_is_aligned(geometry, finding, INPUT_INSTANCES, 8);
}

const char *content_field(const struct geometry_view *geometry, enum input_role role)
{
    const enum build_command command = geometry->build->call->command;
    return input_name(role, command == COMMAND_NV     ? INPUT_OF_NV
                            : command == COMMAND_HOST ? INPUT_OF_HOST
                                                      : INPUT_OF_DEVICE);
}
