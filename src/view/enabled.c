/* SPDX-License-Identifier: Apache-2.0 */
/* Determines which enumerants the enabled extensions of a device define. */
#include "src/view/enabled.h"

bool accel_type_is_enabled(const struct device_facts *device, VkAccelerationStructureTypeKHR type)
{
    switch ((int)type) {
    case VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR:
    case VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR:
    case VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR:
        return true;
    case VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR:
        return device->extension.opacity_micromap_khr;
    default:
        return device->newer_than_registry;
    }
}

bool geometry_type_is_enabled(const struct device_facts *device, VkGeometryTypeKHR type)
{
    switch ((int)type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
    case VK_GEOMETRY_TYPE_AABBS_KHR:
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        return true;
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        return device->extension.linear_swept_spheres_nv;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        return device->extension.dense_geometry_format_amdx;
    case VK_GEOMETRY_TYPE_MICROMAP_KHR:
        return device->extension.opacity_micromap_khr;
    default:
        return device->newer_than_registry;
    }
}

VkBuildAccelerationStructureFlagsKHR build_flags_enabled(const struct device_facts *device)
{
    VkBuildAccelerationStructureFlagsKHR flags = core_build_flags;
    if (device->extension.motion_blur_nv)
        flags |= VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    if (device->extension.opacity_micromap_ext || device->extension.opacity_micromap_khr)
        flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR |
                 VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR;
    if (device->extension.opacity_micromap_ext)
        flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT;
    if (device->extension.opacity_micromap_khr)
        flags |= VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR;
    if (device->extension.displacement_micromap_nv)
        flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISPLACEMENT_MICROMAP_UPDATE_BIT_NV;
    if (device->extension.position_fetch_khr)
        flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DATA_ACCESS_BIT_KHR;
    if (device->extension.cluster_acceleration_structure_nv)
        flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_CLUSTER_OPACITY_MICROMAPS_BIT_NV;
    return flags;
}

VkGeometryInstanceFlagsKHR instance_flags_enabled(const struct device_facts *device)
{
    VkGeometryInstanceFlagsKHR flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR |
                                       VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR |
                                       VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR |
                                       VK_GEOMETRY_INSTANCE_FORCE_NO_OPAQUE_BIT_KHR;
    if (device->extension.opacity_micromap_ext || device->extension.opacity_micromap_khr)
        flags |= micromap_instance_flags;
    return flags;
}
