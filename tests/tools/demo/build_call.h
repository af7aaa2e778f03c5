/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of one vkCmdBuildAccelerationStructuresKHR, in one place where they can be changed
 * before it is recorded. */
#ifndef DEMO_BUILD_CALL_H
#define DEMO_BUILD_CALL_H

#include "gpu.h"

#define BUILD_CALL_MAX 2 /* builds a call, and geometries a build */

/* Build i is infos[i] with geometries[i] and ranges[i]. The pointers between them are set at the
 * time of recording, so a call may be copied. */
struct build_call {
    uint32_t count;
    VkAccelerationStructureBuildGeometryInfoKHR infos[BUILD_CALL_MAX];
    VkAccelerationStructureGeometryKHR geometries[BUILD_CALL_MAX][BUILD_CALL_MAX];
    VkAccelerationStructureBuildRangeInfoKHR ranges[BUILD_CALL_MAX][BUILD_CALL_MAX];
};

/* Add a build of one geometry and that many primitives; dst and scratch are still to be set. */
VkAccelerationStructureBuildGeometryInfoKHR *
build_call_add(struct build_call *call, VkAccelerationStructureTypeKHR type,
               VkBuildAccelerationStructureFlagsKHR flags,
               const VkAccelerationStructureGeometryKHR *geometry, uint32_t primitive_count);

/* The sizes of build i, of a call that is valid. */
VkAccelerationStructureBuildSizesInfoKHR build_call_sizes(struct gpu *gpu, struct build_call *call,
                                                          uint32_t i);

void build_call_record(struct gpu *gpu, VkCommandBuffer commands, struct build_call *call);

#endif
