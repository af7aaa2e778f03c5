/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: barriers and events of VK_KHR_synchronization2. A call
 * without bits of ray tracing goes down unchanged. So does a call with too many barriers for the
 * stack, if memory runs out. */
#include "layer/cpu/driver/block.h"
#include "layer/cpu/driver/masks.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/chain_copy.h"

static const VkMemoryRangeBarriersInfoKHR *ranges_of(const VkDependencyInfo *info)
{
    return chain_find(info->pNext, VK_STRUCTURE_TYPE_MEMORY_RANGE_BARRIERS_INFO_KHR);
}

static bool ranges_trace(const VkMemoryRangeBarriersInfoKHR *ranges)
{
    bool found = false;
    for (uint32_t i = 0; ranges && i < ranges->memoryRangeBarrierCount && !found; i++)
        found = MASKS_TRACE(&ranges->pMemoryRangeBarriers[i]);
    return found;
}

static bool info_traces(const VkDependencyInfo *info)
{
    bool found = ranges_trace(ranges_of(info));
    for (uint32_t i = 0; i < info->memoryBarrierCount && !found; i++)
        found = MASKS_TRACE(&info->pMemoryBarriers[i]);
    for (uint32_t i = 0; i < info->bufferMemoryBarrierCount && !found; i++)
        found = MASKS_TRACE(&info->pBufferMemoryBarriers[i]);
    for (uint32_t i = 0; i < info->imageMemoryBarrierCount && !found; i++)
        found = MASKS_TRACE(&info->pImageMemoryBarriers[i]);
    return found;
}

/* The VkDependencyInfo of one call, translated for the driver. */
struct dependencies {
    const VkDependencyInfo *infos; /* passed to the driver */
    struct block block;
    struct chain_copy *chains; /* copies for the first `chain_count` infos */
    uint32_t chain_count;
};

static size_t size_of(const VkDependencyInfo *info)
{
    const VkMemoryRangeBarriersInfoKHR *ranges = ranges_of(info);
    return block_size(info->memoryBarrierCount, sizeof(VkMemoryBarrier2)) +
           block_size(info->bufferMemoryBarrierCount, sizeof(VkBufferMemoryBarrier2)) +
           block_size(info->imageMemoryBarrierCount, sizeof(VkImageMemoryBarrier2)) +
           block_size(ranges ? ranges->memoryRangeBarrierCount : 0,
                      sizeof(VkMemoryRangeBarrierKHR));
}

static VkResult translate_ranges(struct dependencies *dependencies, VkDependencyInfo *info)
{
    struct chain_copy *chain = &dependencies->chains[dependencies->chain_count];
    VkResult result =
        chain_copy_begin(chain, info->pNext, VK_STRUCTURE_TYPE_MEMORY_RANGE_BARRIERS_INFO_KHR);
    if (result != VK_SUCCESS)
        return result;
    dependencies->chain_count++;
    info->pNext = chain->first;
    VkMemoryRangeBarriersInfoKHR *ranges = chain->found;
    if (!ranges)
        return VK_SUCCESS;
    VkMemoryRangeBarrierKHR *barriers =
        block_copy(&dependencies->block, ranges->pMemoryRangeBarriers,
                   ranges->memoryRangeBarrierCount, sizeof(*barriers));
    for (uint32_t i = 0; i < ranges->memoryRangeBarrierCount; i++)
        MASKS_TRANSLATE(&barriers[i]);
    ranges->pMemoryRangeBarriers = barriers;
    return VK_SUCCESS;
}

static VkResult translate(struct dependencies *dependencies, VkDependencyInfo *info)
{
    struct block *block = &dependencies->block;
    VkMemoryBarrier2 *memory =
        block_copy(block, info->pMemoryBarriers, info->memoryBarrierCount, sizeof(*memory));
    for (uint32_t i = 0; i < info->memoryBarrierCount; i++)
        MASKS_TRANSLATE(&memory[i]);
    VkBufferMemoryBarrier2 *buffers = block_copy(block, info->pBufferMemoryBarriers,
                                                 info->bufferMemoryBarrierCount, sizeof(*buffers));
    for (uint32_t i = 0; i < info->bufferMemoryBarrierCount; i++)
        MASKS_TRANSLATE(&buffers[i]);
    VkImageMemoryBarrier2 *images = block_copy(block, info->pImageMemoryBarriers,
                                               info->imageMemoryBarrierCount, sizeof(*images));
    for (uint32_t i = 0; i < info->imageMemoryBarrierCount; i++)
        MASKS_TRANSLATE(&images[i]);
    info->pMemoryBarriers = memory;
    info->pBufferMemoryBarriers = buffers;
    info->pImageMemoryBarriers = images;
    return translate_ranges(dependencies, info);
}

/* Translates the infos. The caller calls dependencies_end(). */
static void dependencies_begin(struct dependencies *dependencies, uint32_t count,
                               const VkDependencyInfo *infos)
{
    size_t size =
        block_size(count, sizeof(VkDependencyInfo)) + block_size(count, sizeof(struct chain_copy));
    bool traces = false;
    dependencies->infos = infos;
    dependencies->chain_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        traces |= info_traces(&infos[i]);
        size += size_of(&infos[i]);
    }
    if (!block_begin(&dependencies->block, traces ? size : 0) || !traces)
        return;
    VkDependencyInfo *below = block_copy(&dependencies->block, infos, count, sizeof(*below));
    dependencies->chains = block_take(&dependencies->block, count, sizeof(*dependencies->chains));
    for (uint32_t i = 0; i < count; i++)
        if (translate(dependencies, &below[i]) != VK_SUCCESS)
            return;
    dependencies->infos = below;
}

static void dependencies_end(struct dependencies *dependencies)
{
    for (uint32_t i = 0; i < dependencies->chain_count; i++)
        chain_copy_end(&dependencies->chains[i]);
    block_end(&dependencies->block);
}

void cpu_add_barriers_2(PFN_vkCmdPipelineBarrier2 down, VkCommandBuffer commands,
                        const VkDependencyInfo *info)
{
    struct dependencies below;
    dependencies_begin(&below, 1, info);
    down(commands, below.infos);
    dependencies_end(&below);
}

void cpu_set_event_2(PFN_vkCmdSetEvent2 down, VkCommandBuffer commands, VkEvent event,
                     const VkDependencyInfo *info)
{
    struct dependencies below;
    dependencies_begin(&below, 1, info);
    down(commands, event, below.infos);
    dependencies_end(&below);
}

void cpu_wait_events_2(PFN_vkCmdWaitEvents2 down, VkCommandBuffer commands, uint32_t count,
                       const VkEvent *events, const VkDependencyInfo *infos)
{
    struct dependencies below;
    dependencies_begin(&below, count, infos);
    down(commands, count, events, below.infos);
    dependencies_end(&below);
}
