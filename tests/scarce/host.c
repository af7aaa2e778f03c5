/* SPDX-License-Identifier: Apache-2.0 */
/* What the application builds and copies on the host, at once and deferred. */
#include "application_parts.h"
#include "tests/fixture/copies.h"

enum { STRUCTURES = 3 };

static VkDeviceMemory memory;
static VkAccelerationStructureKHR accels[STRUCTURES];
static VkDeferredOperationKHR deferred;
static const float vertices[9];
static char scratch[SCRATCH_SIZE];

static void create_structures(void)
{
    void *mapped;
    memory = allocate(STRUCTURES * ACCEL_SIZE, HOST_MEMORY);
    CALL(MapMemory, device, memory, 0, VK_WHOLE_SIZE, 0, &mapped);
    const VkBuffer buffer = create_buffer(
        STRUCTURES * ACCEL_SIZE, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, 0);
    bind_buffer(buffer, memory, 0);
    for (unsigned i = 0; i < STRUCTURES; i++)
        accels[i] = create_accel(buffer, i * ACCEL_SIZE, ACCEL_SIZE,
                                 VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    CALL(CreateDeferredOperationKHR, device, NULL, &deferred);
    OWN(DestroyDeferredOperationKHR, deferred);
}

static void build(VkDeferredOperationKHR operation, VkBuildAccelerationStructureFlagsKHR more_flags,
                  VkAccelerationStructureKHR dst, VkAccelerationStructureKHR src)
{
    const VkAccelerationStructureGeometryKHR geometry =
        describe_triangles((VkDeviceOrHostAddressConstKHR){.hostAddress = vertices}, NULL);
    VkAccelerationStructureBuildGeometryInfoKHR info = describe_build(dst, src, 1, &geometry);
    info.flags |= more_flags;
    info.scratchData.hostAddress = scratch;
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 1};
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &range;
    VkResult result = vk.BuildAccelerationStructuresKHR(device, operation, 1, &info, &ranges);
    if (result != (operation ? VK_OPERATION_DEFERRED_KHR : VK_SUCCESS))
        complain("vkBuildAccelerationStructuresKHR", result);
}

void work_on_host(void)
{
    create_structures();
    build(VK_NULL_HANDLE, 0, accels[0], VK_NULL_HANDLE);
    build(VK_NULL_HANDLE, 0, accels[1], accels[0]);
    const VkCopyAccelerationStructureInfoKHR copy =
        copy_info(accels[1], accels[2], VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    CALL(CopyAccelerationStructureKHR, device, VK_NULL_HANDLE, &copy);
    for (unsigned i = 0; i < 2; i++) {
        build(deferred, 0, accels[0], VK_NULL_HANDLE);
        CALL(DeferredOperationJoinKHR, device, deferred);
        CALL(GetDeferredOperationResultKHR, device, deferred);
    }
    expect("VUID-vkBuildAccelerationStructuresKHR-pInfos-03759");
    build(VK_NULL_HANDLE, VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR, accels[2],
          accels[0]);
    expect_nothing_more();
    vk.UnmapMemory(device, memory);
}
