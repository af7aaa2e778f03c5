/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: micromaps of VK_EXT_opacity_micromap. A micromap is a structure with a
 * type of its own. It lies in the table of structures, and is built and copied like a structure. */
#include <stdlib.h>

#include "layer/cpu/overlay.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/cpu/host.h"
#include "src/snapshots/build_sizes.h"
#include "src/snapshots/micromap_info.h"

static struct cpu_device *device_of(VkDevice device)
{
    return cpu_overlay_of(device)->device;
}

/* ---- objects */

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateMicromapEXT(VkDevice device,
                                                     const VkMicromapCreateInfoEXT *pCreateInfo,
                                                     const VkAllocationCallbacks *pAllocator,
                                                     VkMicromapEXT *pMicromap)
{
    const struct cpu_structure_info info = {
        .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR, .size = pCreateInfo->size};
    uint64_t handle = 0;
    (void)pAllocator;
    VkResult result = cpu_structures_add(device_of(device)->structures, &info, &handle);
    *pMicromap = result == VK_SUCCESS ? (VkMicromapEXT)handle : VK_NULL_HANDLE;
    return result;
}

VKAPI_ATTR void VKAPI_CALL cpu_DestroyMicromapEXT(VkDevice device, VkMicromapEXT micromap,
                                                  const VkAllocationCallbacks *pAllocator)
{
    cpu_DestroyAccelerationStructureKHR(device, (VkAccelerationStructureKHR)micromap, pAllocator);
}

VKAPI_ATTR void VKAPI_CALL cpu_GetMicromapBuildSizesEXT(
    VkDevice device, VkAccelerationStructureBuildTypeKHR buildType,
    const VkMicromapBuildInfoEXT *pBuildInfo, VkMicromapBuildSizesInfoEXT *pSizeInfo)
{
    struct readable_cache cache = {0};
    struct build_parameters build;
    struct builder_sizes sizes = {0};
    (void)device;
    (void)buildType; /* both types use the same builder */
    if (micromap_info_copy(&cache, pBuildInfo, &build) == VK_SUCCESS) {
        build_parameters_sizes(&build, NULL, &sizes);
        build_parameters_release(&build);
    }
    pSizeInfo->micromapSize = sizes.structure;
    pSizeInfo->buildScratchSize = 0;
    pSizeInfo->discardable = VK_FALSE; /* rays read the micromaps to which structures refer */
}

VKAPI_ATTR void VKAPI_CALL
cpu_GetDeviceMicromapCompatibilityEXT(VkDevice device, const VkMicromapVersionInfoEXT *pVersionInfo,
                                      VkAccelerationStructureCompatibilityKHR *pCompatibility)
{
    const VkAccelerationStructureVersionInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_VERSION_INFO_KHR,
        .pVersionData = pVersionInfo->pVersionData};
    cpu_GetDeviceAccelerationStructureCompatibilityKHR(device, &info, pCompatibility);
}

/* ---- copies, as those of structures */

static VkCopyAccelerationStructureModeKHR mode_of(VkCopyMicromapModeEXT mode)
{
    switch (mode) {
    case VK_COPY_MICROMAP_MODE_CLONE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR;
    case VK_COPY_MICROMAP_MODE_SERIALIZE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR;
    case VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR;
    case VK_COPY_MICROMAP_MODE_COMPACT_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    default:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_MAX_ENUM_KHR;
    }
}

static VkCopyAccelerationStructureInfoKHR copy_of(const VkCopyMicromapInfoEXT *info)
{
    return (VkCopyAccelerationStructureInfoKHR){
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = (VkAccelerationStructureKHR)info->src,
        .dst = (VkAccelerationStructureKHR)info->dst,
        .mode = mode_of(info->mode),
    };
}

static VkCopyAccelerationStructureToMemoryInfoKHR
copy_to_memory_of(const VkCopyMicromapToMemoryInfoEXT *info)
{
    return (VkCopyAccelerationStructureToMemoryInfoKHR){
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_TO_MEMORY_INFO_KHR,
        .src = (VkAccelerationStructureKHR)info->src,
        .dst = info->dst,
        .mode = mode_of(info->mode),
    };
}

static VkCopyMemoryToAccelerationStructureInfoKHR
copy_from_memory_of(const VkCopyMemoryToMicromapInfoEXT *info)
{
    return (VkCopyMemoryToAccelerationStructureInfoKHR){
        .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = info->src,
        .dst = (VkAccelerationStructureKHR)info->dst,
        .mode = mode_of(info->mode),
    };
}

