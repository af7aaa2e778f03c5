/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers, queries and rays of an application that lacks memory. */
#include "scarce_commands.h"

static void create_queries(struct application *app, VkQueryType type,
                           struct scarce_commands *commands)
{
    const VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                        .queryType = type,
                                        .queryCount = QUERIES};
    GET(app, "vkCreateQueryPool",
        app->vk.CreateQueryPool(app->device, &info, NULL, &commands->queries));
}

void scarce_commands_create(struct application *app, VkQueryType type,
                            struct scarce_commands *commands)
{
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT};
    GET(app, "vkCreateCommandPool",
        app->vk.CreateCommandPool(app->device, &pool, NULL, &commands->pool));
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                        .commandPool = commands->pool,
                                        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                        .commandBufferCount = 1};
    GET(app, "vkAllocateCommandBuffers",
        app->vk.AllocateCommandBuffers(app->device, &info, &commands->primary));
    info.level = VK_COMMAND_BUFFER_LEVEL_SECONDARY;
    GET(app, "vkAllocateCommandBuffers",
        app->vk.AllocateCommandBuffers(app->device, &info, &commands->secondary));
    create_queries(app, type, commands);
}

void scarce_commands_destroy(struct application *app, const struct scarce_commands *commands)
{
    app->vk.DestroyQueryPool(app->device, commands->queries, NULL);
    app->vk.DestroyCommandPool(app->device, commands->pool, NULL);
}

/* With memory short, the library that reads settings may lose one without telling; then the backend
 * is the driver's. */
PFN_vkTraceRaysASSAY scarce_find_tracing(struct application *app)
{
    PFN_vkTraceRaysASSAY trace_rays =
        (PFN_vkTraceRaysASSAY)app->vk.GetDeviceProcAddr(app->device, "vkTraceRaysASSAY");
    app->outcome->mistakes++;
    app->outcome->expected += trace_rays != NULL;
    return trace_rays;
}

void scarce_trace(struct application *app, PFN_vkTraceRaysASSAY trace_rays, uint64_t structure)
{
    const AssayRay ray = {.origin = {-1, 0, 0}, .direction = {1, 0, 0}, .tMax = 2};
    AssayHit hit;
    const AssayTraceInfo info = {.accelerationStructure = structure,
                                 .accuracy = ASSAY_ACCURACY_FAST,
                                 .rayCount = 1,
                                 .raySize = sizeof(ray),
                                 .hitSize = sizeof(hit),
                                 .rays = &ray,
                                 .hits = &hit};
    trace_rays(app->device, &info);
}

void scarce_get_results(struct application *app, const struct scarce_commands *commands)
{
    uint64_t sizes[QUERIES];
    app->vk.GetQueryPoolResults(app->device, commands->queries, 0, QUERIES, sizeof(sizes), sizes,
                                sizeof(sizes[0]), VK_QUERY_RESULT_64_BIT);
}
