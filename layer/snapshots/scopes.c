/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that begin and end scopes in which a dispatch of the layer's own would be counted or
 * discarded, or would disturb state that cannot be restored. */
#include "layer/snapshots/copies/copies.h"
#include "observers.h"

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
void snapshots_note_query_pool(struct layer_device *device, VkQueryPool pool,
                               const VkQueryPoolCreateInfo *info)
{
    struct snapshots *snapshots = device->snapshots;
    if (counts_compute_work(info))
        return;
    pthread_mutex_lock(&snapshots->pools_lock);
    handle_table_set(&snapshots->uncounting_pools, handle_number(pool), snapshots);
    pthread_mutex_unlock(&snapshots->pools_lock);
}

void snapshots_forget_query_pool(struct layer_device *device, VkQueryPool pool)
{
    struct snapshots *snapshots = device->snapshots;
    pthread_mutex_lock(&snapshots->pools_lock);
    handle_table_remove(&snapshots->uncounting_pools, handle_number(pool));
    pthread_mutex_unlock(&snapshots->pools_lock);
}

static bool is_counting_pool(struct snapshots *snapshots, VkQueryPool pool)
{
    pthread_mutex_lock(&snapshots->pools_lock);
    bool is_uncounting = handle_table_find(&snapshots->uncounting_pools, handle_number(pool));
    pthread_mutex_unlock(&snapshots->pools_lock);
    return !is_uncounting;
}

/* `count`: 1 if a query begins, -1 if it ends. */
static void add_query(const struct layer_device *device, VkCommandBuffer handle, VkQueryPool pool,
                      int count)
{
    struct compute_state *state =
        is_counting_pool(device->snapshots, pool) ? compute_state_of(device, handle) : NULL;
    if (state)
        state->queries += (uint32_t)count;
}

void snapshots_begin_query(struct layer_device *device, VkCommandBuffer handle, VkQueryPool pool)
{
    add_query(device, handle, pool, 1);
}

void snapshots_end_query(struct layer_device *device, VkCommandBuffer handle, VkQueryPool pool)
{
    add_query(device, handle, pool, -1);
}

/* ---- conditions */

static void set_condition(const struct layer_device *device, VkCommandBuffer handle,
                          const struct condition *condition)
{
    struct compute_state *state = compute_state_of(device, handle);
    if (state)
        state->condition = *condition;
}

void snapshots_begin_condition(struct layer_device *device, VkCommandBuffer handle,
                               const VkConditionalRenderingBeginInfoEXT *info)
{
    set_condition(device, handle,
                  &(struct condition){.kind = CONDITION_IN_BUFFER,
                                      .flags = info->flags,
                                      .buffer = info->buffer,
                                      .offset = info->offset});
}

void snapshots_begin_condition_2(struct layer_device *device, VkCommandBuffer handle,
                                 const VkConditionalRenderingBeginInfo2EXT *info)
{
    set_condition(device, handle,
                  &(struct condition){.kind = CONDITION_AT_ADDRESS,
                                      .flags = info->flags,
                                      .range = info->addressRange,
                                      .address_flags = info->addressFlags});
}

void snapshots_end_condition(struct layer_device *device, VkCommandBuffer handle)
{
    set_condition(device, handle, &(struct condition){.kind = CONDITION_NONE});
}

/* ---- heaps */

/* A dispatch of the layer's own pushes constants with a layout, which invalidates push data and
 * heap bindings. */
void snapshots_use_heaps(struct layer_device *device, VkCommandBuffer handle)
{
    struct compute_state *state = compute_state_of(device, handle);
    if (state)
        state->is_partial = true;
}
