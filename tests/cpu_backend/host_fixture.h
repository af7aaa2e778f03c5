/* SPDX-License-Identifier: Apache-2.0 */
/* A device of backend cpu over a driver that has no acceleration structures, and scenes built there
 * by the host. What fails though it should not ends the test. */
#ifndef ASSAY_TESTS_CPU_BACKEND_HOST_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_HOST_FIXTURE_H

#include "tests/cpu_backend/instance_fixture.h"
#include "tests/fixture/trace.h"

#define expect_mistake(call) assert_int_equal(call, VK_ERROR_VALIDATION_FAILED)

struct fixture {
    struct platform platform;
    struct instance_fixture instance_fixture;
    VkDevice device;
    VkuDeviceDispatchTable vk;
    PFN_vkTraceRaysASSAY trace_rays;
    PFN_vkGetCountersASSAY get_counters;
    uint32_t host_memory_type;
};

/* Returns NULL, or why the platform can't be used here. */
const char *fixture_open(struct fixture *fixture, const char *platform);
void fixture_close(struct fixture *fixture);

/* Makes another device the stage's. */
void fixture_use_device(struct fixture *fixture, VkDevice device, const VkuDeviceDispatchTable *vk);

/* A structure with a buffer of its own. */
struct fixture_structure {
    VkAccelerationStructureKHR handle;
    struct device_buffer storage;
    VkDeviceSize size;
};
struct fixture_structure fixture_create(struct fixture *fixture,
                                        VkAccelerationStructureTypeKHR type, VkDeviceSize size);
struct fixture_structure fixture_create_blas(struct fixture *fixture, VkDeviceSize size);
void fixture_destroy(struct fixture *fixture, struct fixture_structure *structure);

/* Parameters of a build of one geometry, with the memory behind them. Not to be moved. */
struct fixture_build {
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureBuildRangeInfoKHR range;
    void *data, *scratch;
};

/* `count` triangles in the planes x = 0, 1, 2 ...: (x, 0, 0), (x, 1, 0), (x, 0, 1). */
void fixture_triangles(struct fixture_build *build, uint32_t count,
                       VkBuildAccelerationStructureFlagsKHR flags);
void fixture_move(struct fixture_build *build, float x, float y, float z); /* the triangles */

/* Instance i of `blases[i]`, moved by (0, 2 * i, 0), with custom index 100 + i. */
void fixture_instances(struct fixture_build *build, const VkAccelerationStructureKHR *blases,
                       uint32_t count, VkBuildAccelerationStructureFlagsKHR flags);
void fixture_free(struct fixture_build *build);

VkAccelerationStructureBuildSizesInfoKHR fixture_sizes(struct fixture *fixture,
                                                       const struct fixture_build *build);
/* Takes scratch, and a structure of the size that the build needs, with motion where that has. */
struct fixture_structure fixture_create_for(struct fixture *fixture, struct fixture_build *build);
/* vkBuildAccelerationStructuresKHR; an update where `src` isn't VK_NULL_HANDLE. */
VkResult fixture_build(struct fixture *fixture, VkDeferredOperationKHR operation,
                       struct fixture_build *build, VkAccelerationStructureKHR dst,
                       VkAccelerationStructureKHR src);

/* vkCopyAccelerationStructureKHR and its kin. */
VkResult fixture_copy(struct fixture *fixture, VkDeferredOperationKHR operation,
                      VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                      VkCopyAccelerationStructureModeKHR mode);
VkResult fixture_save(struct fixture *fixture, VkDeferredOperationKHR operation,
                      VkAccelerationStructureKHR src, void *dst);
VkResult fixture_load(struct fixture *fixture, VkDeferredOperationKHR operation, const void *src,
                      VkAccelerationStructureKHR dst);
uint64_t fixture_property(struct fixture *fixture, VkAccelerationStructureKHR structure,
                          VkQueryType type);
/* The serialized form of a structure; for free(). */
void *fixture_serialize(struct fixture *fixture, VkAccelerationStructureKHR structure,
                        size_t *size);

/* A ray from (-1, y, z) towards +x, exact. */
AssayHit fixture_trace(struct fixture *fixture, VkAccelerationStructureKHR structure, float y,
                       float z);
AssayHit fixture_trace_at(struct fixture *fixture, VkAccelerationStructureKHR structure, float y,
                          float z, float time);
AssayCounters fixture_counters(struct fixture *fixture);

#endif
