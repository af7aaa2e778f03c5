/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about builds of micromaps, about the build flags of micromaps, and about the geometries
 * that such builds take. Flags and types of extensions that are not enabled have their own
 * rules. */
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"

enum {
    UPDATE_FLAG = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR,
    DATA_UPDATE_FLAG = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT,
    DISABLE_FLAG = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR,
    LOSSY_FLAG = VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR,
};

static const struct device_facts *device_of(const struct micromap_build_view *view)
{
    return view->build->call->device;
}

static bool has_flag(const struct micromap_build_view *view,
                     VkBuildAccelerationStructureFlagsKHR flag)
{
    return view->build->info->flags & flag;
}

static bool is_micromap(const struct build_view *build)
{
    return build->info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
}

bool micromap_update_excludes_data_update(const struct micromap_build_view *micromap_build,
                                          struct finding *finding)
{
    return !has_flag(micromap_build, UPDATE_FLAG) || !has_flag(micromap_build, DATA_UPDATE_FLAG) ||
           violated(finding, "flags",
                    "{} has both "
                    "VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR and "
                    "VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT",
                    build_flags(micromap_build->build->info->flags));
}

/* ---- features */

bool micromap_data_update_flag_has_its_feature(const struct micromap_build_view *micromap_build,
                                               struct finding *finding)
{
    const struct device_facts *device = device_of(micromap_build);
    return !has_flag(micromap_build, DATA_UPDATE_FLAG) || !device->extension.opacity_micromap_ext ||
           device->micromap.ext ||
           violated(
               finding, "flags",
               "{} has VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT, "
               "but VkPhysicalDeviceOpacityMicromapFeaturesEXT::micromap is not enabled for the "
               "device",
               build_flags(micromap_build->build->info->flags));
}

static bool flag_has_its_feature(const struct micromap_build_view *micromap_build,
                                 VkBuildAccelerationStructureFlagsKHR flag, const char *name,
                                 struct finding *finding)
{
    const struct device_facts *device = device_of(micromap_build);
    bool exists = device->extension.opacity_micromap_ext || device->extension.opacity_micromap_khr;
    return !has_flag(micromap_build, flag) || !exists || device->micromap.ext ||
           device->micromap.khr ||
           violated(finding, "flags",
                    "{} has {}, but the feature micromap is not enabled for the device, neither of "
                    "VkPhysicalDeviceOpacityMicromapFeaturesKHR nor of "
                    "VkPhysicalDeviceOpacityMicromapFeaturesEXT",
                    build_flags(micromap_build->build->info->flags), phrase(name));
}

bool micromap_update_flag_has_its_feature(const struct micromap_build_view *micromap_build,
                                          struct finding *finding)
{
    return flag_has_its_feature(
        micromap_build, UPDATE_FLAG,
        "VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR", finding);
}

bool disable_micromaps_flag_has_its_feature(const struct micromap_build_view *micromap_build,
                                            struct finding *finding)
{
    return flag_has_its_feature(
        micromap_build, DISABLE_FLAG,
        "VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR", finding);
}

bool micromap_build_feature_is_enabled(const struct micromap_build_view *micromap_build,
                                       struct finding *finding)
{
    const struct device_facts *device = device_of(micromap_build);
    return !is_micromap(micromap_build->build) || !device->extension.opacity_micromap_khr ||
           device->micromap.khr ||
           violated_plainly(finding, "type",
                            "is VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR, but "
                            "VkPhysicalDeviceOpacityMicromapFeaturesKHR::micromap is not enabled "
                            "for the device");
}

/* ---- builds of micromaps */

bool micromap_build_flags_are_allowed(const struct micromap_build_view *micromap_build,
                                      struct finding *finding)
{
    const VkBuildAccelerationStructureFlagsKHR allowed =
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR |
        VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
        VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR | LOSSY_FLAG;
    VkBuildAccelerationStructureFlagsKHR flags = micromap_build->build->info->flags;
    return !is_micromap(micromap_build->build) || !(flags & ~allowed) ||
           violated(finding, "flags",
                    "{} has bits {}, which the build of a micromap does not accept",
                    build_flags(flags), build_flags(flags & ~allowed));
}

bool micromap_build_has_one_geometry(const struct micromap_build_view *micromap_build,
                                     struct finding *finding)
{
    uint32_t count = micromap_build->build->info->geometryCount;
    return !is_micromap(micromap_build->build) || count == 1 ||
           violated(finding, "geometryCount", "{} is not 1, which a micromap requires",
                    number(count));
}

bool lossy_build_is_a_micromap(const struct micromap_build_view *micromap_build,
                               struct finding *finding)
{
    const struct build_view *build = micromap_build->build;
    return !has_flag(micromap_build, LOSSY_FLAG) || is_micromap(build) ||
           violated(
               finding, "type",
               "is {}, but flags {} has VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR",
               accel_type(build->info->type), build_flags(build->info->flags));
}

