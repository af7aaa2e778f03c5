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

static VkBuffer data;
static VkDeviceAddress address;
static VkFence fence;
static VkMicromapEXT micromap;

/* One triangle of a micromap for all, and it stays where it is. */
static const VkMicromapUsageEXT usage = {BOXES, 0,
                                         VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV};

/* ---- objects */

void create_objects(void)
{
    const VkBuffer buffer =
        create_bound_buffer(STRUCTURES * STRUCTURE_SIZE,
                            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                                VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT,
                            HOST_MEMORY);
    for (unsigned i = 0; i < STRUCTURES; i++)
        app.sets[i].accel =
            create_accel(buffer, i * STRUCTURE_SIZE, STRUCTURE_SIZE,
                         i == TLAS ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                   : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    data =
        create_bound_buffer(DATA_SIZE,
                            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                            HOST_MEMORY);
    address = address_of(data);
    scarce_create_commands(VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR);
    CREATE(Fence, &MAKE(VkFenceCreateInfo), &fence);
    scarce_find_tracing();
    micromap =
        create_micromap(buffer, 0, STRUCTURE_SIZE, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV);
}

/* ---- recordings */

/* With vertices and vectors from the same zeros. */
static void displace(VkAccelerationStructureGeometryKHR *geometry,
                     VkAccelerationStructureTrianglesDisplacementMicromapNV *displacement)
{
    *displacement = scarce_displacement(micromap, &usage, address);
    geometry->geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry->geometry.triangles =
        MAKE(VkAccelerationStructureGeometryTrianglesDataKHR, .pNext = displacement,
             .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexData.deviceAddress = address,
             .vertexStride = 12, .maxVertex = 3 * BOXES - 1, .indexType = VK_INDEX_TYPE_NONE_KHR);
}

static void record_build(VkCommandBuffer commands, unsigned n, VkAccelerationStructureKHR src)
{
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
    const bool is_top = n == TLAS;
    STRUCT(VkAccelerationStructureGeometryKHR, geometry,
           .geometryType = is_top ? VK_GEOMETRY_TYPE_INSTANCES_KHR : VK_GEOMETRY_TYPE_AABBS_KHR);
    if (is_top)
        geometry.geometry.instances = MAKE(VkAccelerationStructureGeometryInstancesDataKHR,
                                           .data.deviceAddress = address + INSTANCES_AT);
    else
        geometry.geometry.aabbs =
            MAKE(VkAccelerationStructureGeometryAabbsDataKHR, .data.deviceAddress = address,
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
                 .srcAccelerationStructure = src, .dstAccelerationStructure = app.sets[n].accel,
                 .geometryCount = 1, .pGeometries = &geometry,
                 .scratchData.deviceAddress = address + DATA_SIZE / 2);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = BOXES};
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &range;
    vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

static VkResult record_secondary(void)
{
    VkResult result = begin_commands(secondary);
    for (unsigned i = 0; result == VK_SUCCESS && i < BLASES; i++)
        record_build(secondary, i, VK_NULL_HANDLE);
    return result == VK_SUCCESS ? vk.EndCommandBuffer(secondary) : result;
}

static void record_copies(void)
{
    const VkCopyAccelerationStructureInfoKHR clone = copy_info(
        app.sets[1].accel, app.sets[CLONE].accel, VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
    const VkCopyAccelerationStructureToMemoryInfoKHR save =
        serialize_info(app.sets[2].accel, address + SAVED_AT);
    const VkCopyMemoryToAccelerationStructureInfoKHR load =
        deserialize_info(address + SAVED_AT, app.sets[LOADED].accel);
    vk.CmdCopyAccelerationStructureKHR(primary, &clone);
    vk.CmdCopyAccelerationStructureToMemoryKHR(primary, &save);
    vk.CmdCopyMemoryToAccelerationStructureKHR(primary, &load);
}

static VkResult record_primary(void)
{
    VkAccelerationStructureKHR queried[QUERIES];
    for (unsigned i = 0; i < QUERIES; i++)
        queried[i] = app.sets[i].accel;
    VkResult result = begin_commands(primary);
    if (result != VK_SUCCESS)
        return result;
    vk.CmdExecuteCommands(primary, 1, &secondary);
    record_build(primary, 0, app.sets[0].accel);
    record_build(primary, TLAS, VK_NULL_HANDLE);
    record_copies();
    vk.CmdResetQueryPool(primary, queries, 0, QUERIES);
    vk.CmdWriteAccelerationStructuresPropertiesKHR(
        primary, QUERIES, queried, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, queries,
        0);
    vk.CmdCopyQueryPoolResults(primary, queries, 0, QUERIES, data, QUERIED_AT, 8,
                               VK_QUERY_RESULT_64_BIT);
    return vk.EndCommandBuffer(primary);
}

/* ---- what became of it */

static void submit(void)
{
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 1, .pCommandBuffers = &primary);
    CALL(QueueSubmit, queue, 1, &info, fence);
    CALL(WaitForFences, device, 1, &fence, VK_TRUE, UINT64_MAX);
    CALL(ResetFences, device, 1, &fence);
}

static void look(void)
{
    for (unsigned i = 0; i < STRUCTURES; i++)
        scarce_trace((uint64_t)app.sets[i].accel);
    scarce_get_results();
}

void record_all(void)
{
    if (!trace_rays)
        return;
    scarce_build_micromap(micromap, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV, &usage);
    GET("a secondary command buffer", record_secondary());
    GET("a primary command buffer", record_primary());
    submit();
    submit();
    look();
    submit();
    look();
}
