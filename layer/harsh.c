/* SPDX-License-Identifier: Apache-2.0 */
/* The commands that report harsh limits and sizes.
 *
 * An entry passes a call on even if its arguments are not readable (layer/commands/commands.h), so
 * each command here looks before it reads or writes. */
#include "layer/harsh.h"

#include "src/base/readable.h"
#include "src/model/geometry.h"
#include "src/model/inputs.h"
#include "src/state/builds/harsh.h"

static bool structure_is_readable(const void *structure, size_t size)
{
    return structure && readable(readable_cache_of_thread(), structure, size);
}

/* ---- instances */

static void make_limits_harsh(const VkPhysicalDeviceProperties2 *properties)
{
    if (!structure_is_readable(properties, sizeof(*properties)))
        return;
    for (VkBaseOutStructure *out = properties->pNext; structure_is_readable(out, sizeof(*out));
         out = out->pNext) {
        VkPhysicalDeviceAccelerationStructurePropertiesKHR *limits = (void *)out;
        if (out->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR &&
            structure_is_readable(limits, sizeof(*limits)))
            harsh_limit_structures(limits);
    }
}

static VKAPI_ATTR void VKAPI_CALL get_properties2(VkPhysicalDevice physical_device,
                                                  VkPhysicalDeviceProperties2 *properties)
{
    const struct layer_instance *instance = layer_find_instance(physical_device);
    if (!instance)
        return;
    instance->harsh.get_properties2(physical_device, properties);
    make_limits_harsh(properties);
}

static VKAPI_ATTR void VKAPI_CALL get_properties2_khr(VkPhysicalDevice physical_device,
                                                      VkPhysicalDeviceProperties2 *properties)
{
    const struct layer_instance *instance = layer_find_instance(physical_device);
    if (!instance)
        return;
    instance->harsh.get_properties2_khr(physical_device, properties);
    make_limits_harsh(properties);
}

static bool is_set(const struct layer_instance *instance)
{
    return reporter_settings(instance->reporter)->limits == LIMITS_HARSH;
}

/* Keeps a command of a table in `below`, and replaces it. A command that the table lacks stays
 * NULL.
 */
#define COVER(below, command, own)                                                                 \
    do {                                                                                           \
        (below) = (command);                                                                       \
        if (command)                                                                               \
            (command) = (own);                                                                     \
    } while (false)

void harsh_cover_instance(struct layer_instance *instance)
{
    if (!is_set(instance))
        return;
    COVER(instance->harsh.get_properties2, instance->vk.GetPhysicalDeviceProperties2,
          get_properties2);
    COVER(instance->harsh.get_properties2_khr, instance->vk.GetPhysicalDeviceProperties2KHR,
          get_properties2_khr);
}

/* ---- devices */

static bool geometry_has_transform(const VkAccelerationStructureGeometryKHR *geometry)
{
    return structure_is_readable(geometry, sizeof(*geometry)) &&
           type_is_triangles(geometry->geometryType) && input_address(geometry, INPUT_MATRIX);
}

/* A size may depend on whether there is a transform, and on no other address. */
static bool has_transform(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    bool has = false;
    if (info->ppGeometries && !info->pGeometries &&
        !structure_is_readable(info->ppGeometries,
                               info->geometryCount * sizeof(info->ppGeometries[0])))
        return false;
    for (uint32_t i = 0; i < info->geometryCount && !has; i++)
        if (info->pGeometries)
            has = geometry_has_transform(&info->pGeometries[i]);
        else if (info->ppGeometries)
            has = geometry_has_transform(info->ppGeometries[i]);
    return has;
}

static VKAPI_ATTR void VKAPI_CALL
get_build_sizes(VkDevice handle, VkAccelerationStructureBuildTypeKHR build_type,
                const VkAccelerationStructureBuildGeometryInfoKHR *info, const uint32_t *counts,
                VkAccelerationStructureBuildSizesInfoKHR *sizes)
{
    const struct layer_device *device = layer_find_device(handle);
    if (!device)
        return;
    device->harsh.get_build_sizes(handle, build_type, info, counts, sizes);
    if (!structure_is_readable(info, sizeof(*info)) ||
        !structure_is_readable(sizes, sizeof(*sizes)))
        return;
    const struct harsh_build build = {build_type, info->type, info->flags, has_transform(info)};
    harsh_grow_build_sizes(&build, sizes);
}

static VKAPI_ATTR void VKAPI_CALL get_micromap_sizes(VkDevice handle,
                                                     VkAccelerationStructureBuildTypeKHR build_type,
                                                     const VkMicromapBuildInfoEXT *info,
                                                     VkMicromapBuildSizesInfoEXT *sizes)
{
    const struct layer_device *device = layer_find_device(handle);
    if (!device)
        return;
    device->harsh.get_micromap_sizes(handle, build_type, info, sizes);
    if (structure_is_readable(info, sizeof(*info)) && structure_is_readable(sizes, sizeof(*sizes)))
        harsh_grow_micromap_sizes(build_type, info->flags, sizes);
}

static VKAPI_ATTR void VKAPI_CALL
get_requirements_nv(VkDevice handle, const VkAccelerationStructureMemoryRequirementsInfoNV *info,
                    VkMemoryRequirements2 *requirements)
{
    const struct layer_device *device = layer_find_device(handle);
    if (!device)
        return;
    device->harsh.get_requirements_nv(handle, info, requirements);
    if (structure_is_readable(info, sizeof(*info)) &&
        structure_is_readable(requirements, sizeof(*requirements)))
        harsh_grow_requirements(info->type, &requirements->memoryRequirements);
}

void harsh_cover_device(struct layer_device *device)
{
    if (!is_set(device->instance))
        return;
    COVER(device->harsh.get_build_sizes, device->vk.GetAccelerationStructureBuildSizesKHR,
          get_build_sizes);
    COVER(device->harsh.get_micromap_sizes, device->vk.GetMicromapBuildSizesEXT,
          get_micromap_sizes);
    COVER(device->harsh.get_requirements_nv,
          device->vk.GetAccelerationStructureMemoryRequirementsNV, get_requirements_nv);
}
