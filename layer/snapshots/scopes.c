/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that begin and end scopes in which a dispatch of the layer's own would be counted or
 * discarded, or would disturb state that cannot be restored. */
#include "layer/snapshots/commands.h"
#include "layer/snapshots/copies/compute_state.h"

/* ---- queries */

/* Performance queries may count anything, and so may unknown query types. */
static bool counts_compute_work(const VkQueryPoolCreateInfo *info)
{
    switch (info->queryType) {
    case VK_QUERY_TYPE_OCCLUSION:
    case VK_QUERY_TYPE_TIMESTAMP:
    case VK_QUERY_TYPE_TRANSFORM_FEEDBACK_STREAM_EXT:
    case VK_QUERY_TYPE_PRIMITIVES_GENERATED_EXT:
    case VK_QUERY_TYPE_MESH_PRIMITIVES_GENERATED_EXT:
        return false;
    case VK_QUERY_TYPE_PIPELINE_STATISTICS:
        return info->pipelineStatistics &
               VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT;
    default:
        return true;
    }
}

/* Without memory the pool's queries are treated as if they counted compute work. */
VKAPI_ATTR VkResult VKAPI_CALL snapshots_CreateQueryPool(VkDevice device,
                                                         const VkQueryPoolCreateInfo *pCreateInfo,
                                                         const VkAllocationCallbacks *pAllocator,
                                                         VkQueryPool *pQueryPool)
{
    struct snapshots *snapshots = snapshots_of(device);
    VkResult result = snapshots->below.CreateQueryPool(device, pCreateInfo, pAllocator, pQueryPool);
    if (result == VK_SUCCESS && !counts_compute_work(pCreateInfo)) {
        pthread_mutex_lock(&snapshots->pools_lock);
        handle_table_set(&snapshots->uncounting_pools, (uint64_t)(uintptr_t)*pQueryPool, snapshots);
        pthread_mutex_unlock(&snapshots->pools_lock);
    }
    return result;
}

VKAPI_ATTR void VKAPI_CALL snapshots_DestroyQueryPool(VkDevice device, VkQueryPool queryPool,
                                                      const VkAllocationCallbacks *pAllocator)
{
    struct snapshots *snapshots = snapshots_of(device);
    pthread_mutex_lock(&snapshots->pools_lock);
    handle_table_remove(&snapshots->uncounting_pools, (uint64_t)(uintptr_t)queryPool);
    pthread_mutex_unlock(&snapshots->pools_lock);
    snapshots->below.DestroyQueryPool(device, queryPool, pAllocator);
}

static bool is_counting_pool(struct snapshots *snapshots, VkQueryPool pool)
{
    pthread_mutex_lock(&snapshots->pools_lock);
    bool is_uncounting = handle_table_find(&snapshots->uncounting_pools, (uint64_t)(uintptr_t)pool);
    pthread_mutex_unlock(&snapshots->pools_lock);
    return !is_uncounting;
}

/* `count`: 1 if a query begins, -1 if it ends. */
static void add_query(struct snapshots *snapshots, VkCommandBuffer handle, VkQueryPool pool,
                      int count)
{
    struct compute_state *state =
        is_counting_pool(snapshots, pool) ? compute_state_of(handle) : NULL;
    if (state)
        state->queries += (uint32_t)count;
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBeginQuery(VkCommandBuffer commandBuffer,
                                                   VkQueryPool queryPool, uint32_t query,
                                                   VkQueryControlFlags flags)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    add_query(snapshots, commandBuffer, queryPool, 1);
    snapshots->below.CmdBeginQuery(commandBuffer, queryPool, query, flags);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdEndQuery(VkCommandBuffer commandBuffer,
                                                 VkQueryPool queryPool, uint32_t query)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    add_query(snapshots, commandBuffer, queryPool, -1);
    snapshots->below.CmdEndQuery(commandBuffer, queryPool, query);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBeginQueryIndexedEXT(VkCommandBuffer commandBuffer,
                                                             VkQueryPool queryPool, uint32_t query,
                                                             VkQueryControlFlags flags,
                                                             uint32_t index)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    add_query(snapshots, commandBuffer, queryPool, 1);
    snapshots->below.CmdBeginQueryIndexedEXT(commandBuffer, queryPool, query, flags, index);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdEndQueryIndexedEXT(VkCommandBuffer commandBuffer,
                                                           VkQueryPool queryPool, uint32_t query,
                                                           uint32_t index)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    add_query(snapshots, commandBuffer, queryPool, -1);
    snapshots->below.CmdEndQueryIndexedEXT(commandBuffer, queryPool, query, index);
}

/* ---- conditions */

static void set_condition(VkCommandBuffer handle, const struct condition *condition)
{
    struct compute_state *state = compute_state_of(handle);
    if (state)
        state->condition = *condition;
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBeginConditionalRenderingEXT(
    VkCommandBuffer commandBuffer,
    const VkConditionalRenderingBeginInfoEXT *pConditionalRenderingBegin)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    set_condition(commandBuffer, &(struct condition){.kind = CONDITION_IN_BUFFER,
                                                     .flags = pConditionalRenderingBegin->flags,
                                                     .buffer = pConditionalRenderingBegin->buffer,
                                                     .offset = pConditionalRenderingBegin->offset});
    snapshots->below.CmdBeginConditionalRenderingEXT(commandBuffer, pConditionalRenderingBegin);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBeginConditionalRendering2EXT(
    VkCommandBuffer commandBuffer,
    const VkConditionalRenderingBeginInfo2EXT *pConditionalRenderingBegin)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    set_condition(commandBuffer,
                  &(struct condition){.kind = CONDITION_AT_ADDRESS,
                                      .flags = pConditionalRenderingBegin->flags,
                                      .range = pConditionalRenderingBegin->addressRange,
                                      .address_flags = pConditionalRenderingBegin->addressFlags});
    snapshots->below.CmdBeginConditionalRendering2EXT(commandBuffer, pConditionalRenderingBegin);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdEndConditionalRenderingEXT(VkCommandBuffer commandBuffer)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    set_condition(commandBuffer, &(struct condition){.kind = CONDITION_NONE});
    snapshots->below.CmdEndConditionalRenderingEXT(commandBuffer);
}

/* ---- heaps */

/* A dispatch of the layer's own pushes constants with a layout, which invalidates push data and
 * heap bindings. */
static void use_heaps(VkCommandBuffer handle)
{
    struct compute_state *state = compute_state_of(handle);
    if (state)
        state->is_partial = true;
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdPushDataEXT(VkCommandBuffer commandBuffer,
                                                    const VkPushDataInfoEXT *pPushDataInfo)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    use_heaps(commandBuffer);
    snapshots->below.CmdPushDataEXT(commandBuffer, pPushDataInfo);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBindResourceHeapEXT(VkCommandBuffer commandBuffer,
                                                            const VkBindHeapInfoEXT *pBindInfo)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    use_heaps(commandBuffer);
    snapshots->below.CmdBindResourceHeapEXT(commandBuffer, pBindInfo);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBindSamplerHeapEXT(VkCommandBuffer commandBuffer,
                                                           const VkBindHeapInfoEXT *pBindInfo)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    use_heaps(commandBuffer);
    snapshots->below.CmdBindSamplerHeapEXT(commandBuffer, pBindInfo);
}
