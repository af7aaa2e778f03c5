/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about one VkAccelerationStructureBuildGeometryInfoKHR of a call. */
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/view/enabled.h"
#include "src/view/names.h"

bool build_info_has_its_stype(const struct build_view *build, struct finding *finding)
{
    VkStructureType type = build->info->sType;
    return type == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR ||
           violated(finding, "sType",
                    "{} is not VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR",
                    structure_type(type));
}

bool build_info_has_no_chain(const struct build_view *build, struct finding *finding)
{
    return !build->info->pNext || build->call->device->newer_than_registry ||
           violated(finding, "pNext", "{} is not NULL",
                    hex((uint64_t)(uintptr_t)build->info->pNext));
}

bool build_type_is_valid(const struct build_view *build, struct finding *finding)
{
    VkAccelerationStructureTypeKHR type = build->info->type;
    return accel_type_is_enabled(build->call->device, type) ||
           violated(finding, "type",
                    "{} is not a VkAccelerationStructureTypeKHR value of an enabled extension",
                    accel_type(type));
}

bool build_type_is_not_generic(const struct build_view *build, struct finding *finding)
{
    return build->info->type != VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR ||
           violated_plainly(
               finding, "type",
               "is VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR, which a build cannot make") ||
           ((build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) &&
            also_violates(finding, RULE_motion_build_is_not_generic));
}

bool build_flags_are_valid(const struct build_view *build, struct finding *finding)
{
    const struct device_facts *device = build->call->device;
    VkBuildAccelerationStructureFlagsKHR unknown = build->info->flags & ~core_build_flags;
    if (unknown)
        unknown &= ~build_flags_enabled(device);
    return !unknown || device->newer_than_registry ||
           violated(finding, "flags", "{} has bits {}, which no enabled extension defines",
                    build_flags(build->info->flags), hex(unknown));
}

bool fast_trace_excludes_fast_build(const struct build_view *build, struct finding *finding)
{
    const VkBuildAccelerationStructureFlagsKHR both =
        VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
        VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR;
    return (build->info->flags & both) != both ||
           violated(finding, "flags",
                    "{} has both VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR and "
                    "VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR",
                    build_flags(build->info->flags));
}

bool build_mode_is_valid(const struct build_view *build, struct finding *finding)
{
    VkBuildAccelerationStructureModeKHR mode = build->info->mode;
    return mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR ||
           mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR ||
           build->call->device->newer_than_registry ||
           violated(finding, "mode", "{} is not a VkBuildAccelerationStructureModeKHR",
                    number((uint32_t)mode));
}

static bool is_micromap(const struct build_view *build)
{
    return build->info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
}

/* The valid usage doesn't exempt micromaps, which can't be updated at all. */
bool update_has_a_source(const struct build_view *build, struct finding *finding)
{
    return !build_is_update(build->info) || build->info->srcAccelerationStructure ||
           violated_plainly(finding, "srcAccelerationStructure",
                            "is VK_NULL_HANDLE, but mode is "
                            "VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR") ||
           (is_micromap(build) && is_reported_with(finding, RULE_micromap_build_is_no_update));
}

bool micromap_build_is_no_update(const struct build_view *build, struct finding *finding)
{
    return !is_micromap(build) || !build_is_update(build->info) ||
           violated_plainly(finding, "mode",
                            "is VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR, but a micromap "
                            "cannot be updated") ||
           also_violates(finding, build->info->srcAccelerationStructure
                                      ? RULE_micromap_build_has_no_source
                                      : RULE_update_has_a_source);
}

bool micromap_build_has_no_source(const struct build_view *build, struct finding *finding)
{
    VkAccelerationStructureKHR src = build->info->srcAccelerationStructure;
    return !is_micromap(build) || !src ||
           violated(finding, "srcAccelerationStructure",
                    "{} is not VK_NULL_HANDLE, but the build of a micromap has no source",
                    object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(src))) ||
           (build_is_update(build->info) &&
            is_reported_with(finding, RULE_micromap_build_is_no_update));
}

