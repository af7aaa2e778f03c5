/* SPDX-License-Identifier: Apache-2.0 */
/* Making structures for motion. */
#include "scene_motion.h"

#define MOTION VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV

/* A moving build may take more than the same one without. */
static void give_motion_objects(struct scene *scene, uint32_t build)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[build];
    const VkBuildAccelerationStructureFlagsKHR flags = info->flags;
    info->flags |= MOTION;
    scene_give_objects(scene, build);
    info->flags = flags;
}

void scene_give_motion_dst(struct scene *scene, uint32_t build)
{
    give_motion_objects(scene, build);
    const VkAccelerationStructureMotionInfoNV motion_info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV, .maxInstances = 3};
    const VkAccelerationStructureCreateInfoKHR create_info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
        .pNext = &motion_info,
        .createFlags = VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV,
        .buffer = scene->dst_buffers[build].handle,
        .size = scene->dst_buffers[build].size,
        .type = scene->infos[build].type,
    };
    scene->infos[build].dstAccelerationStructure = scene_create_accel(scene, &create_info);
}
