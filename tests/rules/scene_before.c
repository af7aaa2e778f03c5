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

void scene_copy(struct scene *scene, VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                VkCopyAccelerationStructureModeKHR mode)
{
    const VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = src,
        .dst = dst,
        .mode = mode,
    };
    if (scene->command == COMMAND_HOST) {
        expect_success(
            scene->vk->CopyAccelerationStructureKHR(scene->fixture->device, VK_NULL_HANDLE, &info),
            "vkCopyAccelerationStructureKHR");
        return;
    }
    const VkCommandBuffer command_buffer = scene_begin_before(scene);
    scene->vk->CmdCopyAccelerationStructureKHR(command_buffer, &info);
    scene_end_before(scene, command_buffer);
}

uint32_t scene_reserve_build(struct scene *scene, uint32_t model)
{
    const uint32_t build = scene_add_build(scene, model);
    scene->info_count--;
    return build;
}
