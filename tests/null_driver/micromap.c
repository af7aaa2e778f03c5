/* SPDX-License-Identifier: Apache-2.0 */
/* EXT micromaps: handles and sizes. Builds and copies look at nothing. */
#include "internal.h"

VkResult null_CreateMicromapEXT(VkDevice device, const VkMicromapCreateInfoEXT *pCreateInfo,
                                const VkAllocationCallbacks *pAllocator, VkMicromapEXT *pMicromap)
{
    ENTER_OR_FAIL(CreateMicromapEXT);
    (void)pCreateInfo;
    (void)pAllocator;
    const struct object *micromap = object_create(OBJECT(device), TYPE_MICROMAP, NULL);
    if (micromap == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    *pMicromap = HANDLE(VkMicromapEXT, micromap->handle);
    return VK_SUCCESS;
}

void null_DestroyMicromapEXT(VkDevice device, VkMicromapEXT micromap,
                             const VkAllocationCallbacks *pAllocator)
{
    ENTER(DestroyMicromapEXT);
    (void)device;
    (void)pAllocator;
    object_destroy(RAW(micromap), TYPE_MICROMAP);
}

void null_GetMicromapBuildSizesEXT(VkDevice device, VkAccelerationStructureBuildTypeKHR buildType,
                                   const VkMicromapBuildInfoEXT *pBuildInfo,
                                   VkMicromapBuildSizesInfoEXT *pSizeInfo)
{
    ENTER(GetMicromapBuildSizesEXT);
    (void)buildType;
    (void)pBuildInfo;
    pSizeInfo->micromapSize = CONFIG(device)->sizes.micromap;
    pSizeInfo->buildScratchSize = CONFIG(device)->sizes.micromap_scratch;
    pSizeInfo->discardable = VK_FALSE;
}

void null_GetDeviceMicromapCompatibilityEXT(VkDevice device,
                                            const VkMicromapVersionInfoEXT *pVersionInfo,
                                            VkAccelerationStructureCompatibilityKHR *pCompatibility)
{
    ENTER(GetDeviceMicromapCompatibilityEXT);
    (void)device;
    (void)pVersionInfo;
    *pCompatibility = VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR;
}

VkResult null_BuildMicromapsEXT(VkDevice device, VkDeferredOperationKHR deferredOperation,
                                uint32_t infoCount, const VkMicromapBuildInfoEXT *pInfos)
{
    ENTER_OR_FAIL(BuildMicromapsEXT);
    (void)infoCount;
    (void)pInfos;
    return deferred_start(device, deferredOperation);
}

#define HOST_COPY(name, info_type)                                                                 \
    VkResult null_##name(VkDevice device, VkDeferredOperationKHR deferredOperation,                \
                         const info_type *pInfo)                                                   \
    {                                                                                              \
        ENTER_OR_FAIL(name);                                                                       \
        (void)pInfo;                                                                               \
        return deferred_start(device, deferredOperation);                                          \
    }

HOST_COPY(CopyMicromapEXT, VkCopyMicromapInfoEXT)
HOST_COPY(CopyMicromapToMemoryEXT, VkCopyMicromapToMemoryInfoEXT)
HOST_COPY(CopyMemoryToMicromapEXT, VkCopyMemoryToMicromapInfoEXT)

VkResult null_WriteMicromapsPropertiesEXT(VkDevice device, uint32_t micromapCount,
                                          const VkMicromapEXT *pMicromaps, VkQueryType queryType,
                                          size_t dataSize, void *pData, size_t stride)
{
    ENTER_OR_FAIL(WriteMicromapsPropertiesEXT);
    (void)pMicromaps;
    query_write(CONFIG(device), micromapCount, queryType, dataSize, pData, stride);
    return VK_SUCCESS;
}
