/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers, queries and rays of an application that lacks memory. */
#include "scarce_commands.h"

void scarce_commands_create(struct application *app, VkQueryType type,
                            struct scarce_commands *commands)
{
    create_commands(app, &commands->pool, &commands->primary, &commands->secondary);
    commands->queries = create_queries(app, type);
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
    const AssayTraceInfo info = trace_info(structure, ASSAY_ACCURACY_FAST, 1, &ray, &hit);
    trace_rays(app->device, &info);
}

void scarce_get_results(struct application *app, const struct scarce_commands *commands)
{
    uint64_t sizes[QUERIES];
    app->vk.GetQueryPoolResults(app->device, commands->queries, 0, QUERIES, sizeof(sizes), sizes,
                                sizeof(sizes[0]), VK_QUERY_RESULT_64_BIT);
}
