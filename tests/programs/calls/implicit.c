/* SPDX-License-Identifier: Apache-2.0 */
/* Ids without a number, whose cases are generated, and what these use. */
#include "life_arguments.h"
#include "tests/player/calls/case.h"

/* A structure that no chain of these commands may have. */
static const void *life_stray(void)
{
    static const VkFenceCreateInfo stray = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, NULL, 0};
    return &stray;
}

static uint64_t life_object_of_other_device(struct scene *scene)
{
    uint64_t found;
    scene_enter_other_device(scene);
    switch ((int)scene->life.object_type) {
    case VK_OBJECT_TYPE_MICROMAP_EXT:
        found = (uint64_t)scene_micromap_ext(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
        break;
    case VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV:
        found = (uint64_t)scene_nv_accel(scene);
        break;
    default:
        found = (uint64_t)scene_accel_for(scene, INDEXED);
        break;
    }
    scene_leave_other_device(scene);
    return found;
}

static void life_use_motion(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    life->motion = MAKE(VkAccelerationStructureMotionInfoNV, .maxInstances = 1);
    life->create.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    life->create.createFlags = VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV;
    life->create.pNext = &life->motion;
}

/* Chains two structures of one type. */
static void life_use_two_motions(struct scene *scene)
{
    static VkAccelerationStructureMotionInfoNV second;
    life_use_motion(scene);
    second = scene->life.motion;
    scene->life.motion.pNext = &second;
}

static const void *two_captures(struct scene *scene)
{
    static VkOpaqueCaptureDescriptorDataCreateInfoEXT first, second;
    second = MAKE(VkOpaqueCaptureDescriptorDataCreateInfoEXT,
                  .opaqueCaptureDescriptorData = scene->life.data);
    first = second;
    first.pNext = &second;
    return &first;
}

static void life_use_two_captures(struct scene *scene)
{
    scene->life.create_at.createFlags =
        VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT;
    scene->life.create_at.pNext = two_captures(scene);
}

static void life_use_two_nv_captures(struct scene *scene)
{
    scene->life.create_nv.pNext = two_captures(scene);
}

static void life_use_two_partition_flags(struct scene *scene)
{
    static VkPartitionedAccelerationStructureFlagsNV second;
    second = scene->life.partition_flags;
    scene->life.partition_flags.pNext = &second;
    scene->life.partition.input.pNext = &scene->life.partition_flags;
}

#include "implicit_functions.inc"

#include "implicit.inc"
