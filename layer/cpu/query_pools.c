/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: query pools of acceleration-structure properties. Other pools belong to
 * the next layer. */
#include "src/cpu/query_pools.h"
#include "observers.h"

#include <string.h>

#include "layer/cpu/overlay.h"
#include "layer/snapshots/recorder.h"
#include "src/base/readable.h"

static bool is_own(const struct cpu_overlay *overlay, VkQueryPool pool)
{
    return cpu_query_pools_has(overlay->device->query_pools, (uint64_t)pool);
}

/* ---- pools */

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateQueryPool(VkDevice device,
                                                   const VkQueryPoolCreateInfo *pCreateInfo,
                                                   const VkAllocationCallbacks *pAllocator,
                                                   VkQueryPool *pQueryPool)
{
    const struct cpu_overlay *overlay = cpu_overlay_of(device);
    if (!cpu_query_type_is_known(pCreateInfo->queryType))
        return overlay->next.CreateQueryPool(device, pCreateInfo, pAllocator, pQueryPool);
    uint64_t handle = 0;
    VkResult result = cpu_query_pools_add(overlay->device->query_pools, pCreateInfo->queryType,
                                          pCreateInfo->queryCount, &handle);
    *pQueryPool = result == VK_SUCCESS ? (VkQueryPool)handle : VK_NULL_HANDLE;
    return result;
}

VKAPI_ATTR void VKAPI_CALL cpu_DestroyQueryPool(VkDevice device, VkQueryPool queryPool,
                                                const VkAllocationCallbacks *pAllocator)
{
    const struct cpu_overlay *overlay = cpu_overlay_of(device);
    if (is_own(overlay, queryPool))
        cpu_query_pools_remove(overlay->device->query_pools, (uint64_t)queryPool);
    else
        overlay->next.DestroyQueryPool(device, queryPool, pAllocator);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_GetQueryPoolResults(VkDevice device, VkQueryPool queryPool,
                                                       uint32_t firstQuery, uint32_t queryCount,
                                                       size_t dataSize, void *pData,
                                                       VkDeviceSize stride,
                                                       VkQueryResultFlags flags)
{
    const struct cpu_overlay *overlay = cpu_overlay_of(device);
    return is_own(overlay, queryPool)
               ? cpu_query_pools_read(overlay->device->query_pools, (uint64_t)queryPool, firstQuery,
                                      queryCount, dataSize, pData, stride, flags)
               : overlay->next.GetQueryPoolResults(device, queryPool, firstQuery, queryCount,
                                                   dataSize, pData, stride, flags);
}

static void reset(VkDevice device, PFN_vkResetQueryPool next, VkQueryPool pool, uint32_t first,
                  uint32_t count)
{
    const struct cpu_overlay *overlay = cpu_overlay_of(device);
    if (is_own(overlay, pool))
        cpu_query_pools_reset(overlay->device->query_pools, (uint64_t)pool, first, count);
    else
        next(device, pool, first, count);
}

VKAPI_ATTR void VKAPI_CALL cpu_ResetQueryPool(VkDevice device, VkQueryPool queryPool,
                                              uint32_t firstQuery, uint32_t queryCount)
{
    reset(device, cpu_overlay_of(device)->next.ResetQueryPool, queryPool, firstQuery, queryCount);
}

VKAPI_ATTR void VKAPI_CALL cpu_ResetQueryPoolEXT(VkDevice device, VkQueryPool queryPool,
                                                 uint32_t firstQuery, uint32_t queryCount)
{
    reset(device, cpu_overlay_of(device)->next.ResetQueryPoolEXT, queryPool, firstQuery,
          queryCount);
}

/* ---- in command buffers */

VKAPI_ATTR void VKAPI_CALL cpu_CmdResetQueryPool(VkCommandBuffer commandBuffer,
                                                 VkQueryPool queryPool, uint32_t firstQuery,
                                                 uint32_t queryCount)
{
    const struct cpu_overlay *overlay = cpu_overlay_of_recording(commandBuffer);
    if (!overlay)
        return;
    if (!is_own(overlay, queryPool)) {
        overlay->next.CmdResetQueryPool(commandBuffer, queryPool, firstQuery, queryCount);
        return;
    }
    const struct recorded_command reset = {.kind = CPU_RESET_QUERIES,
                                           .pool = (uint64_t)queryPool,
                                           .first = firstQuery,
                                           .count = queryCount};
    struct recorder recorder;
    if (recorder_begin(&recorder, commandBuffer))
        recorder_add(&recorder, &reset);
}

/* `structures`: handles of either kind. The type of the queries is that of the pool; another type
 * would be invalid usage. */
static void record_writes(VkCommandBuffer commands, uint32_t count, const void *structures,
                          VkQueryPool pool, uint32_t first)
{
    struct recorder recorder;
    struct recorded_command write = {.kind = CPU_WRITE_QUERY, .pool = (uint64_t)pool};
    if (!recorder_begin(&recorder, commands) || !is_own(recorder.device->cpu, pool) ||
        !readable(readable_cache_of_thread(), structures, count * sizeof(write.structure)))
        return;
    for (uint32_t i = 0; i < count; i++) {
        write.first = first + i;
        memcpy(&write.structure, (const char *)structures + i * sizeof(write.structure),
               sizeof(write.structure));
        recorder_add(&recorder, &write);
    }
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdWriteAccelerationStructuresPropertiesKHR(
    VkCommandBuffer commandBuffer, uint32_t accelerationStructureCount,
    const VkAccelerationStructureKHR *pAccelerationStructures, VkQueryType queryType,
    VkQueryPool queryPool, uint32_t firstQuery)
{
    (void)queryType;
    record_writes(commandBuffer, accelerationStructureCount, pAccelerationStructures, queryPool,
                  firstQuery);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdWriteAccelerationStructuresPropertiesNV(
    VkCommandBuffer commandBuffer, uint32_t accelerationStructureCount,
    const VkAccelerationStructureNV *pAccelerationStructures, VkQueryType queryType,
    VkQueryPool queryPool, uint32_t firstQuery)
{
    (void)queryType;
    record_writes(commandBuffer, accelerationStructureCount, pAccelerationStructures, queryPool,
                  firstQuery);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdCopyQueryPoolResults(VkCommandBuffer commandBuffer,
                                                       VkQueryPool queryPool, uint32_t firstQuery,
                                                       uint32_t queryCount, VkBuffer dstBuffer,
                                                       VkDeviceSize dstOffset, VkDeviceSize stride,
                                                       VkQueryResultFlags flags)
{
    const struct cpu_overlay *overlay = cpu_overlay_of_recording(commandBuffer);
    if (!overlay)
        return;
    if (!is_own(overlay, queryPool)) {
        overlay->next.CmdCopyQueryPoolResults(commandBuffer, queryPool, firstQuery, queryCount,
                                              dstBuffer, dstOffset, stride, flags);
        return;
    }
    const struct recorded_command copy = {
        .kind = CPU_COPY_QUERIES,
        .pool = (uint64_t)queryPool,
        .first = firstQuery,
        .count = queryCount,
        .stride = stride,
        .flags = flags,
        .target = {.buffer = dstBuffer, .offset = dstOffset, .size = UINT64_MAX - dstOffset},
    };
    struct recorder recorder;
    if (recorder_begin(&recorder, commandBuffer))
        recorder_add(&recorder, &copy);
}
