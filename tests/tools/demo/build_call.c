/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of one vkCmdBuildAccelerationStructuresKHR. */
#include "build_call.h"

VkAccelerationStructureBuildGeometryInfoKHR *
build_call_add(struct build_call *call, VkAccelerationStructureTypeKHR type,
               VkBuildAccelerationStructureFlagsKHR flags,
               const VkAccelerationStructureGeometryKHR *geometry, uint32_t primitive_count)
{
    uint32_t i = call->count++;
    call->infos[i] =
        MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .type = type, .flags = flags,
             .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR, .geometryCount = 1);
    call->geometries[i][0] = *geometry;
    call->ranges[i][0] =
        (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = primitive_count};
    return &call->infos[i];
}

VkAccelerationStructureBuildSizesInfoKHR build_call_sizes(struct gpu *gpu, struct build_call *call,
                                                          uint32_t i)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes = MAKE(VkAccelerationStructureBuildSizesInfoKHR);
    call->infos[i].pGeometries = call->geometries[i];
    gpu->calls.GetAccelerationStructureBuildSizesKHR(
        gpu->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &call->infos[i],
        &call->ranges[i][0].primitiveCount, &sizes);
    return sizes;
}

void build_call_record(struct gpu *gpu, VkCommandBuffer commands, struct build_call *call)
{
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[BUILD_CALL_MAX];
    for (uint32_t i = 0; i < call->count; ++i) {
        call->infos[i].pGeometries = call->geometries[i];
        ranges[i] = call->ranges[i];
    }
    gpu->calls.CmdBuildAccelerationStructuresKHR(commands, call->count, call->infos, ranges);
}
