/* SPDX-License-Identifier: Apache-2.0 */
/* What an application does on backend cpu in each life of tests/scarce by VK_NV_ray_tracing:
 * builds, an update and a copy (nv.c), and a query. The null driver copies nothing, so all
 * triangles are points at the origin. */
#include "../scarce/application_parts.h"
#include "assay.h"

static struct {
    PFN_vkTraceRaysASSAY trace_rays;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkQueryPool queries;
} own;

void create_objects(struct application *app)
{
    create_nv(app);
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT};
    GET(app, "vkCreateCommandPool", app->vk.CreateCommandPool(app->device, &pool, NULL, &own.pool));
    const VkCommandBufferAllocateInfo allocate_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = own.pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1};
    GET(app, "vkAllocateCommandBuffers",
        app->vk.AllocateCommandBuffers(app->device, &allocate_info, &own.commands));
    const VkQueryPoolCreateInfo queries = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
        .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV,
        .queryCount = QUERIES};
    GET(app, "vkCreateQueryPool",
        app->vk.CreateQueryPool(app->device, &queries, NULL, &own.queries));
    own.trace_rays =
        (PFN_vkTraceRaysASSAY)app->vk.GetDeviceProcAddr(app->device, "vkTraceRaysASSAY");
    /* With memory short, the library that reads settings may lose one without telling; then the
     * backend is the driver's. */
    app->outcome->mistakes++;
    app->outcome->expected += own.trace_rays != NULL;
}

void destroy_objects(struct application *app)
{
    app->vk.DestroyQueryPool(app->device, own.queries, NULL);
    app->vk.DestroyCommandPool(app->device, own.pool, NULL);
    destroy_nv(app);
}

static VkResult record(struct application *app)
{
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    VkResult result = app->vk.BeginCommandBuffer(own.commands, &info);
    if (result != VK_SUCCESS)
        return result;
    app->vk.CmdResetQueryPool(own.commands, own.queries, 0, QUERIES);
    record_nv(app, own.commands);
    app->vk.CmdWriteAccelerationStructuresPropertiesNV(
        own.commands, QUERIES, app->nv, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV,
        own.queries, 0);
    return app->vk.EndCommandBuffer(own.commands);
}

/* A structure that was lost when it was submitted can't be traced; others can. */
static void look(struct application *app)
{
    const AssayRay ray = {.origin = {-1, 0, 0}, .direction = {1, 0, 0}, .tMax = 2};
    AssayHit hit;
    uint64_t sizes[QUERIES];
    AssayTraceInfo info = {.accuracy = ASSAY_ACCURACY_FAST,
                           .rayCount = 1,
                           .raySize = sizeof(ray),
                           .hitSize = sizeof(hit),
                           .rays = &ray,
                           .hits = &hit};
    for (unsigned i = 0; i < NV_STRUCTURES; i++) {
        info.accelerationStructure = (uint64_t)app->nv[i];
        own.trace_rays(app->device, &info);
    }
    app->vk.GetQueryPoolResults(app->device, own.queries, 0, QUERIES, sizeof(sizes), sizes,
                                sizeof(sizes[0]), VK_QUERY_RESULT_64_BIT);
}

void record_all(struct application *app)
{
    const VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &own.commands};
    if (!own.trace_rays)
        return;
    GET(app, "a command buffer", record(app));
    for (int i = 0; i < 2; i++) {
        GET(app, "vkQueueSubmit", app->vk.QueueSubmit(app->queue, 1, &info, VK_NULL_HANDLE));
        GET(app, "vkQueueWaitIdle", app->vk.QueueWaitIdle(app->queue));
        look(app);
    }
}
