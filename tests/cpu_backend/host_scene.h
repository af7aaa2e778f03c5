/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes on a stage that the tests of one program share, and what is expected there. */
#ifndef CPU_BACKEND_HOST_SCENE_H
#define CPU_BACKEND_HOST_SCENE_H

#include "tests/cpu_backend/host_fixture.h"

enum {
    UPDATABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
    COMPACTABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
};

/* A BLAS of some triangles, and a TLAS with two instances of it. */
extern struct scene {
    struct fixture_build triangles, instances;
    struct fixture_structure blas, tlas;
} scene;
void open_scene(uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags);
/* Destroys its structures now. */
void destroy_scene(void);

/* The ray at (y, 0.25) hits the first triangle of an instance at t. */
void expect_hit(VkAccelerationStructureKHR structure, float y, float t, uint32_t number);
void expect_scene(VkAccelerationStructureKHR tlas, float t);

/* Not deferred. */
VkResult copy_structure(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                        VkCopyAccelerationStructureModeKHR mode);

#endif
