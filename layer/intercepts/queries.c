/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of queries of compacted sizes. Commands that write queries are recorded in journals;
 * resets and reads by the host are placed in execution order among the batches. */
#include "layer/execution/input_checks.h"
#include "src/state/commands/query_pools.h"

#include <stdlib.h>
#include <string.h>

#include "layer/intercepts/intercepts.h"
#include "layer/intercepts/journal_access.h"
#include "layer/postmortem/loss.h"
#include "src/base/readable.h"

/* ---- pools */

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateQueryPool(VkDevice device,
                                                     const VkQueryPoolCreateInfo *pCreateInfo,
                                                     const VkAllocationCallbacks *pAllocator,
                                                     VkQueryPool *pQueryPool)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateQueryPool(device, pCreateInfo, pAllocator, pQueryPool);
    if (result == VK_SUCCESS && state->order &&
        pCreateInfo->queryType == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR)
        query_pools_add(state->query_pools, *pQueryPool, pCreateInfo->queryCount);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyQueryPool(VkDevice device, VkQueryPool queryPool,
                                                  const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    struct query_pool pool;
    if (query_pools_remove(state->query_pools, queryPool, &pool))
        structures_note_destroyed(state->structures, pool.first_id, pool.count);
    state->vk.DestroyQueryPool(device, queryPool, pAllocator);
}

/* ---- command buffers */

VKAPI_ATTR void VKAPI_CALL assay_CmdWriteAccelerationStructuresPropertiesKHR(
    VkCommandBuffer commandBuffer, uint32_t accelerationStructureCount,
    const VkAccelerationStructureKHR *pAccelerationStructures, VkQueryType queryType,
    VkQueryPool queryPool, uint32_t firstQuery)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    struct query_pool pool;
    struct command_buffer *recording = NULL;
    if (queryType == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR &&
        query_pools_find(device->query_pools, queryPool, &pool))
        recording = layer_find_recording(device, commandBuffer);
    uint32_t count =
        recording ? query_pool_clamp(&pool, firstQuery, accelerationStructureCount) : 0;
    for (uint32_t i = 0; i < count; i++)
        journal_add(recording->journal,
                    &(struct journal_entry){
                        .kind = JOURNAL_QUERY,
                        .src = (uint64_t)(uintptr_t)pAccelerationStructures[i],
                        .src_id = layer_accel_id(device, pAccelerationStructures[i]),
                        .dst_id = pool.first_id + firstQuery + i,
                    });
    device->vk.CmdWriteAccelerationStructuresPropertiesKHR(
        commandBuffer, accelerationStructureCount, pAccelerationStructures, queryType, queryPool,
        firstQuery);
}

/* ---- the host resets */

static void reset(struct layer_device *device, VkQueryPool handle, uint32_t first, uint32_t count)
{
    struct query_pool pool;
    if (!query_pools_find(device->query_pools, handle, &pool))
        return;
    struct journal *journal = journal_create(VK_NULL_HANDLE);
    if (journal)
        journal_add(journal, &(struct journal_entry){
                                 .kind = JOURNAL_RESET_QUERIES,
                                 .dst_id = pool.first_id + first,
                                 .info = query_pool_clamp(&pool, first, count),
                             });
    layer_run_host_command(device, journal);
}

VKAPI_ATTR void VKAPI_CALL assay_ResetQueryPool(VkDevice device, VkQueryPool queryPool,
                                                uint32_t firstQuery, uint32_t queryCount)
{
    struct layer_device *state = layer_find_device(device);
    reset(state, queryPool, firstQuery, queryCount);
    state->vk.ResetQueryPool(device, queryPool, firstQuery, queryCount);
}

VKAPI_ATTR void VKAPI_CALL assay_ResetQueryPoolEXT(VkDevice device, VkQueryPool queryPool,
                                                   uint32_t firstQuery, uint32_t queryCount)
{
    struct layer_device *state = layer_find_device(device);
    reset(state, queryPool, firstQuery, queryCount);
    state->vk.ResetQueryPoolEXT(device, queryPool, firstQuery, queryCount);
}

/* ---- the host reads
 *
 * The completions that the host has observed are recorded before the call goes down: a batch that
 * is submitted during the call may change a query after it was read. */

static struct journal *begin_reading(const struct layer_device *device)
{
    struct journal *journal = journal_create(VK_NULL_HANDLE);
    struct host_view *host = malloc(sizeof(*host));
    struct idle_wait wait;
    if (!journal || !host) {
        journal_release(journal);
        free(host);
        return NULL;
    }
    journal->host = host;
    execution_order_host_clock(device->order, &host->executed);
    execution_order_start_idle(device->order, VK_NULL_HANDLE, &wait);
    host->submitted = wait.clock;
    return journal;
}

