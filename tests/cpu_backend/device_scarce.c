/* SPDX-License-Identifier: Apache-2.0 */
/* What an application does on backend cpu in each life of tests/scarce, in command buffers: builds,
 * copies and queries, recorded or submitted again where memory was lacking. The null driver copies
 * nothing, so all boxes are points at the origin. */
#include <string.h>

#include "../scarce/application_parts.h"
#include "assay.h"

enum {
    BLASES = 20,
    TLAS = BLASES,
    CLONE,
    LOADED,
    STRUCTURES,
    STRUCTURE_SIZE = 16384,
    DATA_SIZE = 65536,
    HOST_MEMORY_TYPE = 1,
    INSTANCES_AT = 4096, /* in the data; then */
    SAVED_AT = 16384,    /* a serialized structure, and */
    QUERIED_AT = 32768,  /* results of queries */
    BOXES = 3,
};

static struct {
    PFN_vkTraceRaysASSAY trace_rays;
    VkCommandPool pool;
    VkCommandBuffer primary, secondary;
    VkDeviceMemory data_memory;
    VkBuffer data;
    VkDeviceAddress address;
    VkQueryPool queries;
    VkFence fence;
} own;

/* ---- objects */

static VkDeviceMemory bind_memory(struct application *app, VkBuffer buffer, VkDeviceSize size)
{
    VkDeviceMemory memory = VK_NULL_HANDLE;
    const VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                             .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                       .pNext = &flags,
                                       .allocationSize = size,
                                       .memoryTypeIndex = HOST_MEMORY_TYPE};
    GET(app, "vkAllocateMemory", app->vk.AllocateMemory(app->device, &info, NULL, &memory));
    GET(app, "vkBindBufferMemory", app->vk.BindBufferMemory(app->device, buffer, memory, 0));
    return memory;
}

static void create_structures(struct application *app)
{
    app->inputs = create_buffer(app, STRUCTURES * STRUCTURE_SIZE,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, 0);
    app->memory = bind_memory(app, app->inputs, STRUCTURES * STRUCTURE_SIZE);
    for (unsigned i = 0; i < STRUCTURES; i++) {
        const VkAccelerationStructureCreateInfoKHR info = {
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
            .buffer = app->inputs,
            .offset = i * STRUCTURE_SIZE,
            .size = STRUCTURE_SIZE,
            .type = i == TLAS ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                              : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR};
        GET(app, "vkCreateAccelerationStructureKHR",
            app->vk.CreateAccelerationStructureKHR(app->device, &info, NULL, &app->sets[i].accel));
    }
}

static void create_commands(struct application *app)
{
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT};
    GET(app, "vkCreateCommandPool", app->vk.CreateCommandPool(app->device, &pool, NULL, &own.pool));
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                        .commandPool = own.pool,
                                        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                        .commandBufferCount = 1};
    GET(app, "vkAllocateCommandBuffers",
        app->vk.AllocateCommandBuffers(app->device, &info, &own.primary));
    info.level = VK_COMMAND_BUFFER_LEVEL_SECONDARY;
    GET(app, "vkAllocateCommandBuffers",
        app->vk.AllocateCommandBuffers(app->device, &info, &own.secondary));
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
    create_commands(app);
    const VkQueryPoolCreateInfo queries = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
        .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        .queryCount = QUERIES};
    GET(app, "vkCreateQueryPool",
        app->vk.CreateQueryPool(app->device, &queries, NULL, &own.queries));
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    GET(app, "vkCreateFence", app->vk.CreateFence(app->device, &fence, NULL, &own.fence));
    own.trace_rays =
        (PFN_vkTraceRaysASSAY)app->vk.GetDeviceProcAddr(app->device, "vkTraceRaysASSAY");
    /* With memory short, the library that reads settings may lose one without telling; then the
     * backend is the driver's. */
    app->outcome->mistakes++;
    app->outcome->expected += own.trace_rays != NULL;
}

void destroy_objects(struct application *app)
{
    app->vk.DestroyFence(app->device, own.fence, NULL);
    app->vk.DestroyQueryPool(app->device, own.queries, NULL);
    app->vk.DestroyCommandPool(app->device, own.pool, NULL);
    for (unsigned i = 0; i < STRUCTURES; i++)
        app->vk.DestroyAccelerationStructureKHR(app->device, app->sets[i].accel, NULL);
    app->vk.DestroyBuffer(app->device, app->inputs, NULL);
    app->vk.FreeMemory(app->device, app->memory, NULL);
    app->vk.DestroyBuffer(app->device, own.data, NULL);
    app->vk.FreeMemory(app->device, own.data_memory, NULL);
}

/* ---- recordings */

