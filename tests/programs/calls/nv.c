/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing. */
#include "tests/player/calls/case.h"

static uint64_t foreign_accel(struct scene *scene)
{
    scene_enter_other_device(scene);
    const VkAccelerationStructureNV accel = scene_nv_accel(scene);
    scene_leave_other_device(scene);
    return (uint64_t)accel;
}

static VkMemoryRequirements of_object(const struct scene *scene, VkAccelerationStructureNV accel)
{
    return scene_nv_requirements(scene, accel,
                                 VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV);
}

static VkDeviceSize scratch_size(const struct scene *scene)
{
    const VkDeviceSize size =
        scene_nv_requirements(
            scene, scene->nv.dst,
            scene->nv.update ? VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV
                             : VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV)
            .size;
    return size != 0 ? size : 1;
}

enum { LIMIT = 4 };

/* A source that was created and built with these flags. */
static VkAccelerationStructureNV built_with(struct scene *scene,
                                            VkBuildAccelerationStructureFlagsNV flags)
{
    const VkBuildAccelerationStructureFlagsNV own = scene->nv.info.flags;
    scene->nv.info.flags = flags;
    scene_nv_give_large_scratch(scene);
    const VkAccelerationStructureNV source = scene_nv_accel(scene);
    scene_nv_build(scene, source);
    scene->nv.info.flags = own;
    return source;
}

#include "nv.inc"