bool exactly_one_geometry_array_is_given(const struct build_view *build, struct finding *finding)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    if (!info->geometryCount || !info->pGeometries != !info->ppGeometries)
        return true;
    return violated(finding, "pGeometries",
                    info->pGeometries ? "{} and ppGeometries {} are both given"
                                      : "{} and ppGeometries {} are both NULL",
                    hex((uint64_t)(uintptr_t)info->pGeometries),
                    hex((uint64_t)(uintptr_t)info->ppGeometries));
}

bool geometries_are_readable(const struct build_view *build, struct finding *finding)
{
    return !build->geometries_unreadable ||
           violated(finding, "pGeometries", "{} does not point to a readable array of {}",
                    hex((uint64_t)(uintptr_t)build->info->pGeometries),
                    count_of(build->info->geometryCount, "geometry"));
}

bool geometry_pointers_are_readable(const struct build_view *build, struct finding *finding)
{
    return !build->geometry_pointers_unreadable ||
           violated(finding, "ppGeometries",
                    "{} does not point to a readable array of {} to readable geometries",
                    hex((uint64_t)(uintptr_t)build->info->ppGeometries),
                    count_of(build->info->geometryCount, "pointer"));
}

bool build_ranges_of_build_are_readable(const struct build_view *build, struct finding *finding)
{
    return !build->build_ranges_unreadable ||
           violated(finding, "geometryCount",
                    "is {}, but ppBuildRangeInfos[{}] {} does not point to a readable array of "
                    "that length",
                    number(build->info->geometryCount), number(build->index),
                    hex((uint64_t)(uintptr_t)build->call->build_ranges[build->index]));
}

static bool is_of_type(const struct build_view *build, VkAccelerationStructureTypeKHR type)
{
    return build->info->type == type;
}

bool tlas_has_one_geometry(const struct build_view *build, struct finding *finding)
{
    return !is_of_type(build, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR) ||
           build->info->geometryCount == 1 ||
           violated(finding, "geometryCount", "{} is not 1, which a top-level structure requires",
                    number(build->info->geometryCount));
}

static struct value type_of_geometry(const struct build_view *build, uint32_t geometry)
{
    return geometry_type(build_geometry(build->info, geometry)->geometryType);
}

bool blas_geometries_have_one_type(const struct build_view *build, struct finding *finding)
{
    if (!is_of_type(build, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR) ||
        build->first_other_type == build->geometry_count)
        return true;
    return violated(
        finding, build->geometries ? "pGeometries" : "ppGeometries",
        "has {} at index 0 but {} at index {}, in the build of a bottom-level structure",
        type_of_geometry(build, 0), type_of_geometry(build, build->first_other_type),
        number(build->first_other_type));
}

static bool primitives_are_within_limit(const struct build_view *build, struct finding *finding,
                                        uint64_t count, const char *primitive)
{
    uint64_t limit = build->call->device->limits.maxPrimitiveCount;
    return !is_of_type(build, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR) || count <= limit ||
           violated(finding, "",
                    "has {} in all of its geometries, more than maxPrimitiveCount ({})",
                    count_of(count, primitive), number(limit));
}

bool blas_geometry_count_is_within_limit(const struct build_view *build, struct finding *finding)
{
    uint64_t limit = build->call->device->limits.maxGeometryCount;
    return !is_of_type(build, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR) ||
           build->info->geometryCount <= limit ||
           violated(finding, "geometryCount", "{} exceeds maxGeometryCount ({})",
                    number(build->info->geometryCount), number(limit));
}

bool blas_aabb_count_is_within_limit(const struct build_view *build, struct finding *finding)
{
    return primitives_are_within_limit(build, finding, build->aabb_count, "AABB");
}

bool blas_triangle_count_is_within_limit(const struct build_view *build, struct finding *finding)
{
    return primitives_are_within_limit(build, finding, build->triangle_count, "triangle");
}
