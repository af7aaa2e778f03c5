/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies, fills, updates and markers by address (VK_KHR_device_address_commands). */
#include "layer/hazards/recording.h"
#include "observers.h"

static void add(struct hazard_recording *recording, enum access_kind kind, enum hazard_role role,
                VkDeviceAddress address, VkDeviceSize size)
{
    struct address_facts facts;
    const struct hazard_use use = {.kind = kind, .role = role};
    resources_look_up_address(recording->device->resources, address, &facts);
    hazard_recording_add_address(recording, &use, &facts, 0, size);
}

void hazards_copy_memory(struct hazard_recording *recording, const VkCopyDeviceMemoryInfoKHR *info)
{
    for (uint32_t i = 0; i < info->regionCount; i++) {
        const VkDeviceMemoryCopyKHR *region = &info->pRegions[i];
        add(recording, ACCESS_TRANSFER_READ, HAZARD_SRC, region->srcRange.address,
            region->srcRange.size);
        add(recording, ACCESS_TRANSFER_WRITE, HAZARD_DST, region->dstRange.address,
            region->dstRange.size);
    }
}

void hazards_update_memory(struct hazard_recording *recording, const VkDeviceAddressRangeKHR *dst,
                           VkDeviceSize size)
{
    add(recording, ACCESS_FILL_WRITE, HAZARD_DST, dst->address, size);
}

void hazards_fill_memory(struct hazard_recording *recording, const VkDeviceAddressRangeKHR *dst)
{
    add(recording, ACCESS_FILL_WRITE, HAZARD_DST, dst->address, dst->size / 4 * 4);
}

void hazards_write_memory_marker(struct hazard_recording *recording,
                                 const VkMemoryMarkerInfoAMD *info)
{
    add(recording, ACCESS_MARKER_WRITE, HAZARD_DST, info->dstRange.address, sizeof(info->marker));
}
