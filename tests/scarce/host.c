/* SPDX-License-Identifier: Apache-2.0 */
/* What the application builds and copies on the host, at once and deferred. */
#include "application_parts.h"
#include "tests/fixture/copies.h"

enum { STRUCTURES = 3 };

struct host {
    VkDeviceMemory memory;
    VkBuffer buffer;
    VkAccelerationStructureKHR accels[STRUCTURES];
    VkDeferredOperationKHR operation;
    float vertices[9];
    char scratch[SCRATCH_SIZE];
};

static void create_structures(struct application *app, struct host *host)
{
    void *mapped;
    host->memory = allocate(app, STRUCTURES * ACCEL_SIZE, HOST_MEMORY);
    CALL(app, MapMemory, app->device, host->memory, 0, VK_WHOLE_SIZE, 0, &mapped);
    host->buffer = create_buffer(app, STRUCTURES * ACCEL_SIZE,
                                 VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, 0);
    bind_buffer(app, host->buffer, host->memory, 0);
    for (unsigned i = 0; i < STRUCTURES; i++)
        host->accels[i] = create_accel(app, host->buffer, i * ACCEL_SIZE, ACCEL_SIZE,
                                       VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    CALL(app, CreateDeferredOperationKHR, app->device, NULL, &host->operation);
}

static void destroy_structures(struct application *app, struct host *host)
{
    app->vk.DestroyDeferredOperationKHR(app->device, host->operation, NULL);
    for (unsigned i = 0; i < STRUCTURES; i++)
        app->vk.DestroyAccelerationStructureKHR(app->device, host->accels[i], NULL);
    app->vk.DestroyBuffer(app->device, host->buffer, NULL);
    app->vk.UnmapMemory(app->device, host->memory);
    app->vk.FreeMemory(app->device, host->memory, NULL);
}

static void build(struct application *app, struct host *host, VkDeferredOperationKHR operation,
                  VkBuildAccelerationStructureFlagsKHR flags, VkAccelerationStructureKHR dst,
                  VkAccelerationStructureKHR src)
{
    const VkAccelerationStructureGeometryKHR geometry =
        describe_triangles((VkDeviceOrHostAddressConstKHR){.hostAddress = host->vertices}, NULL);
    const VkAccelerationStructureBuildGeometryInfoKHR info =
        MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
             .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, .flags = flags,
             .mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                         : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
             .srcAccelerationStructure = src, .dstAccelerationStructure = dst, .geometryCount = 1,
             .pGeometries = &geometry, .scratchData.hostAddress = host->scratch);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 1};
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &range;
    VkResult result =
        app->vk.BuildAccelerationStructuresKHR(app->device, operation, 1, &info, &ranges);
    if (result != (operation ? VK_OPERATION_DEFERRED_KHR : VK_SUCCESS))
        complain(app, "vkBuildAccelerationStructuresKHR", result);
}

static void copy(struct application *app, VkAccelerationStructureKHR src,
                 VkAccelerationStructureKHR dst)
{
    const VkCopyAccelerationStructureInfoKHR info =
        copy_info(src, dst, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    CALL(app, CopyAccelerationStructureKHR, app->device, VK_NULL_HANDLE, &info);
}

void work_on_host(struct application *app)
{
    enum { ALLOW_UPDATE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR };
    static struct host host;
    create_structures(app, &host);
    build(app, &host, VK_NULL_HANDLE, ALLOW_UPDATE, host.accels[0], VK_NULL_HANDLE);
    build(app, &host, VK_NULL_HANDLE, ALLOW_UPDATE, host.accels[1], host.accels[0]);
    copy(app, host.accels[1], host.accels[2]);
    for (unsigned i = 0; i < 2; i++) {
        build(app, &host, host.operation, ALLOW_UPDATE, host.accels[0], VK_NULL_HANDLE);
        CALL(app, DeferredOperationJoinKHR, app->device, host.operation);
        CALL(app, GetDeferredOperationResultKHR, app->device, host.operation);
    }
    expect(app, "VUID-vkBuildAccelerationStructuresKHR-pInfos-03759");
    build(app, &host, VK_NULL_HANDLE,
          ALLOW_UPDATE | VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR, host.accels[2],
          host.accels[0]);
    expect_nothing_more(app);
    destroy_structures(app, &host);
}
