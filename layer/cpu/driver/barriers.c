/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: barriers, and waits for events. Their stages and accesses of ray tracing are
 * translated for the driver. A call without such bits goes down unchanged. So does a call with
 * more barriers than fit on the stack, if memory runs out. */
#include "layer/cpu/driver/masks.h"
#include "observers.h"
#include "src/base/block.h"
#include "src/base/chain.h"

/* The common parameters of vkCmdPipelineBarrier and vkCmdWaitEvents. */
struct dependency {
    VkPipelineStageFlags src, dst;
    uint32_t memory_count, buffer_count, image_count;
    const VkMemoryBarrier *memory;
    const VkBufferMemoryBarrier *buffers;
    const VkImageMemoryBarrier *images;
};

static bool accesses_of_pair_trace(VkAccessFlags src, VkAccessFlags dst)
{
    return accesses_trace(src) || accesses_trace(dst);
}

static bool dependency_traces(const struct dependency *dependency)
{
    bool found = stages_trace(dependency->src) || stages_trace(dependency->dst);
    for (uint32_t i = 0; i < dependency->memory_count && !found; i++)
        found = accesses_of_pair_trace(dependency->memory[i].srcAccessMask,
                                       dependency->memory[i].dstAccessMask);
    for (uint32_t i = 0; i < dependency->buffer_count && !found; i++)
        found = accesses_of_pair_trace(dependency->buffers[i].srcAccessMask,
                                       dependency->buffers[i].dstAccessMask);
    for (uint32_t i = 0; i < dependency->image_count && !found; i++)
        found = accesses_of_pair_trace(dependency->images[i].srcAccessMask,
                                       dependency->images[i].dstAccessMask);
    return found;
}

static void translate_accesses(const struct dependency *dependency, VkAccessFlags *src,
                               VkAccessFlags *dst)
{
    *src = (VkAccessFlags)accesses_below(dependency->src, *src);
    *dst = (VkAccessFlags)accesses_below(dependency->dst, *dst);
}

/* Translates the dependency for the driver, with copies in the block, which the caller ends. */
static void dependency_begin(struct block *block, struct dependency *dependency)
{
    const bool traces = dependency_traces(dependency);
    const size_t size = block_size(dependency->memory_count, sizeof(VkMemoryBarrier)) +
                        block_size(dependency->buffer_count, sizeof(VkBufferMemoryBarrier)) +
                        block_size(dependency->image_count, sizeof(VkImageMemoryBarrier));
    if (!block_begin(block, traces ? size : 0) || !traces)
        return;
    VkMemoryBarrier *memory =
        block_copy(block, dependency->memory, dependency->memory_count, sizeof(*memory));
    for (uint32_t i = 0; i < dependency->memory_count; i++)
        translate_accesses(dependency, &memory[i].srcAccessMask, &memory[i].dstAccessMask);
    VkBufferMemoryBarrier *buffers =
        block_copy(block, dependency->buffers, dependency->buffer_count, sizeof(*buffers));
    for (uint32_t i = 0; i < dependency->buffer_count; i++)
        translate_accesses(dependency, &buffers[i].srcAccessMask, &buffers[i].dstAccessMask);
    VkImageMemoryBarrier *images =
        block_copy(block, dependency->images, dependency->image_count, sizeof(*images));
    for (uint32_t i = 0; i < dependency->image_count; i++)
        translate_accesses(dependency, &images[i].srcAccessMask, &images[i].dstAccessMask);
    dependency->memory = memory;
    dependency->buffers = buffers;
    dependency->images = images;
    dependency->src = (VkPipelineStageFlags)stages_below(dependency->src);
    dependency->dst = (VkPipelineStageFlags)stages_below(dependency->dst);
}

void cpu_add_barriers(PFN_vkCmdPipelineBarrier down, VkCommandBuffer commands,
                      VkPipelineStageFlags src, VkPipelineStageFlags dst, VkDependencyFlags flags,
                      uint32_t memory_count, const VkMemoryBarrier *memory, uint32_t buffer_count,
                      const VkBufferMemoryBarrier *buffers, uint32_t image_count,
                      const VkImageMemoryBarrier *images)
{
    struct dependency below = {
        .src = src,
        .dst = dst,
        .memory_count = memory_count,
        .buffer_count = buffer_count,
        .image_count = image_count,
        .memory = memory,
        .buffers = buffers,
        .images = images,
    };
    struct block block;
    dependency_begin(&block, &below);
    down(commands, below.src, below.dst, flags, below.memory_count, below.memory,
         below.buffer_count, below.buffers, below.image_count, below.images);
    block_end(&block);
}

void cpu_wait_events(PFN_vkCmdWaitEvents down, VkCommandBuffer commands, uint32_t event_count,
                     const VkEvent *events, VkPipelineStageFlags src, VkPipelineStageFlags dst,
                     uint32_t memory_count, const VkMemoryBarrier *memory, uint32_t buffer_count,
                     const VkBufferMemoryBarrier *buffers, uint32_t image_count,
                     const VkImageMemoryBarrier *images)
{
    struct dependency below = {
        .src = src,
        .dst = dst,
        .memory_count = memory_count,
        .buffer_count = buffer_count,
        .image_count = image_count,
        .memory = memory,
        .buffers = buffers,
        .images = images,
    };
    struct block block;
    dependency_begin(&block, &below);
    down(commands, event_count, events, below.src, below.dst, below.memory_count, below.memory,
         below.buffer_count, below.buffers, below.image_count, below.images);
    block_end(&block);
}

/* ---- VK_KHR_synchronization2 */

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
