/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of structures and micromaps, queries of them, and builds of micromaps. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

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
    const struct device_buffer buffer = place_buffer_of_instances(scene, 1);
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

static void need_scratch(struct scene *scene)
{
    if (scene->fixture->instance.platform->is_cpu)
        scene_skip(scene, "backend cpu builds micromaps without scratch");
}

static VkMicromapEXT micromap_smaller_by(struct scene *scene, VkDeviceSize bytes)
{
    const struct device_buffer buffer = place_buffer(scene);
    return micromap_in(scene, &buffer, 0, micromap_size(scene) - bytes);
}

static void offer_levels(struct null_driver_config *config)
{
    config->micromap_properties.maxOpacity2StateSubdivisionLevel = 6;
    config->micromap_properties.maxOpacity4StateSubdivisionLevel = 5;
#ifdef VK_NV_displacement_micromap
    config->displacement_properties.maxDisplacementMicromapSubdivisionLevel = 4;
#endif
}

/* A displacement of the triangle in place of its opacity. */
static void build_displacement(struct scene *scene)
{
    VkMicromapBuildInfoEXT *info = &scene->life.builds[0];
    info->type = VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV;
    info->dstMicromap = scene_micromap_ext(scene, info->type);
}

static VkDeviceAddress address_with(struct scene *scene, VkBufferUsageFlags usage)
{
    return scene_buffer(scene, PLACE_FAR, usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)
        .address;
}

static void *triangle_at_edge(struct scene *scene)
{
    const VkMicromapTriangleEXT triangle = {.format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    void *copy = bytes_before_unreadable_page(sizeof(triangle));
    (void)scene;
    memcpy(copy, &triangle, sizeof(triangle));
    return copy;
}

/* A second build, of a micromap and with scratch of its own. */
static void add_build(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const struct device_buffer scratch = scene_buffer(scene, PLACE_FAR, SCRATCH_USAGE);
    life->builds[1] = life->builds[0];
    life->builds[1].dstMicromap = scene_micromap_ext(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    life->builds[1].scratchData.deviceAddress = scene_address(scene, &scratch, 0);
    life->build_count = 2;
}

#include "built_micromaps.inc"
#include "built_triangles.inc"
#include "copied.inc"
#include "copied_memory.inc"
#include "serialized.inc"

/* Queries name structures of the same kinds. */
#include "bindings.inc"
#include "lookups.inc"
#include "micromap_infos.inc"
#include "micromap_memory.inc"
#include "queried.inc"