/* Results as vkGetQueryPoolResults lays them out. */
struct results {
    const char *data;
    VkDeviceSize size, stride;
    VkQueryResultFlags flags;
    bool all_available;
};

static uint64_t read_word(const struct results *results, const char *at, uint32_t word)
{
    if (results->flags & VK_QUERY_RESULT_64_BIT) {
        uint64_t value;
        memcpy(&value, at + word * sizeof(value), sizeof(value));
        return value;
    }
    uint32_t value;
    memcpy(&value, at + word * sizeof(value), sizeof(value));
    return value;
}

static bool has_result(const struct results *results, uint32_t i)
{
    VkDeviceSize word =
        results->flags & VK_QUERY_RESULT_64_BIT ? sizeof(uint64_t) : sizeof(uint32_t);
    VkDeviceSize size = results->flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT ? 2 * word : word;
    return size <= results->size && (!i || results->stride <= (results->size - size) / i) &&
           readable(readable_cache_of_thread(), results->data + i * results->stride, size);
}

/* Returns 0 if the query was, or may have been, unavailable: without an availability word, partial
 * results look like complete ones. */
static VkDeviceSize read_result(const struct results *results, uint32_t i)
{
    const char *at = results->data + i * results->stride;
    bool has_availability = results->flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
    bool available = has_availability ? read_word(results, at, 1) != 0 : results->all_available;
    return available ? read_word(results, at, 0) : 0;
}

static void add_answers(struct journal *journal, uint64_t first_id, uint32_t count,
                        const struct results *results)
{
    for (uint32_t i = 0; i < count && has_result(results, i); i++) {
        struct journal_entry answer = {
            .kind = JOURNAL_ANSWER, .src_id = first_id + i, .number = read_result(results, i)};
        if (answer.number)
            journal_add(journal, &answer);
    }
}

VKAPI_ATTR VkResult VKAPI_CALL assay_GetQueryPoolResults(VkDevice device, VkQueryPool queryPool,
                                                         uint32_t firstQuery, uint32_t queryCount,
                                                         size_t dataSize, void *pData,
                                                         VkDeviceSize stride,
                                                         VkQueryResultFlags flags)
{
    struct layer_device *state = layer_find_device(device);
    struct query_pool pool;
    struct journal *journal = NULL;
    if (query_pools_find(state->query_pools, queryPool, &pool))
        journal = begin_reading(state);
    VkResult result = state->vk.GetQueryPoolResults(device, queryPool, firstQuery, queryCount,
                                                    dataSize, pData, stride, flags);
    postmortem_see(state, result);
    input_checks_deliver(state->input_checks);
    if (!journal)
        return result;
    bool partial = (flags & VK_QUERY_RESULT_PARTIAL_BIT) && !(flags & VK_QUERY_RESULT_WAIT_BIT);
    const struct results results = {
        .data = pData,
        .size = dataSize,
        .stride = stride,
        .flags = flags,
        .all_available = result == VK_SUCCESS && !partial,
    };
    if (result >= VK_SUCCESS)
        add_answers(journal, pool.first_id + firstQuery,
                    query_pool_clamp(&pool, firstQuery, queryCount), &results);
    layer_run_host_command(state, journal);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_WriteAccelerationStructuresPropertiesKHR(
    VkDevice device, uint32_t accelerationStructureCount,
    const VkAccelerationStructureKHR *pAccelerationStructures, VkQueryType queryType,
    size_t dataSize, void *pData, size_t stride)
{
    struct layer_device *state = layer_find_device(device);
    struct journal *journal = NULL;
    if (state->order && queryType == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR)
        journal = begin_reading(state);
    VkResult result = state->vk.WriteAccelerationStructuresPropertiesKHR(
        device, accelerationStructureCount, pAccelerationStructures, queryType, dataSize, pData,
        stride);
    const struct results results = {.data = pData,
                                    .size = dataSize,
                                    .stride = stride,
                                    .flags = VK_QUERY_RESULT_64_BIT,
                                    .all_available = result == VK_SUCCESS};
    for (uint32_t i = 0; journal && i < accelerationStructureCount && has_result(&results, i);
         i++) {
        struct journal_entry answer = {.kind = JOURNAL_ANSWER,
                                       .src = (uint64_t)(uintptr_t)pAccelerationStructures[i],
                                       .src_id = layer_accel_id(state, pAccelerationStructures[i]),
                                       .number = read_result(&results, i)};
        journal_add(journal, &answer);
    }
    layer_run_host_command(state, journal);
    return result;
}
