/* SPDX-License-Identifier: Apache-2.0 */
/* EXT micromaps: handles and sizes. Builds and copies look at nothing. */
#include "internal.h"

void null_GetMicromapBuildSizesEXT(VkDevice device, VkAccelerationStructureBuildTypeKHR buildType,
                                   const VkMicromapBuildInfoEXT *pBuildInfo,
                                   VkMicromapBuildSizesInfoEXT *pSizeInfo)
{
    pSizeInfo->micromapSize = CONFIG(device)->sizes.micromap;
    pSizeInfo->buildScratchSize = CONFIG(device)->sizes.micromap_scratch;
    pSizeInfo->discardable = VK_FALSE;
}

VkResult null_WriteMicromapsPropertiesEXT(VkDevice device, uint32_t micromapCount,
                                          const VkMicromapEXT *pMicromaps, VkQueryType queryType,
                                          size_t dataSize, void *pData, size_t stride)
{
    query_write(CONFIG(device), micromapCount, queryType, dataSize, pData, stride);
    return VK_SUCCESS;
}
