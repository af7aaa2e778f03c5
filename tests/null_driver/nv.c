/* SPDX-License-Identifier: Apache-2.0 */
/* NV acceleration structures: handles, memory and sizes. Builds look at nothing. */
#include "internal.h"

static uint64_t primitives_of(const VkAccelerationStructureInfoNV *info)
{
    uint64_t primitives = info->instanceCount;
    for (uint32_t i = 0; info->pGeometries != NULL && i < info->geometryCount; i++) {
        const VkGeometryNV *geometry = &info->pGeometries[i];
        const VkGeometryTrianglesNV *triangles = &geometry->geometry.triangles;
        if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_NV)
            primitives += geometry->geometry.aabbs.numAABBs;
        else if (triangles->indexType != VK_INDEX_TYPE_NONE_NV)
            primitives += triangles->indexCount / 3;
        else
            primitives += triangles->vertexCount / 3;
    }
    return primitives;
}

void init_CreateAccelerationStructureNV(struct object *as,
                                        const VkAccelerationStructureCreateInfoNV *pCreateInfo)
{
    as->as_nv.primitives = primitives_of(&pCreateInfo->info);
    as->as_nv.compacted = pCreateInfo->compactedSize;
}

static VkDeviceSize size_of(const struct null_driver_sizes *sizes, const struct object *as,
                            VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    switch (type) {
    case VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV:
        return size_for(&sizes->build_scratch, as->as_nv.primitives);
    case VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV:
        return size_for(&sizes->update_scratch, as->as_nv.primitives);
    default:
        return as->as_nv.compacted != 0 ? as->as_nv.compacted
                                        : size_for(&sizes->structure, as->as_nv.primitives);
    }
}

void null_GetAccelerationStructureMemoryRequirementsNV(
    VkDevice device, const VkAccelerationStructureMemoryRequirementsInfoNV *pInfo,
    VkMemoryRequirements2KHR *pMemoryRequirements)
{
    const struct null_driver_config *config = CONFIG(device);
    const struct object *as = FIND(ACCELERATION_STRUCTURE_NV, pInfo->accelerationStructure);
    const VkDeviceSize size = as != NULL ? size_of(&config->sizes, as, pInfo->type) : 0;
    pMemoryRequirements->memoryRequirements = (VkMemoryRequirements){
        .size = align_up(size, 256),
        .alignment = 256,
        .memoryTypeBits = requirements_types(
            config, 0, VK_MEMORY_PROPERTY_PROTECTED_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT),
    };
    requirements_fill_chain(pMemoryRequirements->pNext);
}

VkResult
null_BindAccelerationStructureMemoryNV(VkDevice device, uint32_t bindInfoCount,
                                       const VkBindAccelerationStructureMemoryInfoNV *pBindInfos)
{
    for (uint32_t i = 0; i < bindInfoCount; i++) {
        struct object *as = FIND(ACCELERATION_STRUCTURE_NV, pBindInfos[i].accelerationStructure);
        const struct object *memory = FIND(DEVICE_MEMORY, pBindInfos[i].memory);
        if (as != NULL && memory != NULL)
            as->as_nv.address = memory->memory.address + pBindInfos[i].memoryOffset;
    }
    return VK_SUCCESS;
}

VkResult null_GetAccelerationStructureHandleNV(VkDevice device,
                                               VkAccelerationStructureNV accelerationStructure,
                                               size_t dataSize, void *pData)
{
    const struct object *as = FIND(ACCELERATION_STRUCTURE_NV, accelerationStructure);
    const uint64_t address = as != NULL ? as->as_nv.address : 0;
    memcpy(pData, &address, dataSize < sizeof(address) ? dataSize : sizeof(address));
    return VK_SUCCESS;
}
