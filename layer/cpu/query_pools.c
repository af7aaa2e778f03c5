/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: query pools of acceleration-structure properties. Other pools belong to the next
 * layer. */
#include "src/cpu/query_pools.h"

#include <string.h>

#include "layer/cpu/overlay.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/base/readable.h"

VkResult cpu_create_query_pool(struct cpu_query_pools *pools,
                               const VkQueryPoolCreateInfo *create_info, VkQueryPool *pool)
{
    uint64_t handle = 0;
    VkResult result =
        cpu_query_pools_add(pools, create_info->queryType, create_info->queryCount, &handle);
    *pool = result == VK_SUCCESS ? (VkQueryPool)handle : VK_NULL_HANDLE;
    return result;
}

/* ---- in command buffers */

static void record_command(VkCommandBuffer commands, const struct recorded_command *command)
{
    struct recorder recorder;
    if (recorder_begin(&recorder, commands))
        recorder_add(&recorder, command);
}

void cpu_reset_queries(VkCommandBuffer commands, VkQueryPool pool, uint32_t first, uint32_t count)
{
    record_command(commands, &(struct recorded_command){.kind = CPU_RESET_QUERIES,
                                                        .pool = (uint64_t)pool,
                                                        .first = first,
                                                        .count = count});
}

/* `structures`: handles of either kind. The type of the queries is that of the pool; another type
 * would be invalid usage. */
void cpu_write_queries(VkCommandBuffer commands, uint32_t count, const void *structures,
                       VkQueryPool pool, uint32_t first)
{
    struct recorder recorder;
    struct recorded_command write = {.kind = CPU_WRITE_QUERY, .pool = (uint64_t)pool};
    if (!recorder_begin(&recorder, commands) ||
        !cpu_query_pools_has(recorder.device->cpu->device->query_pools, write.pool) ||
        !readable(readable_cache_of_thread(), structures, count * sizeof(write.structure)))
        return;
    for (uint32_t i = 0; i < count; i++) {
        write.first = first + i;
        memcpy(&write.structure, (const char *)structures + i * sizeof(write.structure),
               sizeof(write.structure));
        recorder_add(&recorder, &write);
    }
}

void cpu_copy_queries(VkCommandBuffer commands, VkQueryPool pool, uint32_t first, uint32_t count,
                      VkBuffer dst, VkDeviceSize offset, VkDeviceSize stride,
                      VkQueryResultFlags flags)
{
    record_command(commands,
                   &(struct recorded_command){
                       .kind = CPU_COPY_QUERIES,
                       .pool = (uint64_t)pool,
                       .first = first,
                       .count = count,
                       .stride = stride,
                       .flags = flags,
                       .target = {.buffer = dst, .offset = offset, .size = UINT64_MAX - offset},
                   });
}
