/* SPDX-License-Identifier: Apache-2.0 */
/* What an application does on backend cpu in each life of tests/scarce, in command buffers: builds,
 * copies and queries, recorded or submitted again where memory was lacking. The null driver copies
 * nothing, so all boxes are points at the origin. */
#include "scarce_commands.h"
#include "tests/fixture/copies.h"

enum {
    BLASES = 20,
    TLAS = BLASES,
    CLONE,
    LOADED,
    STRUCTURES,
    STRUCTURE_SIZE = 16384,
    DATA_SIZE = 65536,
    INSTANCES_AT = 4096, /* in the data; then */
    SAVED_AT = 16384,    /* a serialized structure, and */
    QUERIED_AT = 32768,  /* results of queries */
    BOXES = 3,
    DISPLACED = 4, /* a structure of as many triangles */
};

static struct {
    PFN_vkTraceRaysASSAY trace_rays;
    struct scarce_commands commands;
    VkDeviceMemory data_memory;
    VkBuffer data;
    VkDeviceAddress address;
    VkFence fence;
    VkMicromapEXT micromap;
} own;

/* One triangle of a micromap for all, and it stays where it is. */
static const VkMicromapUsageEXT usage = {BOXES, 0,
                                         VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV};

/* ---- objects */

static VkDeviceMemory bind_memory(struct application *app, VkBuffer buffer, VkDeviceSize size)
{
    const VkDeviceMemory memory = allocate(app, size, HOST_MEMORY);
    bind_buffer(app, buffer, memory, 0);
    return memory;
}

