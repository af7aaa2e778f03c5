/* SPDX-License-Identifier: Apache-2.0 */
/* A device of backend cpu over a driver that has no acceleration structures, and scenes built there
 * by the host. What fails though it should not ends the test. */
#ifndef CPU_BACKEND_HOST_STAGE_H
#define CPU_BACKEND_HOST_STAGE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kit.h"
#include "layer/assay.h"

struct stage {
    struct platform platform;
    struct kit kit;
    VkDevice device;
    VkuDeviceDispatchTable vk;
    PFN_vkTraceRaysASSAY trace_rays;
    PFN_vkGetCountersASSAY get_counters;
    uint32_t host_memory_type;
};

/* Returns NULL, or why the platform can't be used here. */
const char *stage_open(struct stage *stage, const char *platform);
void stage_close(struct stage *stage);

/* Makes another device the stage's. */
void stage_use_device(struct stage *stage, VkDevice device, const VkuDeviceDispatchTable *vk);

/* A structure with a buffer of its own. */
struct stage_structure {
    VkAccelerationStructureKHR handle;
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize size;
};
struct stage_structure stage_create(struct stage *stage, VkAccelerationStructureTypeKHR type,
                                    VkDeviceSize size);
void stage_destroy(struct stage *stage, struct stage_structure *structure);

/* Parameters of a build of one geometry, with the memory behind them. Not to be moved. */
struct stage_build {
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureBuildRangeInfoKHR range;
    void *data, *scratch;
};

/* `count` triangles in the planes x = 0, 1, 2 ...: (x, 0, 0), (x, 1, 0), (x, 0, 1). */
void stage_triangles(struct stage_build *build, uint32_t count,
                     VkBuildAccelerationStructureFlagsKHR flags);
void stage_move(struct stage_build *build, float x, float y, float z); /* the triangles */

/* Instance i of `blases[i]`, moved by (0, 2 * i, 0), with custom index 100 + i. */
void stage_instances(struct stage_build *build, const VkAccelerationStructureKHR *blases,
                     uint32_t count, VkBuildAccelerationStructureFlagsKHR flags);
void stage_free(struct stage_build *build);

VkAccelerationStructureBuildSizesInfoKHR stage_sizes(struct stage *stage,
                                                     const struct stage_build *build);
/* Takes scratch, and a structure of the size that the build needs, with motion where that has. */
struct stage_structure stage_create_for(struct stage *stage, struct stage_build *build);
/* vkBuildAccelerationStructuresKHR; an update where `src` isn't VK_NULL_HANDLE. */
VkResult stage_build(struct stage *stage, VkDeferredOperationKHR operation,
                     struct stage_build *build, VkAccelerationStructureKHR dst,
                     VkAccelerationStructureKHR src);

/* A ray from (-1, y, z) towards +x, exact. */
AssayHit stage_trace(struct stage *stage, VkAccelerationStructureKHR structure, float y, float z);
AssayHit stage_trace_at(struct stage *stage, VkAccelerationStructureKHR structure, float y, float z,
                        float time);
AssayCounters stage_counters(struct stage *stage);

#endif
