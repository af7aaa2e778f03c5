/* SPDX-License-Identifier: Apache-2.0 */
/* Builds that come before the call of a scene. */
#include "scene.h"

void scene_build_before(struct scene *scene, uint32_t first, uint32_t count)
{
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
        .dstAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                         VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
    };
    if (scene->command == COMMAND_HOST) {
        expect_success(scene->vk->BuildAccelerationStructuresKHR(
                           scene->fixture->device, VK_NULL_HANDLE, count, &scene->infos[first],
                           &scene->range_pointers[first]),
                       "vkBuildAccelerationStructuresKHR");
        return;
    }
    const VkCommandBuffer command_buffer = scene_begin_before(scene);
    scene->vk->CmdBuildAccelerationStructuresKHR(command_buffer, count, &scene->infos[first],
                                                 &scene->range_pointers[first]);
    scene->vk->CmdPipelineBarrier(
        command_buffer, VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
        VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, 0, 1, &barrier, 0, NULL, 0, NULL);
    scene_end_before(scene, command_buffer);
}

void scene_become_known(struct scene *scene)
{
    enum { TIMES = 2 }; /* once is what many structures are built */
    const uint32_t family = fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0);
    for (int i = 0; i < TIMES; i++) {
        const VkCommandBuffer command_buffer = scene_command_buffer(scene, family);
        scene_begin(scene, command_buffer, 0);
        scene->vk->CmdBuildAccelerationStructuresKHR(command_buffer, scene->info_count,
                                                     scene->infos_argument, scene->ranges_argument);
        scene_end(scene, command_buffer);
    }
}

void scene_build_source(struct scene *scene, uint32_t update)
{
    const VkAccelerationStructureBuildGeometryInfoKHR info = scene->infos[update];
    if (scene->command != COMMAND_HOST)
        return;
    scene->infos[update].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    scene->infos[update].dstAccelerationStructure = info.srcAccelerationStructure;
    scene_build_before(scene, update, 1);
    scene->infos[update] = info;
}
