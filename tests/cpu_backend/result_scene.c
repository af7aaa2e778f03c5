/* SPDX-License-Identifier: Apache-2.0 */
/* A BLAS that is asked about. */
#include "result_scene.h"

struct result_scene scene;

enum {
    TRIANGLE_SIZE = 9 * sizeof(float),
    COMPACTABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
};

void result_scene_open(VkQueryType type)
{
    fixture_triangles(&scene.host, TRIANGLES, COMPACTABLE);
    scene.blas = fixture_create_for(&scene.host);
    device_build_create(&scene.host, TRIANGLES * TRIANGLE_SIZE, &scene.build);
    scene.pool = query_pool_create(&vk, device, type, QUERIES);
    OWN(DestroyQueryPool, scene.pool);
}

void result_scene_record_build(VkCommandBuffer commands)
{
    device_upload(commands, &scene.build);
    device_build(commands, &scene.build, scene.blas.handle, VK_NULL_HANDLE);
}

void result_scene_record_queries(VkCommandBuffer commands, VkQueryType type)
{
    const VkAccelerationStructureKHR both[] = {scene.blas.handle, scene.blas.handle};
    vk.CmdResetQueryPool(commands, scene.pool, 0, QUERIES);
    vk.CmdWriteAccelerationStructuresPropertiesKHR(commands, 2, both, type, scene.pool, 0);
    device_barrier(commands);
}
