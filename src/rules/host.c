/* SPDX-License-Identifier: Apache-2.0 */
/* Rules that apply to vkBuildAccelerationStructuresKHR only. */
#include "src/view/view.h"

#include "src/model/geometry.h"
#include "src/model/input_names.h"
#include "src/rules/predicates.h"
#include "src/view/phrases.h"

/* ---- the call */

static struct value operation(const struct call_view *call)
{
    return object(VK_OBJECT_TYPE_DEFERRED_OPERATION_KHR, handle_number(call->deferred.handle));
}

bool device_is_valid(const struct call_view *call, struct finding *finding)
{
    return call->device_argument == call->device->handle ||
           violated_by_handle(finding, "device", hex((uint64_t)(uintptr_t)call->device_argument),
                              "a VkDevice");
}

bool deferred_operation_is_valid(const struct call_view *call, struct finding *finding)
{
    return call->deferred.alive != NO || call->deferred.of_another_device ||
           violated_by_handle(finding, "deferredOperation", operation(call),
                              "a deferred operation of this device");
}

bool deferred_operation_is_of_the_device(const struct call_view *call, struct finding *finding)
{
    return call->deferred.alive != NO || !call->deferred.of_another_device ||
           violated(finding, "deferredOperation", "{} was created from another VkDevice",
                    operation(call));
}

bool previous_deferred_operation_is_complete(const struct call_view *call, struct finding *finding)
{
    return call->deferred.complete != NO ||
           violated(finding, "deferredOperation",
                    "{} is not complete: vkGetDeferredOperationResultKHR returns VK_NOT_READY",
                    operation(call));
}

/* ---- structures */

static bool is_update(const struct host_build_view *host_build)
{
    return build_is_update(host_build->build->info);
}

/* The message about the dst names the id about the src. */
static bool is_in_place(const struct host_build_view *host_build)
{
    return build_is_in_place(host_build->build->info);
}

static struct value structure(const struct accel_facts *accel)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(accel->handle));
}

static struct value buffer(const struct accel_facts *accel)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(accel->buffer));
}

static bool has_a_buffer(const struct accel_facts *accel, struct finding *finding,
                         const char *field)
{
    return !accel->by_address ||
           violated(finding, field,
                    "{} was created with vkCreateAccelerationStructure2KHR, not "
                    "vkCreateAccelerationStructureKHR",
                    structure(accel));
}

bool host_build_dst_was_created_with_a_buffer(const struct host_build_view *host_build,
                                              struct finding *finding)
{
    return has_a_buffer(&host_build->build->dst, finding, "dstAccelerationStructure") ||
           (is_in_place(host_build) &&
            also_violates(finding, RULE_host_build_src_was_created_with_a_buffer));
}

bool host_build_src_was_created_with_a_buffer(const struct host_build_view *host_build,
                                              struct finding *finding)
{
    return !is_update(host_build) ||
           has_a_buffer(&host_build->build->src, finding, "srcAccelerationStructure") ||
           (is_in_place(host_build) &&
            is_reported_with(finding, RULE_host_build_dst_was_created_with_a_buffer));
}

static bool is_host_visible(const struct accel_facts *accel, struct finding *finding,
                            const char *field)
{
    return accel->host_visible != NO || violated(finding, field,
                                                 "{} lies in {}, which is bound to memory without "
                                                 "VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT",
                                                 structure(accel), buffer(accel));
}

bool host_build_dst_is_host_visible(const struct host_build_view *host_build,
                                    struct finding *finding)
{
    return is_host_visible(&host_build->build->dst, finding, "dstAccelerationStructure") ||
           (is_in_place(host_build) && also_violates(finding, RULE_host_build_src_is_host_visible));
}

bool host_build_src_is_host_visible(const struct host_build_view *host_build,
                                    struct finding *finding)
{
    return !is_update(host_build) ||
           is_host_visible(&host_build->build->src, finding, "srcAccelerationStructure") ||
           (is_in_place(host_build) &&
            is_reported_with(finding, RULE_host_build_dst_is_host_visible));
}