/* ---- by the host */

VKAPI_ATTR VkResult VKAPI_CALL cpu_BuildMicromapsEXT(VkDevice device,
                                                     VkDeferredOperationKHR deferredOperation,
                                                     uint32_t infoCount,
                                                     const VkMicromapBuildInfoEXT *pInfos)
{
    return cpu_host_build_micromaps(device_of(device), (uint64_t)deferredOperation, infoCount,
                                    pInfos);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CopyMicromapEXT(VkDevice device,
                                                   VkDeferredOperationKHR deferredOperation,
                                                   const VkCopyMicromapInfoEXT *pInfo)
{
    const VkCopyAccelerationStructureInfoKHR info = copy_of(pInfo);
    return cpu_CopyAccelerationStructureKHR(device, deferredOperation, &info);
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_CopyMicromapToMemoryEXT(VkDevice device, VkDeferredOperationKHR deferredOperation,
                            const VkCopyMicromapToMemoryInfoEXT *pInfo)
{
    const VkCopyAccelerationStructureToMemoryInfoKHR info = copy_to_memory_of(pInfo);
    return cpu_CopyAccelerationStructureToMemoryKHR(device, deferredOperation, &info);
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_CopyMemoryToMicromapEXT(VkDevice device, VkDeferredOperationKHR deferredOperation,
                            const VkCopyMemoryToMicromapInfoEXT *pInfo)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info = copy_from_memory_of(pInfo);
    return cpu_CopyMemoryToAccelerationStructureKHR(device, deferredOperation, &info);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_WriteMicromapsPropertiesEXT(
    VkDevice device, uint32_t micromapCount, const VkMicromapEXT *pMicromaps, VkQueryType queryType,
    size_t dataSize, void *pData, size_t stride)
{
    return cpu_host_write_properties(device_of(device), micromapCount,
                                     (const VkAccelerationStructureKHR *)pMicromaps, queryType,
                                     dataSize, pData, stride);
}

/* ---- in command buffers */

static struct recorded_build *copy_parameters(struct recorder *recorder,
                                              const VkMicromapBuildInfoEXT *info)
{
    struct recorded_build *build = calloc(1, sizeof(*build));
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    if (build)
        result = micromap_info_copy(readable_cache_of_thread(), info, &build->parameters);
    if (result == VK_SUCCESS)
        return build;
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY)
        recorder_fail(recorder);
    free(build);
    return NULL;
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdBuildMicromapsEXT(VkCommandBuffer commandBuffer,
                                                    uint32_t infoCount,
                                                    const VkMicromapBuildInfoEXT *pInfos)
{
    struct recorder recorder;
    if (!recorder_begin(&recorder, commandBuffer))
        return;
    for (uint32_t i = 0; i < infoCount; i++) {
        struct recorded_build *build = copy_parameters(&recorder, &pInfos[i]);
        if (build)
            recorder_add_build(&recorder, build);
    }
    recorder_end(&recorder);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdCopyMicromapEXT(VkCommandBuffer commandBuffer,
                                                  const VkCopyMicromapInfoEXT *pInfo)
{
    const VkCopyAccelerationStructureInfoKHR info = copy_of(pInfo);
    cpu_CmdCopyAccelerationStructureKHR(commandBuffer, &info);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdCopyMicromapToMemoryEXT(
    VkCommandBuffer commandBuffer, const VkCopyMicromapToMemoryInfoEXT *pInfo)
{
    if (!layer_find_recording_device(commandBuffer))
        return;
    const VkCopyAccelerationStructureToMemoryInfoKHR info = copy_to_memory_of(pInfo);
    cpu_CmdCopyAccelerationStructureToMemoryKHR(commandBuffer, &info);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdCopyMemoryToMicromapEXT(
    VkCommandBuffer commandBuffer, const VkCopyMemoryToMicromapInfoEXT *pInfo)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info = copy_from_memory_of(pInfo);
    cpu_CmdCopyMemoryToAccelerationStructureKHR(commandBuffer, &info);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdWriteMicromapsPropertiesEXT(
    VkCommandBuffer commandBuffer, uint32_t micromapCount, const VkMicromapEXT *pMicromaps,
    VkQueryType queryType, VkQueryPool queryPool, uint32_t firstQuery)
{
    cpu_CmdWriteAccelerationStructuresPropertiesKHR(commandBuffer, micromapCount,
                                                    (const VkAccelerationStructureKHR *)pMicromaps,
                                                    queryType, queryPool, firstQuery);
}
