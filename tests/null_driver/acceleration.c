/* SPDX-License-Identifier: Apache-2.0 */
/* KHR acceleration structures: handles, addresses, sizes. Builds and copies look at nothing. */
#include "internal.h"

static VkDeviceAddress buffer_address(uint64_t handle)
{
    const struct object *buffer = object_find(handle, VK_OBJECT_TYPE_BUFFER);
    return buffer != NULL ? buffer->buffer.address : 0;
}

void init_CreateAccelerationStructureKHR(struct object *as,
                                         const VkAccelerationStructureCreateInfoKHR *pCreateInfo)
{
    as->as.buffer = RAW(pCreateInfo->buffer);
    as->as.offset = pCreateInfo->offset;
    as->as.fallback = pCreateInfo->deviceAddress;
    if (as->as.fallback == 0 && buffer_address(as->as.buffer) == 0)
        as->as.fallback = address_allocate(NULL, pCreateInfo->size);
}

void init_CreateAccelerationStructure2KHR(struct object *as,
                                          const VkAccelerationStructureCreateInfo2KHR *pCreateInfo)
{
    as->as.fallback = pCreateInfo->addressRange.address;
}

VkDeviceAddress null_GetAccelerationStructureDeviceAddressKHR(
    VkDevice device, const VkAccelerationStructureDeviceAddressInfoKHR *pInfo)
{
    const struct object *as = FIND(ACCELERATION_STRUCTURE_KHR, pInfo->accelerationStructure);
    if (as == NULL)
        return 0;
    /* Asked again: the buffer may have been bound since. */
    const VkDeviceAddress buffer = buffer_address(as->as.buffer);
    return buffer != 0 ? buffer + as->as.offset : as->as.fallback;
}

void null_GetAccelerationStructureBuildSizesKHR(
    VkDevice device, VkAccelerationStructureBuildTypeKHR buildType,
    const VkAccelerationStructureBuildGeometryInfoKHR *pBuildInfo,
    const uint32_t *pMaxPrimitiveCounts, VkAccelerationStructureBuildSizesInfoKHR *pSizeInfo)
{
    const struct null_driver_sizes *sizes = &CONFIG(device)->sizes;
    uint64_t primitives = 0;
    for (uint32_t i = 0; pMaxPrimitiveCounts != NULL && i < pBuildInfo->geometryCount; i++)
        primitives += pMaxPrimitiveCounts[i];
    pSizeInfo->accelerationStructureSize = size_for(&sizes->structure, primitives);
    pSizeInfo->buildScratchSize = size_for(&sizes->build_scratch, primitives);
    pSizeInfo->updateScratchSize = size_for(&sizes->update_scratch, primitives);
}

/* ---- host commands */

VkResult null_WriteAccelerationStructuresPropertiesKHR(
    VkDevice device, uint32_t accelerationStructureCount,
    const VkAccelerationStructureKHR *pAccelerationStructures, VkQueryType queryType,
    size_t dataSize, void *pData, size_t stride)
{
    query_write(CONFIG(device), accelerationStructureCount, queryType, dataSize, pData, stride);
    return VK_SUCCESS;
}