static const VkAccelerationStructureGeometryKHR *geometry_of(const struct build_view *build,
                                                             uint32_t index)
{
    return build->geometries ? &build->geometries[index] : build->geometry_pointers[index];
}

bool micromap_build_has_no_build_ranges(const struct micromap_build_view *micromap_build,
                                        struct finding *finding)
{
    const struct build_view *build = micromap_build->build;
    const struct call_view *call = build->call;
    if (!call->build_ranges_readable || !call->build_ranges[build->index])
        return true;
    for (uint32_t i = 0; i < build->geometry_count; i++)
        if (type_is_micromap(geometry_of(build, i)->geometryType))
            return violated(finding, "",
                            "has a geometry of type VK_GEOMETRY_TYPE_MICROMAP_KHR at index {}, but "
                            "ppBuildRangeInfos[{}] is not NULL",
                            number(i), number(build->index));
    return true;
}

bool micromap_build_is_not_indirect(const struct micromap_build_view *micromap_build,
                                    struct finding *finding)
{
    return !is_micromap(micromap_build->build) ||
           violated_plainly(finding, "type",
                            "is VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR, which an "
                            "indirect build does not accept");
}

bool micromap_dst_is_micromap_or_generic(const struct micromap_build_view *micromap_build,
                                         struct finding *finding)
{
    const struct accel_facts *dst = &micromap_build->build->dst;
    return !is_micromap(micromap_build->build) || !dst->details_known ||
           dst->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR ||
           dst->type == VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR ||
           violated(finding, "dstAccelerationStructure",
                    "{} was created with type {}, neither "
                    "VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR nor "
                    "VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR",
                    object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(dst->handle)),
                    accel_type(dst->type));
}

/* ---- geometries */

static bool is_micromap_geometry(const struct micromap_geometry_view *view)
{
    return type_is_micromap(view->geometry->geometry->geometryType);
}

bool micromap_build_geometry_is_a_micromap(const struct micromap_geometry_view *micromap_geometry,
                                           struct finding *finding)
{
    const struct geometry_view *geometry = micromap_geometry->geometry;
    return !is_micromap(geometry->build) || is_micromap_geometry(micromap_geometry) ||
           violated(finding, "geometryType",
                    "{} is not VK_GEOMETRY_TYPE_MICROMAP_KHR, in the build of a micromap",
                    geometry_type(geometry->geometry->geometryType));
}

bool other_build_geometry_is_not_a_micromap(const struct micromap_geometry_view *micromap_geometry,
                                            struct finding *finding)
{
    const struct geometry_view *geometry = micromap_geometry->geometry;
    return is_micromap(geometry->build) || !is_micromap_geometry(micromap_geometry) ||
           !geometry->build->call->device->extension.opacity_micromap_khr ||
           violated(finding, "geometryType",
                    "is VK_GEOMETRY_TYPE_MICROMAP_KHR, in a build of type {}",
                    accel_type(geometry->build->info->type));
}

bool micromap_geometry_has_micromap_data(const struct micromap_geometry_view *micromap_geometry,
                                         struct finding *finding)
{
    const struct geometry_view *geometry = micromap_geometry->geometry;
    const struct chain_facts *chain = &geometry->chain;
    if (!is_micromap_geometry(micromap_geometry) || chain->unreadable ||
        !geometry->build->call->device->extension.opacity_micromap_khr)
        return true;
    bool has_two = chain->has_duplicate &&
                   (int)chain->duplicate ==
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR;
    if (micromap_geometry->has_data || (chain->has_duplicate && !has_two))
        return true;
    enum rule other = has_two ? RULE_geometry_chain_has_no_duplicates : rule_of_stray(geometry);
    return violated(finding, "pNext",
                    "has {} VkAccelerationStructureGeometryMicromapDataKHR, but geometryType "
                    "VK_GEOMETRY_TYPE_MICROMAP_KHR requires one",
                    phrase(has_two ? "more than one" : "no")) ||
           is_reported_with(finding, other);
}

bool micromap_geometry_has_no_flags(const struct micromap_geometry_view *micromap_geometry,
                                    struct finding *finding)
{
    const struct geometry_view *geometry = micromap_geometry->geometry;
    return !is_micromap_geometry(micromap_geometry) || !geometry->geometry->flags ||
           !geometry->build->call->device->extension.opacity_micromap_khr ||
           violated(finding, "flags", "{} is not 0, which VK_GEOMETRY_TYPE_MICROMAP_KHR requires",
                    geometry_flags_of(geometry->geometry->flags));
}