static void record_build(struct application *app, VkCommandBuffer commands, unsigned n,
                         VkAccelerationStructureKHR src)
{
    const bool is_top = n == TLAS;
    VkAccelerationStructureGeometryKHR geometry = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .geometryType = is_top ? VK_GEOMETRY_TYPE_INSTANCES_KHR : VK_GEOMETRY_TYPE_AABBS_KHR};
    if (is_top)
        geometry.geometry.instances = (VkAccelerationStructureGeometryInstancesDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
            .data.deviceAddress = own.address + INSTANCES_AT};
    else
        geometry.geometry.aabbs = (VkAccelerationStructureGeometryAabbsDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR,
            .data.deviceAddress = own.address,
            .stride = sizeof(VkAabbPositionsKHR)};
    const VkAccelerationStructureBuildGeometryInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = is_top ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                       : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
                 VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
        .mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                    : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
        .srcAccelerationStructure = src,
        .dstAccelerationStructure = app->sets[n].accel,
        .geometryCount = 1,
        .pGeometries = &geometry,
        .scratchData.deviceAddress = own.address + DATA_SIZE / 2};
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = BOXES};
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &range;
    app->vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

static VkResult begin(const struct application *app, VkCommandBuffer commands)
{
    const VkCommandBufferInheritanceInfo inheritance = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .pInheritanceInfo = &inheritance};
    return app->vk.BeginCommandBuffer(commands, &info);
}

static VkResult record_secondary(struct application *app)
{
    VkResult result = begin(app, own.secondary);
    for (unsigned i = 0; result == VK_SUCCESS && i < BLASES; i++)
        record_build(app, own.secondary, i, VK_NULL_HANDLE);
    return result == VK_SUCCESS ? app->vk.EndCommandBuffer(own.secondary) : result;
}

static void record_copies(struct application *app)
{
    const VkCopyAccelerationStructureInfoKHR clone = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = app->sets[1].accel,
        .dst = app->sets[CLONE].accel,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR};
    const VkCopyAccelerationStructureToMemoryInfoKHR save = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_TO_MEMORY_INFO_KHR,
        .src = app->sets[2].accel,
        .dst.deviceAddress = own.address + SAVED_AT,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR};
    const VkCopyMemoryToAccelerationStructureInfoKHR load = {
        .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_ACCELERATION_STRUCTURE_INFO_KHR,
        .src.deviceAddress = own.address + SAVED_AT,
        .dst = app->sets[LOADED].accel,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR};
    app->vk.CmdCopyAccelerationStructureKHR(own.primary, &clone);
    app->vk.CmdCopyAccelerationStructureToMemoryKHR(own.primary, &save);
    app->vk.CmdCopyMemoryToAccelerationStructureKHR(own.primary, &load);
}

static VkResult record_primary(struct application *app)
{
    VkAccelerationStructureKHR queried[QUERIES];
    for (unsigned i = 0; i < QUERIES; i++)
        queried[i] = app->sets[i].accel;
    VkResult result = begin(app, own.primary);
    if (result != VK_SUCCESS)
        return result;
    app->vk.CmdExecuteCommands(own.primary, 1, &own.secondary);
    record_build(app, own.primary, 0, app->sets[0].accel);
    record_build(app, own.primary, TLAS, VK_NULL_HANDLE);
    record_copies(app);
    app->vk.CmdResetQueryPool(own.primary, own.queries, 0, QUERIES);
    app->vk.CmdWriteAccelerationStructuresPropertiesKHR(
        own.primary, QUERIES, queried, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        own.queries, 0);
    app->vk.CmdCopyQueryPoolResults(own.primary, own.queries, 0, QUERIES, own.data, QUERIED_AT, 8,
                                    VK_QUERY_RESULT_64_BIT);
    return app->vk.EndCommandBuffer(own.primary);
}

/* ---- what became of it */

static void submit(struct application *app)
{
    const VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &own.primary};
    GET(app, "vkQueueSubmit", app->vk.QueueSubmit(app->queue, 1, &info, own.fence));
    GET(app, "vkWaitForFences",
        app->vk.WaitForFences(app->device, 1, &own.fence, VK_TRUE, UINT64_MAX));
    GET(app, "vkResetFences", app->vk.ResetFences(app->device, 1, &own.fence));
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
    for (unsigned i = 0; i < STRUCTURES; i++) {
        info.accelerationStructure = (uint64_t)app->sets[i].accel;
        own.trace_rays(app->device, &info);
    }
    app->vk.GetQueryPoolResults(app->device, own.queries, 0, QUERIES, sizeof(sizes), sizes,
                                sizeof(sizes[0]), VK_QUERY_RESULT_64_BIT);
}

void record_all(struct application *app)
{
    if (!own.trace_rays)
        return;
    GET(app, "a secondary command buffer", record_secondary(app));
    GET(app, "a primary command buffer", record_primary(app));
    submit(app);
    submit(app);
    look(app);
    submit(app);
    look(app);
}
