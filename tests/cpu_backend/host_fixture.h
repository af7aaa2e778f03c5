/* SPDX-License-Identifier: Apache-2.0 */
/* The device that the tests of a program share: of backend cpu over a driver that has no
 * acceleration structures; and scenes built there by the host. What fails though it should not ends
 * the test.
 *
 * All that the functions here make lasts until the end of the test: SILENT_TEST or NOISY_TEST. */
#ifndef ASSAY_TESTS_CPU_BACKEND_HOST_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_HOST_FIXTURE_H

#include "tests/cpu_backend/instance_fixture.h"
#include "tests/fixture/trace.h"
#include "tests/unit/unit_test.h"

#define expect_mistake(call) assert_int_equal(call, VK_ERROR_VALIDATION_FAILED)

enum {
    UPDATABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
};
static const VkAccelerationStructureTypeKHR BOTTOM =
                                                VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                            TOP = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
static const VkCopyAccelerationStructureModeKHR CLONE =
    VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR;
static const VkQueryType STRUCTURE_SIZE = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR,
                         SERIALIZATION_SIZE =
                             VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR;

extern struct platform platform;
extern struct instance_fixture instance;
extern struct messages *const messages; /* of the instance */
extern VkDevice device;
extern VkuDeviceDispatchTable vk;
extern PFN_vkTraceRaysASSAY trace_rays;
extern uint32_t host_memory_type;
extern VkQueue queue, second_queue; /* the second one on the null driver alone */
extern VkCommandPool command_pool;

/* Makes another device the program's. */
void fixture_use_device(VkDevice other, const VkuDeviceDispatchTable *other_vk);

/* ---- the end of a test */

/* A test during which the layer sends no message, and one that checks those of its concern, if any.
 */
#define SILENT_TEST(name) TEST_CLOSED(name, close_silent_test)
#define NOISY_TEST(name) TEST_CLOSED(name, close_noisy_test)
void close_silent_test(void);
void close_noisy_test(void);

/* Destroys an object at the end: OWN(DestroyFence, fence). Commands that are NULL free memory. */
#define OWN(command, handle) own((PFN_vkVoidFunction)vk.command, (uint64_t)(handle))
void own(PFN_vkVoidFunction destroy, uint64_t handle);
void *own_block(void *block);
/* Destroys an object now. */
void destroy(uint64_t handle);
/* Destroys all of them now. */
void destroy_all(void);

/* ---- structures */

/* With a buffer of its own. */
struct fixture_structure {
    VkAccelerationStructureKHR handle;
    struct device_buffer storage;
    VkDeviceSize size;
};
struct fixture_structure fixture_create(VkAccelerationStructureTypeKHR type, VkDeviceSize size);
struct fixture_structure fixture_create_blas(VkDeviceSize size);

/* Parameters of a build of one geometry, with the memory behind them. Not to be moved. */
struct fixture_build {
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureBuildRangeInfoKHR range;
    void *data, *scratch;
    VkDeviceSize size; /* of the data */
};

/* `count` triangles in the planes x = 0, 1, 2 ...: (x, 0, 0), (x, 1, 0), (x, 0, 1). */
void fixture_triangles(struct fixture_build *build, uint32_t count,
                       VkBuildAccelerationStructureFlagsKHR flags);
void fixture_move(struct fixture_build *build, float x, float y, float z); /* the triangles */

/* Instance i of `blases[i]`, moved by (0, 2 * i, 0), with custom index 100 + i. */
void fixture_instances(struct fixture_build *build, const VkAccelerationStructureKHR *blases,
                       uint32_t count, VkBuildAccelerationStructureFlagsKHR flags);

VkAccelerationStructureBuildSizesInfoKHR fixture_sizes(const struct fixture_build *build);
/* Scratch for builds and updates. */
VkDeviceSize fixture_scratch_size(const struct fixture_build *build);
/* Takes scratch, and a structure of the size that the build needs, with motion where that has. */
struct fixture_structure fixture_create_for(struct fixture_build *build);
/* vkBuildAccelerationStructuresKHR; an update where `src` isn't VK_NULL_HANDLE. */
VkResult fixture_build(VkDeferredOperationKHR operation, struct fixture_build *build,
                       VkAccelerationStructureKHR dst, VkAccelerationStructureKHR src);
VkResult host_build(struct fixture_build *build, VkAccelerationStructureKHR dst,
                    VkAccelerationStructureKHR src); /* not deferred */

/* vkCopyAccelerationStructureKHR and its kin. */
VkResult fixture_copy(VkDeferredOperationKHR operation, VkAccelerationStructureKHR src,
                      VkAccelerationStructureKHR dst, VkCopyAccelerationStructureModeKHR mode);
VkResult fixture_save(VkDeferredOperationKHR operation, VkAccelerationStructureKHR src, void *dst);
VkResult fixture_load(VkDeferredOperationKHR operation, const void *src,
                      VkAccelerationStructureKHR dst);
VkResult host_copy(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                   VkCopyAccelerationStructureModeKHR mode); /* not deferred */
/* The serialized form of a structure. */
void *fixture_serialize(VkAccelerationStructureKHR structure, size_t *size);
void expect_same_bytes(VkAccelerationStructureKHR a, VkAccelerationStructureKHR b);

/* A BLAS of some triangles, and a TLAS with two instances of it. */
extern struct pair {
    struct fixture_build triangles, instances;
    struct fixture_structure blas, tlas;
} pair;
void open_pair(uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags);
/* Destroys its structures now. */
void destroy_pair(void);

/* Rays hit the first triangle of both instances at t. */
void expect_pair(VkAccelerationStructureKHR tlas, float t);

/* The result of a call that traces no ray. */
VkResult fixture_trace_none(VkAccelerationStructureKHR structure);
/* A ray from (-1, y, z) towards +x. */
AssayHit fixture_trace(VkAccelerationStructureKHR structure, float y, float z);
AssayCounters fixture_counters(void);

#endif
