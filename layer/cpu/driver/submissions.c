/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: render passes and submissions. Stages and accesses of ray tracing in dependencies,
 * and stages of semaphores, are translated for the driver. What has no such bits goes down
 * unchanged. */
#include "layer/cpu/driver/masks.h"
#include "observers.h"
#include "src/base/block.h"
#include "src/base/chain.h"

VkResult cpu_create_render_pass(PFN_vkCreateRenderPass down, VkDevice device,
                                const VkRenderPassCreateInfo *create_info,
                                const VkAllocationCallbacks *allocator, VkRenderPass *render_pass)
{
    bool traces = false;
    for (uint32_t i = 0; i < create_info->dependencyCount && !traces; i++)
        traces = MASKS_TRACE(&create_info->pDependencies[i]);
    if (!traces)
        return down(device, create_info, allocator, render_pass);
    VkRenderPassCreateInfo below = *create_info;
    struct block block;
    if (!block_begin(&block, block_size(below.dependencyCount, sizeof(VkSubpassDependency))))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubpassDependency *dependencies =
        block_copy(&block, below.pDependencies, below.dependencyCount, sizeof(*dependencies));
    for (uint32_t i = 0; i < below.dependencyCount; i++)
        MASKS_TRANSLATE(&dependencies[i]);
    below.pDependencies = dependencies;
    VkResult result = down(device, &below, allocator, render_pass);
    block_end(&block);
    return result;
}

/* A barrier in the chain replaces the dependency's own masks. */
static bool dependency2_traces(const VkSubpassDependency2 *dependency)
{
    const VkMemoryBarrier2 *barrier =
        chain_find(dependency->pNext, VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
    return MASKS_TRACE(dependency) || (barrier && MASKS_TRACE(barrier));
}

static VkResult translate_dependency2(VkSubpassDependency2 *dependency, struct chain_copy *chain)
{
    MASKS_TRANSLATE(dependency);
    VkResult result =
        chain_copy_begin(chain, dependency->pNext, VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
    if (result != VK_SUCCESS)
        return result;
    VkMemoryBarrier2 *barrier = chain->found;
    if (barrier)
        MASKS_TRANSLATE(barrier);
    dependency->pNext = chain->first;
    return VK_SUCCESS;
}

VkResult cpu_create_render_pass_2(PFN_vkCreateRenderPass2 down, VkDevice device,
                                  const VkRenderPassCreateInfo2 *create_info,
                                  const VkAllocationCallbacks *allocator, VkRenderPass *render_pass)
{
    VkRenderPassCreateInfo2 below = *create_info;
    const uint32_t count = below.dependencyCount;
    bool traces = false;
    for (uint32_t i = 0; i < count && !traces; i++)
        traces = dependency2_traces(&below.pDependencies[i]);
    if (!traces)
        return down(device, create_info, allocator, render_pass);
    struct block block;
    if (!block_begin(&block, block_size(count, sizeof(VkSubpassDependency2)) +
                                 block_size(count, sizeof(struct chain_copy))))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubpassDependency2 *dependencies =
        block_copy(&block, below.pDependencies, count, sizeof(*dependencies));
    struct chain_copy *chains = block_take(&block, count, sizeof(*chains));
    VkResult result = VK_SUCCESS;
    uint32_t done = 0;
    while (done < count && result == VK_SUCCESS) {
        result = translate_dependency2(&dependencies[done], &chains[done]);
        done++;
    }
    below.pDependencies = dependencies;
    if (result == VK_SUCCESS)
        result = down(device, &below, allocator, render_pass);
    while (done-- > 0)
        chain_copy_end(&chains[done]);
    block_end(&block);
    return result;
}

/* ---- submissions */

/* ---- vkQueueSubmit */

static bool waits_trace(const VkSubmitInfo *submit)
{
    bool found = false;
    for (uint32_t i = 0; i < submit->waitSemaphoreCount && !found; i++)
        found = stages_trace(submit->pWaitDstStageMask[i]);
    return found;
}

static void translate_waits(struct block *block, VkSubmitInfo *submit)
{
    VkPipelineStageFlags *stages =
        block_copy(block, submit->pWaitDstStageMask, submit->waitSemaphoreCount, sizeof(*stages));
    for (uint32_t i = 0; i < submit->waitSemaphoreCount; i++)
        stages[i] = (VkPipelineStageFlags)stages_below(stages[i]);
    submit->pWaitDstStageMask = stages;
}

VkResult cpu_submit(PFN_vkQueueSubmit down, VkQueue queue, uint32_t count,
                    const VkSubmitInfo *submits, VkFence fence)
{
    size_t size = block_size(count, sizeof(VkSubmitInfo));
    bool traces = false;
    for (uint32_t i = 0; i < count; i++) {
        traces |= waits_trace(&submits[i]);
        size += block_size(submits[i].waitSemaphoreCount, sizeof(VkPipelineStageFlags));
    }
    if (!traces)
        return down(queue, count, submits, fence);
    struct block block;
    if (!block_begin(&block, size))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubmitInfo *below = block_copy(&block, submits, count, sizeof(*below));
    for (uint32_t i = 0; i < count; i++)
        translate_waits(&block, &below[i]);
    VkResult result = down(queue, count, below, fence);
    block_end(&block);
    return result;
}

/* ---- vkQueueSubmit2 */

static bool semaphores_trace(uint32_t count, const VkSemaphoreSubmitInfo *semaphores)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = stages_trace(semaphores[i].stageMask);
    return found;
}

static const VkSemaphoreSubmitInfo *translate_semaphores(struct block *block, uint32_t count,
                                                         const VkSemaphoreSubmitInfo *semaphores)
{
    VkSemaphoreSubmitInfo *below = block_copy(block, semaphores, count, sizeof(*below));
    for (uint32_t i = 0; i < count; i++)
        below[i].stageMask = stages_below(below[i].stageMask);
    return below;
}

VkResult cpu_submit_2(PFN_vkQueueSubmit2 down, VkQueue queue, uint32_t count,
                      const VkSubmitInfo2 *submits, VkFence fence)
{
    size_t size = block_size(count, sizeof(VkSubmitInfo2));
    bool traces = false;
    for (uint32_t i = 0; i < count; i++) {
        const VkSubmitInfo2 *info = &submits[i];
        traces |= semaphores_trace(info->waitSemaphoreInfoCount, info->pWaitSemaphoreInfos) ||
                  semaphores_trace(info->signalSemaphoreInfoCount, info->pSignalSemaphoreInfos);
        size += block_size(info->waitSemaphoreInfoCount, sizeof(VkSemaphoreSubmitInfo)) +
                block_size(info->signalSemaphoreInfoCount, sizeof(VkSemaphoreSubmitInfo));
    }
    if (!traces)
        return down(queue, count, submits, fence);
    struct block block;
    if (!block_begin(&block, size))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubmitInfo2 *below = block_copy(&block, submits, count, sizeof(*below));
    for (uint32_t i = 0; i < count; i++) {
        below[i].pWaitSemaphoreInfos = translate_semaphores(&block, below[i].waitSemaphoreInfoCount,
                                                            below[i].pWaitSemaphoreInfos);
        below[i].pSignalSemaphoreInfos = translate_semaphores(
            &block, below[i].signalSemaphoreInfoCount, below[i].pSignalSemaphoreInfos);
    }
    VkResult result = down(queue, count, below, fence);
    block_end(&block);
    return result;
}
