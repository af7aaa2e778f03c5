/* SPDX-License-Identifier: Apache-2.0 */
/* A scene that moves (VK_NV_ray_tracing_motion_blur). */
#ifndef CPU_BACKEND_MOTION_SCENE_H
#define CPU_BACKEND_MOTION_SCENE_H

#include "tests/cpu_backend/host_fixture.h"

enum {
    MOVING_TRIANGLES = 3,
    MOVING_INSTANCES = 3,
    MOTION_INSTANCE_STRIDE = 160,
    MOTION_VERTICES_SIZE = MOVING_TRIANGLES * 9 * sizeof(float),
    MOTION_INSTANCES_SIZE = (MOVING_INSTANCES - 1) * MOTION_INSTANCE_STRIDE +
                            sizeof(VkAccelerationStructureMotionInstanceNV),
};

/* Triangles (fixture_triangles) that go by (4, 0, 0) from time 0 to 1. Instance 0 stands still,
 * instance 1 goes by (8, 0, 0) between two matrices, instance 2 by (16, 0, 0) between two SRT
 * transforms; instance i is at y = 2 * i. Not to be moved in memory. */
struct moving_scene {
    struct fixture_build triangles, instances;
    float then[MOVING_TRIANGLES * 9]; /* the vertices at time 1 */
    VkAccelerationStructureGeometryMotionTrianglesDataNV motion;
    struct fixture_structure blas, tlas;
};

/* Nothing is built yet. */
void moving_scene_open(struct moving_scene *scene, VkBuildAccelerationStructureFlagsKHR flags);

/* By the host. */
void moving_scene_build(struct moving_scene *scene);

/* At times 0, 0.5 and 1 triangles are where they should be, and have left where they were. */
void expect_moving_blas(VkAccelerationStructureKHR blas, float way);
void expect_moving_tlas(VkAccelerationStructureKHR tlas);

#endif
