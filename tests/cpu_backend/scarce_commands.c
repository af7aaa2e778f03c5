/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers, queries and rays of an application that lacks memory. */
#include "scarce_commands.h"

VkCommandBuffer primary, secondary;
VkQueryPool queries;
PFN_vkTraceRaysASSAY trace_rays;

void scarce_create_commands(VkQueryType type)
{
    VkCommandPool pool;
    create_commands(&pool, &primary, &secondary);
    queries = create_queries(type);
}

/* With memory short, the library that reads settings may lose one without telling; then the backend
 * is the driver's. */
void scarce_find_tracing(void)
{
    trace_rays = (PFN_vkTraceRaysASSAY)vk.GetDeviceProcAddr(device, "vkTraceRaysASSAY");
    outcome.expected++;
    outcome.found += trace_rays != NULL;
}

void scarce_build_micromap(VkMicromapEXT micromap, VkMicromapTypeEXT type,
                           const VkMicromapUsageEXT *usage)
{
    static const uint8_t opaque[1] = {1}, still[64];
    static const VkMicromapTriangleEXT triangles[] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    const STRUCT(VkMicromapBuildInfoEXT, info, .type = type, .dstMicromap = micromap,
                 .usageCountsCount = 1, .pUsageCounts = usage,
                 .data.hostAddress = type == VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT ? opaque : still,
                 .triangleArray.hostAddress = triangles,
                 .triangleArrayStride = sizeof(triangles[0]));
    CALL(BuildMicromapsEXT, device, VK_NULL_HANDLE, 1, &info);
}

VkAccelerationStructureTrianglesDisplacementMicromapNV
scarce_displacement(VkMicromapEXT micromap, const VkMicromapUsageEXT *usage,
                    VkDeviceAddress vectors)
{
    return MAKE(VkAccelerationStructureTrianglesDisplacementMicromapNV,
                .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
                .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
                .displacementVectorBuffer.deviceAddress = vectors, .displacementVectorStride = 12,
                .indexType = VK_INDEX_TYPE_NONE_KHR, .usageCountsCount = 1, .pUsageCounts = usage,
                .micromap = micromap);
}

void scarce_trace(uint64_t structure)
{
    const AssayRay ray = {.origin = {-1, 0, 0}, .direction = {1, 0, 0}, .tMax = 2};
    AssayHit hit;
    const AssayTraceInfo info = trace_info(structure, ASSAY_ACCURACY_FAST, 1, &ray, &hit);
    trace_rays(device, &info);
}

void scarce_get_results(void)
{
    uint64_t sizes[QUERIES];
    vk.GetQueryPoolResults(device, queries, 0, QUERIES, sizeof(sizes), sizes, sizeof(sizes[0]),
                           VK_QUERY_RESULT_64_BIT);
}
