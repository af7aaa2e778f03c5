/* SPDX-License-Identifier: Apache-2.0 */
/* What an application does on backend cpu in each life of tests/scarce by VK_NV_ray_tracing:
 * builds, an update and a copy (nv.c), and a query. The null driver copies nothing, so all
 * triangles are points at the origin. */
#include "scarce_commands.h"

static PFN_vkTraceRaysASSAY trace_rays;
static struct scarce_commands own;

void create_objects(struct application *app)
{
    create_nv(app);
    scarce_commands_create(app, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV, &own);
    trace_rays = scarce_find_tracing(app);
}

void destroy_objects(struct application *app)
{
    scarce_commands_destroy(app, &own);
    destroy_nv(app);
}

static VkResult record(struct application *app)
{
    const VkResult result = begin_commands(app, own.primary);
    if (result != VK_SUCCESS)
        return result;
    app->vk.CmdResetQueryPool(own.primary, own.queries, 0, QUERIES);
    record_nv(app, own.primary);
    app->vk.CmdWriteAccelerationStructuresPropertiesNV(
        own.primary, QUERIES, app->nv, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV,
        own.queries, 0);
    return app->vk.EndCommandBuffer(own.primary);
}

static void look(struct application *app)
{
    for (unsigned i = 0; i < NV_STRUCTURES; i++)
        scarce_trace(app, trace_rays, (uint64_t)app->nv[i]);
    scarce_get_results(app, &own);
}

void record_all(struct application *app)
{
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 1, .pCommandBuffers = &own.primary);
    if (!trace_rays)
        return;
    GET(app, "a command buffer", record(app));
    for (int i = 0; i < 2; i++) {
        CALL(app, QueueSubmit, app->queue, 1, &info, VK_NULL_HANDLE);
        CALL(app, QueueWaitIdle, app->queue);
        look(app);
    }
}