static void create_structures(struct application *app)
{
    app->inputs = create_buffer(app, STRUCTURES * STRUCTURE_SIZE,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, 0);
    app->memory = bind_memory(app, app->inputs, STRUCTURES * STRUCTURE_SIZE);
    for (unsigned i = 0; i < STRUCTURES; i++)
        app->sets[i].accel =
            create_accel(app, app->inputs, i * STRUCTURE_SIZE, STRUCTURE_SIZE,
                         i == TLAS ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                   : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

void create_objects(struct application *app)
{
    create_structures(app);
    own.data =
        create_buffer(app, DATA_SIZE,
                      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                          VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                      0);
    own.data_memory = bind_memory(app, own.data, DATA_SIZE);
    own.address = address_of(app, own.data);
    scarce_commands_create(app, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                           &own.commands);
    const STRUCT(VkFenceCreateInfo, fence);
    CALL(app, CreateFence, app->device, &fence, NULL, &own.fence);
    own.trace_rays = scarce_find_tracing(app);
    own.micromap = create_micromap(app, app->inputs, 0, STRUCTURE_SIZE,
                                   VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV);
}

void destroy_objects(struct application *app)
{
    app->vk.DestroyFence(app->device, own.fence, NULL);
    app->vk.DestroyMicromapEXT(app->device, own.micromap, NULL);
    scarce_commands_destroy(app, &own.commands);
    for (unsigned i = 0; i < STRUCTURES; i++)
        app->vk.DestroyAccelerationStructureKHR(app->device, app->sets[i].accel, NULL);
    app->vk.DestroyBuffer(app->device, app->inputs, NULL);
    app->vk.FreeMemory(app->device, app->memory, NULL);
    app->vk.DestroyBuffer(app->device, own.data, NULL);
    app->vk.FreeMemory(app->device, own.data_memory, NULL);
}

/* ---- recordings */

static void build_micromap(struct application *app)
{
    static const VkMicromapTriangleEXT triangles[BOXES] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    static const uint8_t block[64];
    const STRUCT(VkMicromapBuildInfoEXT, info, .type = VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV,
                 .dstMicromap = own.micromap, .usageCountsCount = 1, .pUsageCounts = &usage,
                 .data.hostAddress = block, .triangleArray.hostAddress = triangles,
                 .triangleArrayStride = sizeof(triangles[0]));
    CALL(app, BuildMicromapsEXT, app->device, VK_NULL_HANDLE, 1, &info);
}

/* With vertices and vectors from the same zeros. */
static void displace(VkAccelerationStructureGeometryKHR *geometry,
                     VkAccelerationStructureTrianglesDisplacementMicromapNV *displacement)
{
    *displacement = MAKE(VkAccelerationStructureTrianglesDisplacementMicromapNV,
                         .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
                         .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
                         .displacementVectorBuffer.deviceAddress = own.address,
                         .displacementVectorStride = 12, .indexType = VK_INDEX_TYPE_NONE_KHR,
                         .usageCountsCount = 1, .pUsageCounts = &usage, .micromap = own.micromap);
    geometry->geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry->geometry.triangles =
        MAKE(VkAccelerationStructureGeometryTrianglesDataKHR, .pNext = displacement,
             .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexData.deviceAddress = own.address,
             .vertexStride = 12, .maxVertex = 3 * BOXES - 1, .indexType = VK_INDEX_TYPE_NONE_KHR);
}

static void record_build(struct application *app, VkCommandBuffer commands, unsigned n,
                         VkAccelerationStructureKHR src)
{
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
    const bool is_top = n == TLAS;
    STRUCT(VkAccelerationStructureGeometryKHR, geometry,
           .geometryType = is_top ? VK_GEOMETRY_TYPE_INSTANCES_KHR : VK_GEOMETRY_TYPE_AABBS_KHR);
    if (is_top)
        geometry.geometry.instances = MAKE(VkAccelerationStructureGeometryInstancesDataKHR,
                                           .data.deviceAddress = own.address + INSTANCES_AT);
    else
        geometry.geometry.aabbs =
            MAKE(VkAccelerationStructureGeometryAabbsDataKHR, .data.deviceAddress = own.address,
                 .stride = sizeof(VkAabbPositionsKHR));
    if (n == DISPLACED)
        displace(&geometry, &displacement);
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info,
                 .type = is_top ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
                          VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
                 .mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                             : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                 .srcAccelerationStructure = src, .dstAccelerationStructure = app->sets[n].accel,
                 .geometryCount = 1, .pGeometries = &geometry,
                 .scratchData.deviceAddress = own.address + DATA_SIZE / 2);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = BOXES};
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &range;
    app->vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

static VkResult record_secondary(struct application *app)
{
    VkResult result = begin_commands(app, own.commands.secondary);
    for (unsigned i = 0; result == VK_SUCCESS && i < BLASES; i++)
        record_build(app, own.commands.secondary, i, VK_NULL_HANDLE);
    return result == VK_SUCCESS ? app->vk.EndCommandBuffer(own.commands.secondary) : result;
}

static void record_copies(struct application *app)
{
    const VkCopyAccelerationStructureInfoKHR clone =
        copy_info(app->sets[1].accel, app->sets[CLONE].accel,
                  VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
    const VkCopyAccelerationStructureToMemoryInfoKHR save =
        serialize_info(app->sets[2].accel, own.address + SAVED_AT);
    const VkCopyMemoryToAccelerationStructureInfoKHR load =
        deserialize_info(own.address + SAVED_AT, app->sets[LOADED].accel);
    app->vk.CmdCopyAccelerationStructureKHR(own.commands.primary, &clone);
    app->vk.CmdCopyAccelerationStructureToMemoryKHR(own.commands.primary, &save);
    app->vk.CmdCopyMemoryToAccelerationStructureKHR(own.commands.primary, &load);
}

static VkResult record_primary(struct application *app)
{
    VkAccelerationStructureKHR queried[QUERIES];
    for (unsigned i = 0; i < QUERIES; i++)
        queried[i] = app->sets[i].accel;
    VkResult result = begin_commands(app, own.commands.primary);
    if (result != VK_SUCCESS)
        return result;
    app->vk.CmdExecuteCommands(own.commands.primary, 1, &own.commands.secondary);
    record_build(app, own.commands.primary, 0, app->sets[0].accel);
    record_build(app, own.commands.primary, TLAS, VK_NULL_HANDLE);
    record_copies(app);
    app->vk.CmdResetQueryPool(own.commands.primary, own.commands.queries, 0, QUERIES);
    app->vk.CmdWriteAccelerationStructuresPropertiesKHR(
        own.commands.primary, QUERIES, queried,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, own.commands.queries, 0);
    app->vk.CmdCopyQueryPoolResults(own.commands.primary, own.commands.queries, 0, QUERIES,
                                    own.data, QUERIED_AT, 8, VK_QUERY_RESULT_64_BIT);
    return app->vk.EndCommandBuffer(own.commands.primary);
}

/* ---- what became of it */

static void submit(struct application *app)
{
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 1,
                 .pCommandBuffers = &own.commands.primary);
    CALL(app, QueueSubmit, app->queue, 1, &info, own.fence);
    CALL(app, WaitForFences, app->device, 1, &own.fence, VK_TRUE, UINT64_MAX);
    CALL(app, ResetFences, app->device, 1, &own.fence);
}

static void look(struct application *app)
{
    for (unsigned i = 0; i < STRUCTURES; i++)
        scarce_trace(app, own.trace_rays, (uint64_t)app->sets[i].accel);
    scarce_get_results(app, &own.commands);
}

void record_all(struct application *app)
{
    if (!own.trace_rays)
        return;
    build_micromap(app);
    GET(app, "a secondary command buffer", record_secondary(app));
    GET(app, "a primary command buffer", record_primary(app));
    submit(app);
    submit(app);
    look(app);
    submit(app);
    look(app);
}
