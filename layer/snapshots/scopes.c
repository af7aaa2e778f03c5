/* SPDX-License-Identifier: Apache-2.0 */
/* Commands between which a dispatch of the layer's own would be counted, or left out, or disturb
 * what can't be restored. */
#include "snapshots/commands.h"
#include "snapshots/compute_state.h"

static void add_queries(VkCommandBuffer handle, uint32_t count)
{
    struct compute_state *state = compute_state_of(handle);
    if (state)
        state->queries += count;
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBeginQuery(VkCommandBuffer commandBuffer,
                                                   VkQueryPool queryPool, uint32_t query,
                                                   VkQueryControlFlags flags)
{
    add_queries(commandBuffer, 1);
    snapshots_of(commandBuffer)->below.CmdBeginQuery(commandBuffer, queryPool, query, flags);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdEndQuery(VkCommandBuffer commandBuffer,
                                                 VkQueryPool queryPool, uint32_t query)
{
    add_queries(commandBuffer, UINT32_MAX);
    snapshots_of(commandBuffer)->below.CmdEndQuery(commandBuffer, queryPool, query);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBeginQueryIndexedEXT(VkCommandBuffer commandBuffer,
                                                             VkQueryPool queryPool, uint32_t query,
                                                             VkQueryControlFlags flags,
                                                             uint32_t index)
{
    add_queries(commandBuffer, 1);
    snapshots_of(commandBuffer)
        ->below.CmdBeginQueryIndexedEXT(commandBuffer, queryPool, query, flags, index);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdEndQueryIndexedEXT(VkCommandBuffer commandBuffer,
                                                           VkQueryPool queryPool, uint32_t query,
                                                           uint32_t index)
{
    add_queries(commandBuffer, UINT32_MAX);
    snapshots_of(commandBuffer)
        ->below.CmdEndQueryIndexedEXT(commandBuffer, queryPool, query, index);
}

/* NULL: it ends. */
static void set_condition(VkCommandBuffer handle, const VkConditionalRenderingBeginInfoEXT *info)
{
    struct compute_state *state = compute_state_of(handle);
    if (!state)
        return;
    state->is_conditional = info != NULL;
    if (info) {
        state->condition = (struct buffer_target){.buffer = info->buffer, .offset = info->offset};
        state->condition_flags = info->flags;
    }
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBeginConditionalRenderingEXT(
    VkCommandBuffer commandBuffer,
    const VkConditionalRenderingBeginInfoEXT *pConditionalRenderingBegin)
{
    set_condition(commandBuffer, pConditionalRenderingBegin);
    snapshots_of(commandBuffer)
        ->below.CmdBeginConditionalRenderingEXT(commandBuffer, pConditionalRenderingBegin);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdEndConditionalRenderingEXT(VkCommandBuffer commandBuffer)
{
    set_condition(commandBuffer, NULL);
    snapshots_of(commandBuffer)->below.CmdEndConditionalRenderingEXT(commandBuffer);
}

/* Push constants of a layout end what was pushed and bound without any. */
static void use_heaps(VkCommandBuffer handle)
{
    struct compute_state *state = compute_state_of(handle);
    if (state)
        state->is_partial = true;
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdPushDataEXT(VkCommandBuffer commandBuffer,
                                                    const VkPushDataInfoEXT *pPushDataInfo)
{
    use_heaps(commandBuffer);
    snapshots_of(commandBuffer)->below.CmdPushDataEXT(commandBuffer, pPushDataInfo);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBindResourceHeapEXT(VkCommandBuffer commandBuffer,
                                                            const VkBindHeapInfoEXT *pBindInfo)
{
    use_heaps(commandBuffer);
    snapshots_of(commandBuffer)->below.CmdBindResourceHeapEXT(commandBuffer, pBindInfo);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBindSamplerHeapEXT(VkCommandBuffer commandBuffer,
                                                           const VkBindHeapInfoEXT *pBindInfo)
{
    use_heaps(commandBuffer);
    snapshots_of(commandBuffer)->below.CmdBindSamplerHeapEXT(commandBuffer, pBindInfo);
}
