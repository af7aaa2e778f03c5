/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of structures and micromaps. */
#include "case.h"
#include "placing.h"

SCENE_CREATES(create_micromap, MicromapEXT, VkMicromapEXT, VkMicromapCreateInfoEXT)

/* A structure or micromap of the command's kind that is like src, in a buffer. */
static uint64_t object_in(struct scene *scene, struct test_buffer buffer)
{
    const STRUCT(VkMicromapCreateInfoEXT, info, .buffer = buffer.handle, .size = PLACE_FAR,
                 .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    if (command_is_of_micromaps(scene->command))
        return (uint64_t)create_micromap(scene, &info);
    return (uint64_t)scene_accel_in(scene, &buffer, 0, place_size(scene, INDEXED),
                                    scene->infos[INDEXED].type);
}

static uint64_t in_no_memory(struct scene *scene)
{
    if (command_is_of_nv(scene->command))
        return (uint64_t)scene_nv_create(scene);
    return object_in(scene, scene_create_buffer(scene, PLACE_SIZE, place_usage(scene)));
}

static uint64_t in_visible_memory(struct scene *scene)
{
    if (command_is_of_nv(scene->command))
        return (uint64_t)scene_nv_accel(scene);
    return object_in(scene, place_buffer_of_instances(scene, 1));
}

static VkAccelerationStructureKHR micromap_in_memory(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer_of_instances(scene, 1);
    return scene_accel_in(scene, &buffer, 0, PLACE_FAR,
                          VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
}

static uint64_t in_device_memory(struct scene *scene)
{
    return object_in(scene, place_device_local_buffer(scene));
}

static uint64_t of_two_instances(struct scene *scene)
{
    return object_in(scene, place_buffer_of_instances(scene, 3));
}

/* Of VK_NV_ray_tracing: with a dst of its own. */
static uint64_t in_the_memory_of_dst(struct scene *scene)
{
    if (!command_is_of_nv(scene->command))
        return object_in(scene, scene->dst_buffers[INDEXED]);
    const VkAccelerationStructureNV src = scene_nv_create(scene), dst = scene_nv_create(scene);
    const VkDeviceMemory memory = scene_nv_allocate(scene, src, 0).handle;
    scene_nv_bind(scene, src, memory, 0);
    scene_nv_bind(scene, dst, memory, 0);
    scene->life.copy.dst = (VkAccelerationStructureKHR)(uint64_t)dst;
    return (uint64_t)src;
}

#include "copied.inc"
#include "copied_memory.inc"
#include "serialized.inc"

/* Queries name structures of the same kinds. */
#include "bindings.inc"
#include "lookups.inc"
#include "queried.inc"
