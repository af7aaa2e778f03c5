/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: render passes. Stages and accesses of ray tracing in their dependencies
 * are translated for the driver. Render passes without such bits go down unchanged. */
#include "layer/cpu/driver/block.h"
#include "layer/cpu/driver/masks.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/chain_copy.h"

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
