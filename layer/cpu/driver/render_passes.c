/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: render passes. Stages and accesses of ray tracing in their dependencies
 * are translated for the driver. Render passes without such bits go down unchanged. */
#include "layer/cpu/driver/block.h"
#include "layer/cpu/driver/masks.h"
#include "layer/cpu/overlay.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/chain_copy.h"

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateRenderPass(VkDevice device,
                                                    const VkRenderPassCreateInfo *pCreateInfo,
                                                    const VkAllocationCallbacks *pAllocator,
                                                    VkRenderPass *pRenderPass)
{
    const VkuDeviceDispatchTable *next = cpu_next(device);
    bool traces = false;
    for (uint32_t i = 0; i < pCreateInfo->dependencyCount && !traces; i++)
        traces = MASKS_TRACE(&pCreateInfo->pDependencies[i]);
    if (!traces)
        return next->CreateRenderPass(device, pCreateInfo, pAllocator, pRenderPass);
    VkRenderPassCreateInfo below = *pCreateInfo;
    struct block block;
    if (!block_begin(&block, block_size(below.dependencyCount, sizeof(VkSubpassDependency))))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkSubpassDependency *dependencies =
        block_copy(&block, below.pDependencies, below.dependencyCount, sizeof(*dependencies));
    for (uint32_t i = 0; i < below.dependencyCount; i++)
        MASKS_TRANSLATE(&dependencies[i]);
    below.pDependencies = dependencies;
    VkResult result = next->CreateRenderPass(device, &below, pAllocator, pRenderPass);
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

static VkResult create_render_pass2(VkDevice device, PFN_vkCreateRenderPass2 create,
                                    const VkRenderPassCreateInfo2 *create_info,
                                    const VkAllocationCallbacks *allocator,
                                    VkRenderPass *render_pass)
{
    VkRenderPassCreateInfo2 below = *create_info;
    const uint32_t count = below.dependencyCount;
    bool traces = false;
    for (uint32_t i = 0; i < count && !traces; i++)
        traces = dependency2_traces(&below.pDependencies[i]);
    if (!traces)
        return create(device, create_info, allocator, render_pass);
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
        result = create(device, &below, allocator, render_pass);
    while (done-- > 0)
        chain_copy_end(&chains[done]);
    block_end(&block);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateRenderPass2(VkDevice device,
                                                     const VkRenderPassCreateInfo2 *pCreateInfo,
                                                     const VkAllocationCallbacks *pAllocator,
                                                     VkRenderPass *pRenderPass)
{
    return create_render_pass2(device, cpu_next(device)->CreateRenderPass2, pCreateInfo, pAllocator,
                               pRenderPass);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateRenderPass2KHR(VkDevice device,
                                                        const VkRenderPassCreateInfo2 *pCreateInfo,
                                                        const VkAllocationCallbacks *pAllocator,
                                                        VkRenderPass *pRenderPass)
{
    return create_render_pass2(device, cpu_next(device)->CreateRenderPass2KHR, pCreateInfo,
                               pAllocator, pRenderPass);
}
