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
    scene.blas = fixture_create_for(fixture, &scene.host);
    device_build_create(&device, &scene.host, TRIANGLES * TRIANGLE_SIZE, &scene.build);
    scene.pool = query_pool_create(&fixture->vk, fixture->device, type, QUERIES);
}

void result_scene_close(void)
{
    fixture->vk.DestroyQueryPool(fixture->device, scene.pool, NULL);
    device_build_destroy(&device, &scene.build);
    fixture_destroy(fixture, &scene.blas);
    fixture_free(&scene.host);
    device_expect_silence(&device);
}

void result_scene_record_build(VkCommandBuffer commands)
{
    device_upload(&device, commands, &scene.build);
    device_build(&device, commands, &scene.build, scene.blas.handle, VK_NULL_HANDLE);
}

void result_scene_record_queries(VkCommandBuffer commands, VkQueryType type)
{
    const VkAccelerationStructureKHR both[] = {scene.blas.handle, scene.blas.handle};
    fixture->vk.CmdResetQueryPool(commands, scene.pool, 0, QUERIES);
    fixture->vk.CmdWriteAccelerationStructuresPropertiesKHR(commands, 2, both, type, scene.pool, 0);
    device_barrier(&device, commands);
}

VkDeviceSize result_scene_property(VkAccelerationStructureKHR structure, VkQueryType type)
{
    return fixture_property(fixture, structure, type);
}
