/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: host builds, copies and queries, and queries of sizes and compatibility.
 */
#include "layer/cpu/overlay.h"
#include "observers.h"
#include "src/cpu/host.h"
#include "src/snapshots/build_parameters.h"
#include "src/snapshots/build_sizes.h"

#include <string.h>

static struct cpu_device *device_of(VkDevice device)
{
    return cpu_overlay_of(device)->device;
}

VKAPI_ATTR void VKAPI_CALL cpu_GetAccelerationStructureBuildSizesKHR(
    VkDevice device, VkAccelerationStructureBuildTypeKHR buildType,
    const VkAccelerationStructureBuildGeometryInfoKHR *pBuildInfo,
    const uint32_t *pMaxPrimitiveCounts, VkAccelerationStructureBuildSizesInfoKHR *pSizeInfo)
{
    struct builder_sizes sizes;
    (void)device;
    (void)buildType; /* both types use the same builder */
    cpu_build_sizes(pBuildInfo, pMaxPrimitiveCounts, &sizes);
    pSizeInfo->accelerationStructureSize = sizes.structure;
    pSizeInfo->buildScratchSize = sizes.build_scratch + (sizes.structure ? CPU_SCRATCH_SLACK : 0);
    pSizeInfo->updateScratchSize = sizes.update_scratch + (sizes.structure ? CPU_SCRATCH_SLACK : 0);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_BuildAccelerationStructuresKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    return cpu_host_build(device_of(device), (uint64_t)deferredOperation, infoCount, pInfos,
                          ppBuildRangeInfos);
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_CopyAccelerationStructureKHR(VkDevice device, VkDeferredOperationKHR deferredOperation,
                                 const VkCopyAccelerationStructureInfoKHR *pInfo)
{
    return cpu_host_copy(device_of(device), (uint64_t)deferredOperation, pInfo);
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_CopyAccelerationStructureToMemoryKHR(VkDevice device, VkDeferredOperationKHR deferredOperation,
                                         const VkCopyAccelerationStructureToMemoryInfoKHR *pInfo)
{
    return cpu_host_serialize(device_of(device), (uint64_t)deferredOperation, pInfo);
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_CopyMemoryToAccelerationStructureKHR(VkDevice device, VkDeferredOperationKHR deferredOperation,
                                         const VkCopyMemoryToAccelerationStructureInfoKHR *pInfo)
{
    return cpu_host_deserialize(device_of(device), (uint64_t)deferredOperation, pInfo);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_WriteAccelerationStructuresPropertiesKHR(
    VkDevice device, uint32_t accelerationStructureCount,
    const VkAccelerationStructureKHR *pAccelerationStructures, VkQueryType queryType,
    size_t dataSize, void *pData, size_t stride)
{
    return cpu_host_write_properties(device_of(device), accelerationStructureCount,
                                     pAccelerationStructures, queryType, dataSize, pData, stride);
}

VKAPI_ATTR void VKAPI_CALL cpu_GetDeviceAccelerationStructureCompatibilityKHR(
    VkDevice device, const VkAccelerationStructureVersionInfoKHR *pVersionInfo,
    VkAccelerationStructureCompatibilityKHR *pCompatibility)
{
    const struct builder_uuids *uuids = &device_of(device)->uuids;
    struct readable_cache cache = {0};
    bool is_same = readable(&cache, pVersionInfo->pVersionData, sizeof(*uuids)) &&
                   memcmp(pVersionInfo->pVersionData, uuids, sizeof(*uuids)) == 0;
    *pCompatibility = is_same ? VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR
                              : VK_ACCELERATION_STRUCTURE_COMPATIBILITY_INCOMPATIBLE_KHR;
}
