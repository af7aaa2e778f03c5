/* SPDX-License-Identifier: Apache-2.0 */
/* The configuration, its defaults, and what it says about extensions and versions. */
#include "internal.h"

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of both below */
static struct null_driver_config current;
static bool configured;

static const struct {
    const char *name;
    enum guard promoted;
} extensions[] = {
#define EXTENSION(name, promoted) {"VK_" #name, promoted},
    EXTENSIONS(EXTENSION)
#undef EXTENSION
};

const char *guard_extension_name(enum guard guard)
{
    return extensions[guard - FIRST_EXTENSION].name;
}

bool guard_is_offered(const struct null_driver_config *config, enum guard guard)
{
    if (guard < NEVER)
        return VK_API_VERSION_MINOR(config->api_version) >= (uint32_t)guard;
    if (guard == NEVER)
        return false;
    for (uint32_t i = 0; i < config->hidden_extension_count; i++) {
        if (strcmp(config->hidden_extensions[i], guard_extension_name(guard)) == 0)
            return false;
    }
    return true;
}

bool guard_is_known(const struct null_driver_config *config, enum guard guard)
{
    return guard_is_offered(config, guard) ||
           (guard > BEFORE_EXTENSIONS &&
            guard_is_offered(config, extensions[guard - FIRST_EXTENSION].promoted));
}

struct null_driver_config config_current(void)
{
    pthread_mutex_lock(&lock);
    if (!configured) {
        current = null_driver_default_config();
        configured = true;
    }
    const struct null_driver_config config = current;
    pthread_mutex_unlock(&lock);
    return config;
}

void null_driver_configure(const struct null_driver_config *config)
{
    const struct null_driver_config next = config != NULL ? *config : null_driver_default_config();
    pthread_mutex_lock(&lock);
    current = next;
    configured = true;
    pthread_mutex_unlock(&lock);
}

#define VERTICES                                                                                   \
    (VK_FORMAT_FEATURE_2_VERTEX_BUFFER_BIT |                                                       \
     VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR)
#define RADII                                                                                      \
    (VK_FORMAT_FEATURE_2_VERTEX_BUFFER_BIT |                                                       \
     VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV)
#define GIB ((VkDeviceSize)1 << 30)
#define HOST (VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT)
#define LOCAL VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
#define ALL_QUEUES (VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT)

