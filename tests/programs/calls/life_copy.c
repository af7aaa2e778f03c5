/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of structures and micromaps, queries of them, and builds of micromaps. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

SCENE_CREATES(create_micromap, MicromapEXT, VkMicromapEXT, VkMicromapCreateInfoEXT)

static VkMicromapEXT micromap_in(struct scene *scene, const struct device_buffer *buffer,
                                 VkDeviceSize offset, VkDeviceSize size)
{
    const STRUCT(VkMicromapCreateInfoEXT, info, .buffer = buffer->handle, .offset = offset,
                 .size = size, .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    return create_micromap(scene, &info);
}

/* A structure or micromap of the command's kind that is like src, in a buffer. */
static uint64_t object_in(struct scene *scene, struct device_buffer buffer)
{
    if (command_is_of_micromaps(scene->command))
        return (uint64_t)micromap_in(scene, &buffer, 0, PLACE_FAR);
    return (uint64_t)scene_accel_in(scene, &buffer, 0, place_size(scene, INDEXED),
                                    scene->infos[INDEXED].type);
}

static VkAccelerationStructureKHR micromap_in_memory(struct scene *scene)
{
    const struct device_buffer buffer = place_buffer_of_instances(scene, 1);
    return scene_accel_in(scene, &buffer, 0, PLACE_FAR,
                          VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
}

/* ---- builds of micromaps */

static VkDeviceSize micromap_size(const struct scene *scene)
{
    STRUCT(VkMicromapBuildSizesInfoEXT, sizes);
    scene->vk->GetMicromapBuildSizesEXT(scene->fixture->device,
                                        command_is_on_host(scene->command)
                                            ? VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
                                            : VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                        scene->life.builds, &sizes);
    return sizes.micromapSize;
}

static void *triangle_at_edge(struct scene *scene)
{
    const VkMicromapTriangleEXT triangle = {.format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    void *copy = bytes_before_unreadable_page(sizeof(triangle));
    (void)scene;
    memcpy(copy, &triangle, sizeof(triangle));
    return copy;
}

/* Queries name structures of the same kinds. */

#include "life_copy.inc"
#include "life_micromap.inc"
#include "life_query.inc"
