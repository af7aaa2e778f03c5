/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: builds in command buffers. The snapshots, which cover these commands,
 * have recorded the inputs. The BVH is built on first use. */
#include "layer/cpu/overlay.h"
#include "observers.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"

VKAPI_ATTR void VKAPI_CALL cpu_CmdBuildAccelerationStructuresKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdBuildAccelerationStructuresIndirectKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkDeviceAddress *pIndirectDeviceAddresses, const uint32_t *pIndirectStrides,
    const uint32_t *const *ppMaxPrimitiveCounts)
{
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdBuildAccelerationStructureNV(
    VkCommandBuffer commandBuffer, const VkAccelerationStructureInfoNV *pInfo,
    VkBuffer instanceData, VkDeviceSize instanceOffset, VkBool32 update,
    VkAccelerationStructureNV dst, VkAccelerationStructureNV src, VkBuffer scratch,
    VkDeviceSize scratchOffset)
{
}

/* Reports lack of memory during recording. */
VKAPI_ATTR VkResult VKAPI_CALL cpu_EndCommandBuffer(VkCommandBuffer commandBuffer)
{
    const struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return VK_ERROR_VALIDATION_FAILED_EXT;
    const struct command_buffer *command_buffer =
        command_buffers_find(device->command_buffers, commandBuffer);
    VkResult result = device->cpu->next.EndCommandBuffer(commandBuffer);
    return result == VK_SUCCESS && command_buffer && command_buffer->work_failed
               ? VK_ERROR_OUT_OF_HOST_MEMORY
               : result;
}
