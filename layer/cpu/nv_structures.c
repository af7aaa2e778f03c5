/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: creation of structures of VK_NV_ray_tracing, and their memory and handles. They
 * share a table with those of VK_KHR_acceleration_structure. */
#include <string.h>

#include "layer/cpu/overlay.h"
#include "observers.h"
#include "src/model/build_parameters.h"
#include "src/snapshots/build_input.h"
#include "src/snapshots/memory.h"

enum { MEMORY_ALIGNMENT = 256 };

/* Determines the structure's size from its creation parameters. */
static VkResult describe_nv_structure(const VkAccelerationStructureCreateInfoNV *create_info,
                                      struct cpu_structure_info *info)
{
    struct readable_cache cache = {0};
    struct build_parameters build;
    struct builder_sizes sizes;
    *info = (struct cpu_structure_info){.type = create_info->info.type,
                                        .size = create_info->compactedSize};
    if (create_info->compactedSize)
        return VK_SUCCESS;
    VkResult result = nv_info_copy(&cache, &create_info->info, NULL, &build);
    if (result == VK_SUCCESS)
        result = build_parameters_sizes(&build, NULL, &sizes);
    build_parameters_release(&build);
    if (result == VK_SUCCESS && sizes.structure) {
        info->size = sizes.structure;
        info->build_scratch = sizes.build_scratch + CPU_SCRATCH_SLACK;
        info->update_scratch = sizes.update_scratch + CPU_SCRATCH_SLACK;
    }
    return result;
}

VkResult cpu_create_nv_structure(struct cpu_structures *structures,
                                 const VkAccelerationStructureCreateInfoNV *create_info,
                                 VkAccelerationStructureNV *structure)
{
    struct cpu_structure_info info;
    uint64_t handle = 0;
    VkResult result = describe_nv_structure(create_info, &info);
    if (result == VK_SUCCESS)
        result = cpu_structures_add(structures, &info, &handle);
    *structure = result == VK_SUCCESS ? (VkAccelerationStructureNV)handle : VK_NULL_HANDLE;
    return result;
}

/* ---- memory, which is never accessed */

/* All memory types except those that are for one use only, or need a feature. */
static uint32_t memory_types(const struct layer_device *device)
{
    const VkMemoryPropertyFlags special =
        VK_MEMORY_PROPERTY_PROTECTED_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT |
        VK_MEMORY_PROPERTY_DEVICE_COHERENT_BIT_AMD | VK_MEMORY_PROPERTY_RDMA_CAPABLE_BIT_NV;
    VkPhysicalDeviceMemoryProperties properties;
    uint32_t types = 0;
    device->instance->vk.GetPhysicalDeviceMemoryProperties(device->physical_device, &properties);
    for (uint32_t i = 0; i < properties.memoryTypeCount; i++)
        if (!(properties.memoryTypes[i].propertyFlags & special))
            types |= 1u << i;
    return types;
}

static VkDeviceSize required_size(const struct cpu_structure_info *info,
                                  VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    switch (type) {
    case VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV:
        return info->build_scratch;
    case VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV:
        return info->update_scratch;
    default:
        return info->size;
    }
}

void cpu_get_nv_requirements(struct layer_device *device,
                             const VkAccelerationStructureMemoryRequirementsInfoNV *requested,
                             VkMemoryRequirements2 *requirements)
{
    struct cpu_structure_info info = {0};
    cpu_structures_find(device->cpu->device->structures, (uint64_t)requested->accelerationStructure,
                        &info);
    requirements->memoryRequirements = (VkMemoryRequirements){
        .size = required_size(&info, requested->type),
        .alignment = MEMORY_ALIGNMENT,
        .memoryTypeBits = memory_types(device),
    };
    for (VkBaseOutStructure *out = requirements->pNext; out; out = out->pNext) {
        VkMemoryDedicatedRequirements *dedicated = (VkMemoryDedicatedRequirements *)out;
        if (out->sType == VK_STRUCTURE_TYPE_MEMORY_DEDICATED_REQUIREMENTS)
            dedicated->prefersDedicatedAllocation = dedicated->requiresDedicatedAllocation =
                VK_FALSE;
    }
}

/* ---- handles, by which instances refer to structures */

VkResult cpu_get_nv_handle(struct cpu_structures *structures, VkAccelerationStructureNV structure,
                           size_t size, void *data)
{
    struct cpu_structure_info info;
    const uint64_t handle = (uint64_t)structure;
    if (size < sizeof(handle) || !memory_is_writable(data, sizeof(handle)) ||
        !cpu_structures_find(structures, handle, &info))
        return VK_ERROR_VALIDATION_FAILED;
    memcpy(data, &handle, sizeof(handle));
    return VK_SUCCESS;
}