struct null_driver_config null_driver_default_config(void)
{
    return (struct null_driver_config){
        .api_version = VK_API_VERSION_1_3,
        .properties = {.driverVersion = 1,
                       .vendorID = 1,
                       .deviceID = 1,
                       .deviceType = VK_PHYSICAL_DEVICE_TYPE_OTHER,
                       .deviceName = "null driver",
                       .limits = default_limits,
                       .sparseProperties = {VK_TRUE, VK_TRUE, VK_TRUE, VK_TRUE, VK_TRUE}},
        /* Small enough for a test to exceed. */
        .as_properties = {.maxGeometryCount = 256,
                          .maxInstanceCount = 4096,
                          .maxPrimitiveCount = 1 << 20,
                          .maxPerStageDescriptorAccelerationStructures = 16,
                          .maxPerStageDescriptorUpdateAfterBindAccelerationStructures = 16,
                          .maxDescriptorSetAccelerationStructures = 16,
                          .maxDescriptorSetUpdateAfterBindAccelerationStructures = 16,
                          .minAccelerationStructureScratchOffsetAlignment = 256},
        .nv_properties = {.shaderGroupHandleSize = 32,
                          .maxRecursionDepth = 31,
                          .maxShaderGroupStride = 4096,
                          .shaderGroupBaseAlignment = 64,
                          .maxGeometryCount = 256,
                          .maxInstanceCount = 4096,
                          .maxTriangleCount = 1 << 20,
                          .maxDescriptorSetAccelerationStructures = 16},
        .protected_properties = {.protectedNoFault = VK_TRUE},
        .pipeline_properties = {.shaderGroupHandleSize = 32,
                                .maxRayRecursionDepth = 31,
                                .maxShaderGroupStride = 4096,
                                .shaderGroupBaseAlignment = 64,
                                .shaderGroupHandleCaptureReplaySize = 32,
                                .maxRayDispatchInvocationCount = 1 << 30,
                                .shaderGroupHandleAlignment = 32,
                                .maxRayHitAttributeSize = 32},
        .micromap_properties = {.maxOpacity2StateSubdivisionLevel = 6,
                                .maxOpacity4StateSubdivisionLevel = 5},
        .micromap_properties_khr = {.maxOpacity2StateSubdivisionLevel = 6,
                                    .maxOpacity4StateSubdivisionLevel = 5,
                                    .maxOpacityLossy4StateSubdivisionLevel = 4,
                                    .maxMicromapTriangles = 4096},
#ifdef VK_NV_displacement_micromap
        .displacement_properties = {.maxDisplacementMicromapSubdivisionLevel = 5},
#endif
        .cluster_properties = {.maxVerticesPerCluster = 256,
                               .maxTrianglesPerCluster = 256,
                               .clusterScratchByteAlignment = 256,
                               .clusterByteAlignment = 128,
                               .clusterTemplateByteAlignment = 32,
                               .clusterBottomLevelByteAlignment = 256,
                               .clusterTemplateBoundsByteAlignment = 32,
                               .maxClusterGeometryIndex = 1 << 20},
        .partition_properties = {.maxPartitionCount = 1 << 16},
        .memory = {.memoryTypeCount = 8,
                   .memoryTypes = {{LOCAL, 0},
                                   {HOST, 1},
                                   {HOST, 2}, /* none is cached: lavapipe has such a type */
                                   {LOCAL | HOST, 2},
                                   {LOCAL | VK_MEMORY_PROPERTY_PROTECTED_BIT, 0},
                                   {LOCAL | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT, 0},
                                   {LOCAL | VK_MEMORY_PROPERTY_DEVICE_COHERENT_BIT_AMD, 0},
                                   {LOCAL | VK_MEMORY_PROPERTY_RDMA_CAPABLE_BIT_NV, 0}},
                   .memoryHeapCount = 3,
                   .memoryHeaps = {{64 * GIB, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT |
                                                  VK_MEMORY_HEAP_MULTI_INSTANCE_BIT},
                                   {64 * GIB, 0},
                                   {64 * GIB, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT}}},
        .queue_families =
            {{ALL_QUEUES | VK_QUEUE_SPARSE_BINDING_BIT, 2, 64, {1, 1, 1}},
             {VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT, 2, 64, {1, 1, 1}},
             {VK_QUEUE_TRANSFER_BIT, 1, 64, {1, 1, 1}},
             {ALL_QUEUES | VK_QUEUE_PROTECTED_BIT, 1, 64, {1, 1, 1}},
             {VK_QUEUE_TRANSFER_BIT | VK_QUEUE_VIDEO_DECODE_BIT_KHR, 1, 64, {1, 1, 1}}},
        .queue_family_count = 5,
        .formats = {{VK_FORMAT_R32G32_SFLOAT, VERTICES},
                    {VK_FORMAT_R32G32B32_SFLOAT, VERTICES},
                    {VK_FORMAT_R16G16_SFLOAT, VERTICES},
                    {VK_FORMAT_R16G16B16A16_SFLOAT, VERTICES},
                    {VK_FORMAT_R16G16_SNORM, VERTICES},
                    {VK_FORMAT_R16G16B16A16_SNORM, VERTICES},
                    {VK_FORMAT_R32_SFLOAT, RADII},
                    {VK_FORMAT_R16_SFLOAT, RADII},
                    {VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, RADII}}, /* which backend cpu lacks */
        .format_count = 9,
        .deferred_joins = 1,
    };
}