static bool has_one_memory_instance(const struct accel_facts *accel, struct finding *finding,
                                    const char *field)
{
    return accel->multi_instance != YES ||
           violated(
               finding, field,
               "{} lies in {}, which is bound to memory that was allocated with multiple instances",
               structure(accel), buffer(accel));
}

bool host_build_dst_has_one_memory_instance(const struct host_build_view *host_build,
                                            struct finding *finding)
{
    return has_one_memory_instance(&host_build->build->dst, finding, "dstAccelerationStructure") ||
           (is_in_place(host_build) &&
            also_violates(finding, RULE_host_build_src_has_one_memory_instance));
}

bool host_build_src_has_one_memory_instance(const struct host_build_view *host_build,
                                            struct finding *finding)
{
    return !is_update(host_build) ||
           has_one_memory_instance(&host_build->build->src, finding, "srcAccelerationStructure") ||
           (is_in_place(host_build) &&
            is_reported_with(finding, RULE_host_build_dst_has_one_memory_instance));
}

/* ---- scratch */

static bool scratch_is_readable(const struct host_build_view *host_build, struct finding *finding,
                                const char *size_name)
{
    const struct host_bytes *scratch = &host_build->scratch;
    return !scratch->unreadable ||
           violated(finding, "scratchData.hostAddress",
                    "{} does not point to {} of host memory ({})", hex(scratch->begin),
                    count_of(scratch->size, "byte"), phrase(size_name));
}

bool build_scratch_is_host_memory(const struct host_build_view *host_build, struct finding *finding)
{
    return host_build->build->info->mode != VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR ||
           scratch_is_readable(host_build, finding, "buildScratchSize");
}

bool update_scratch_is_host_memory(const struct host_build_view *host_build,
                                   struct finding *finding)
{
    return !is_update(host_build) || scratch_is_readable(host_build, finding, "updateScratchSize");
}

/* ---- geometries */

static bool bytes_are_readable(const struct host_geometry_view *host_geometry,
                               struct finding *finding, enum input_role role)
{
    const struct host_bytes *bytes = &host_geometry->inputs[role];
    return !bytes->unreadable ||
           violated(finding, input_name(role, INPUT_OF_HOST),
                    "{} is invalid: the build reads {} at {}, which is not host memory",
                    hex((uint64_t)(uintptr_t)bytes->address), count_of(bytes->size, "byte"),
                    hex(bytes->begin));
}

static bool input_is_readable(const struct host_geometry_view *host_geometry,
                              struct finding *finding, enum input_role role)
{
    return host_input_is_given(host_geometry->geometry, finding, input_name(role, INPUT_OF_HOST),
                               host_geometry->inputs[role].address) &&
           bytes_are_readable(host_geometry, finding, role);
}

bool vertex_host_address_is_readable(const struct host_geometry_view *host_geometry,
                                     struct finding *finding)
{
    return !triangles_in(host_geometry->geometry->geometry) ||
           input_is_readable(host_geometry, finding, INPUT_VERTEX);
}

bool index_host_address_is_readable(const struct host_geometry_view *host_geometry,
                                    struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(host_geometry->geometry->geometry);
    return !triangles || !index_type_size(triangles->indexType) ||
           input_is_readable(host_geometry, finding, INPUT_INDEX);
}

bool transform_host_address_is_null_or_readable(const struct host_geometry_view *host_geometry,
                                                struct finding *finding)
{
    return bytes_are_readable(host_geometry, finding, INPUT_MATRIX);
}

bool aabb_host_address_is_readable(const struct host_geometry_view *host_geometry,
                                   struct finding *finding)
{
    return !aabbs_in(host_geometry->geometry->geometry) ||
           input_is_readable(host_geometry, finding, INPUT_AABBS);
}

bool instance_host_address_is_readable(const struct host_geometry_view *host_geometry,
                                       struct finding *finding)
{
    return !instances_in(host_geometry->geometry->geometry) ||
           input_is_readable(host_geometry, finding, INPUT_INSTANCES);
}
