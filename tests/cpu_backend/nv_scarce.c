/* SPDX-License-Identifier: Apache-2.0 */
/* What an application does on backend cpu in each life of tests/scarce by VK_NV_ray_tracing:
 * builds, an update and a copy (nv.c), and a query. The null driver copies nothing, so all
 * triangles are points at the origin. */
#include "scarce_commands.h"

void create_objects(void)
{
    create_nv();
    scarce_create_commands(VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV);
    scarce_find_tracing();
}

static VkResult record(void)
{
    const VkResult result = begin_commands(primary);
    if (result != VK_SUCCESS)
        return result;
    vk.CmdResetQueryPool(primary, queries, 0, QUERIES);
    record_nv(primary);
    vk.CmdWriteAccelerationStructuresPropertiesNV(
        primary, QUERIES, app.nv, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV, queries,
        0);
    return vk.EndCommandBuffer(primary);
}

static void look(void)
{
    for (unsigned i = 0; i < NV_STRUCTURES; i++)
        scarce_trace((uint64_t)app.nv[i]);
    scarce_get_results();
}

void record_all(void)
{
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 1, .pCommandBuffers = &primary);
    if (!trace_rays)
        return;
    GET("a command buffer", record());
    for (int i = 0; i < 2; i++) {
        CALL(QueueSubmit, queue, 1, &info, VK_NULL_HANDLE);
        CALL(QueueWaitIdle, queue);
        look();
    }
}
