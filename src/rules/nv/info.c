/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about VkAccelerationStructureInfoNV. */
#include "src/rules/predicates.h"
#include "src/view/enabled.h"
#include "src/view/names.h"

static const struct device_facts *device_of(const struct nv_info_view *info)
{
    return info->call->call->device;
}

static bool is_blas(const struct nv_info_view *info)
{
    return info->info->type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV;
}

bool nv_info_has_its_stype(const struct nv_info_view *nv_info, struct finding *finding)
{
    VkStructureType type = nv_info->info->sType;
    return type == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_INFO_NV ||
           violated(finding, "sType", "{} is not VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_INFO_NV",
                    structure_type(type));
}

bool nv_info_has_no_chain(const struct nv_info_view *nv_info, struct finding *finding)
{
    return !nv_info->info->pNext || device_of(nv_info)->newer_than_registry ||
           violated(finding, "pNext", "{} is not NULL",
                    hex((uint64_t)(uintptr_t)nv_info->info->pNext));
}

bool nv_info_type_is_valid(const struct nv_info_view *nv_info, struct finding *finding)
{
    VkAccelerationStructureTypeNV type = nv_info->info->type;
    return accel_type_is_enabled(device_of(nv_info), type) ||
           violated(finding, "type", "{} is not a VkAccelerationStructureTypeNV", accel_type(type));
}

bool nv_info_type_is_not_generic(const struct nv_info_view *nv_info, struct finding *finding)
{
    return nv_info->info->type != VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR ||
           violated_plainly(
               finding, "type",
               "is VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR, which a build cannot make");
}

bool nv_info_flags_are_valid(const struct nv_info_view *nv_info, struct finding *finding)
{
    const struct build_view *build = &nv_info->call->build;
    return !build->info || build_flags_are_valid(build, finding);
}

bool nv_fast_trace_excludes_fast_build(const struct nv_info_view *nv_info, struct finding *finding)
{
    const VkBuildAccelerationStructureFlagsKHR both =
        VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_NV |
        VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_NV;
    return (nv_info->info->flags & both) != both ||
           violated(finding, "flags",
                    "{} has both VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_NV and "
                    "VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_NV",
                    build_flags(nv_info->info->flags));
}

bool nv_tlas_has_no_geometries(const struct nv_info_view *nv_info, struct finding *finding)
{
    return nv_info->info->type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV ||
           !nv_info->info->geometryCount ||
           violated(finding, "geometryCount", "{} is not 0, in the build of a top-level structure",
                    number(nv_info->info->geometryCount));
}

bool nv_blas_has_no_instances(const struct nv_info_view *nv_info, struct finding *finding)
{
    return !is_blas(nv_info) || !nv_info->info->instanceCount ||
           violated(finding, "instanceCount",
                    "{} is not 0, in the build of a bottom-level structure",
                    number(nv_info->info->instanceCount));
}

bool nv_blas_geometries_have_one_type(const struct nv_info_view *nv_info, struct finding *finding)
{
    const VkGeometryNV *geometries = nv_info->call->geometries;
    uint32_t other = nv_info->first_other_type;
    return !is_blas(nv_info) || other == nv_info->call->geometry_count ||
           violated(
               finding, "pGeometries",
               "has {} at index 0 but {} at index {}, in the build of a bottom-level structure",
               geometry_type(geometries[0].geometryType),
               geometry_type(geometries[other].geometryType), number(other));
}

bool nv_geometries_are_readable(const struct nv_info_view *nv_info, struct finding *finding)
{
    return !nv_info->call->geometries_unreadable ||
           violated(finding, "pGeometries", "{} does not point to a readable array of {}",
                    hex((uint64_t)(uintptr_t)nv_info->info->pGeometries),
                    count_of(nv_info->info->geometryCount, "geometry"));
}

/* ---- limits */

static bool geometry_count_is_within_limit(const struct nv_info_view *info, struct finding *finding)
{
    uint64_t limit = device_of(info)->nv_limits.maxGeometryCount;
    return info->info->geometryCount <= limit ||
           violated(finding, "geometryCount",
                    "{} exceeds VkPhysicalDeviceRayTracingPropertiesNV::maxGeometryCount ({})",
                    number(info->info->geometryCount), number(limit));
}

/* The registry has this valid usage for the command and for VkAccelerationStructureInfoNV. The
 * message about the command names both ids. */

bool nv_build_geometry_count_is_within_limit(const struct nv_info_view *nv_info,
                                             struct finding *finding)
{
    return geometry_count_is_within_limit(nv_info, finding) ||
           also_violates(finding, RULE_nv_geometry_count_is_within_limit);
}

bool nv_geometry_count_is_within_limit(const struct nv_info_view *nv_info, struct finding *finding)
{
    return geometry_count_is_within_limit(nv_info, finding) ||
           is_reported_with(finding, RULE_nv_build_geometry_count_is_within_limit);
}

bool nv_instance_count_is_within_limit(const struct nv_info_view *nv_info, struct finding *finding)
{
    uint64_t limit = device_of(nv_info)->nv_limits.maxInstanceCount;
    return nv_info->info->instanceCount <= limit ||
           violated(finding, "instanceCount",
                    "{} exceeds VkPhysicalDeviceRayTracingPropertiesNV::maxInstanceCount ({})",
                    number(nv_info->info->instanceCount), number(limit));
}

bool nv_triangle_count_is_within_limit(const struct nv_info_view *nv_info, struct finding *finding)
{
    uint64_t limit = device_of(nv_info)->nv_limits.maxTriangleCount;
    return nv_info->triangle_count <= limit ||
           violated(finding, "pGeometries",
                    "has {} in total, more than "
                    "VkPhysicalDeviceRayTracingPropertiesNV::maxTriangleCount ({})",
                    count_of(nv_info->triangle_count, "triangle"), number(limit));
}
