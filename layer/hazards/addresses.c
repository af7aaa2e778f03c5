/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies, fills, updates and markers by address (VK_KHR_device_address_commands). */
#include "layer/hazards/commands.h"
#include "layer/hazards/recording.h"

static void add(struct hazard_recording *recording, enum access_kind kind, enum hazard_role role,
                VkDeviceAddress address, VkDeviceSize size)
{
    struct address_facts facts;
    const struct hazard_use use = {.kind = kind, .role = role};
    resources_look_up_address(recording->device->resources, address, &facts);
    hazard_recording_add_address(recording, &use, &facts, 0, size);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyMemoryKHR(VkCommandBuffer commandBuffer,
                                                    const VkCopyDeviceMemoryInfoKHR *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdCopyMemoryKHR")) {
        for (uint32_t i = 0; i < pInfo->regionCount; i++) {
            const VkDeviceMemoryCopyKHR *region = &pInfo->pRegions[i];
            add(&recording, ACCESS_TRANSFER_READ, HAZARD_SRC, region->srcRange.address,
                region->srcRange.size);
            add(&recording, ACCESS_TRANSFER_WRITE, HAZARD_DST, region->dstRange.address,
                region->dstRange.size);
        }
    }
    device->vk.CmdCopyMemoryKHR(commandBuffer, pInfo);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdUpdateMemoryKHR(VkCommandBuffer commandBuffer,
                                                      const VkDeviceAddressRangeKHR *pDstRange,
                                                      VkAddressCommandFlagsKHR dstFlags,
                                                      VkDeviceSize dataSize, const void *pData)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdUpdateMemoryKHR"))
        add(&recording, ACCESS_FILL_WRITE, HAZARD_DST, pDstRange->address, dataSize);
    device->vk.CmdUpdateMemoryKHR(commandBuffer, pDstRange, dstFlags, dataSize, pData);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdFillMemoryKHR(VkCommandBuffer commandBuffer,
                                                    const VkDeviceAddressRangeKHR *pDstRange,
                                                    VkAddressCommandFlagsKHR dstFlags,
                                                    uint32_t data)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdFillMemoryKHR"))
        add(&recording, ACCESS_FILL_WRITE, HAZARD_DST, pDstRange->address, pDstRange->size / 4 * 4);
    device->vk.CmdFillMemoryKHR(commandBuffer, pDstRange, dstFlags, data);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdWriteMarkerToMemoryAMD(VkCommandBuffer commandBuffer,
                                                             const VkMemoryMarkerInfoAMD *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdWriteMarkerToMemoryAMD"))
        add(&recording, ACCESS_MARKER_WRITE, HAZARD_DST, pInfo->dstRange.address,
            sizeof(pInfo->marker));
    device->vk.CmdWriteMarkerToMemoryAMD(commandBuffer, pInfo);
}
