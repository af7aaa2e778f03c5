/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: barriers and waits for events of Vulkan 1.0. Their stages and accesses of ray
 * tracing are translated for the driver. A call without such bits goes down unchanged. So does a
 * call with more barriers than fit on the stack, if memory runs out. */
#include "layer/cpu/driver/block.h"
#include "layer/cpu/driver/masks.h"
#include "observers.h"

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
