/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes on a stage that the tests of one program share, and what is expected there. */
#ifndef CPU_BACKEND_HOST_SCENE_H
#define CPU_BACKEND_HOST_SCENE_H

#include "tests/cpu_backend/host_fixture.h"
#include "tests/state/unit_test.h"

extern struct fixture fixture;

enum {
    UPDATABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
    COMPACTABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
};

void expect_silence(void);
/* Mistakes may be told or not: that is other tests' business. */
void forget_messages(void);

/* A BLAS of some triangles, and a TLAS with two instances of it. */
extern struct scene {
    struct fixture_build triangles, instances;
    struct fixture_structure blas, tlas;
} scene;
void open_scene(uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags);
void close_scene(void);
/* The same, with no message until now, or whatever there was. */
void close_silent_scene(void);
void close_any_scene(void);

/* The ray at (y, 0.25) hits the first triangle of an instance at t. */
void expect_hit(VkAccelerationStructureKHR structure, float y, float t, uint32_t instance);
void expect_scene(VkAccelerationStructureKHR tlas, float t);

/* By the host, and not deferred; an update if `src` isn't VK_NULL_HANDLE. */
VkResult host_build(struct fixture_build *build, VkAccelerationStructureKHR dst,
                    VkAccelerationStructureKHR src);

VkResult copy_structure(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                        VkCopyAccelerationStructureModeKHR mode);

uint64_t property(VkAccelerationStructureKHR structure, VkQueryType type);
/* Into new memory, which the caller frees. */
void *serialize(VkAccelerationStructureKHR src, size_t *size);

#endif
