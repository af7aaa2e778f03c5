/* SPDX-License-Identifier: Apache-2.0 */
/* A build of VK_NV_ray_tracing. */
#include "scene.h"

static const VkGeometryNV geometry_template = {
    .sType = VK_STRUCTURE_TYPE_GEOMETRY_NV,
    .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_NV,
    .geometry = {.triangles = {.sType = VK_STRUCTURE_TYPE_GEOMETRY_TRIANGLES_NV,
                               .vertexCount = 6,
                               .vertexStride = 12,
                               .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                               .indexType = VK_INDEX_TYPE_NONE_NV},
                 .aabbs = {.sType = VK_STRUCTURE_TYPE_GEOMETRY_AABB_NV}},
};

static void destroy_accel_nv(struct scene *scene, VkDevice device, uint64_t handle)
{
    scene->vk->DestroyAccelerationStructureNV(device, (VkAccelerationStructureNV)handle, NULL);
}

static VkDeviceSize required_size(const struct scene *scene, VkAccelerationStructureNV accel,
                                  VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    const VkAccelerationStructureMemoryRequirementsInfoNV info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_INFO_NV,
        .type = type,
        .accelerationStructure = accel,
    };
    VkMemoryRequirements2 requirements = {.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    scene->vk->GetAccelerationStructureMemoryRequirementsNV(scene->world->device, &info,
                                                            &requirements);
    return requirements.memoryRequirements.size;
}

static VkAccelerationStructureNV make_accel(struct scene *scene,
                                            const VkAccelerationStructureInfoNV *info)
{
    const VkAccelerationStructureCreateInfoNV create_info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_NV, .info = *info};
    const VkDevice device = scene->world->device;
    VkAccelerationStructureNV accel;

    expect_success(scene->vk->CreateAccelerationStructureNV(device, &create_info, NULL, &accel),
                   "vkCreateAccelerationStructureNV");
    scene_defer(scene, device, (uint64_t)accel, destroy_accel_nv);
    const struct test_memory memory = scene_allocate(
        scene,
        required_size(scene, accel, VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV));
    const VkBindAccelerationStructureMemoryInfoNV bind_info = {
        .sType = VK_STRUCTURE_TYPE_BIND_ACCELERATION_STRUCTURE_MEMORY_INFO_NV,
        .accelerationStructure = accel,
        .memory = memory.handle,
    };
    expect_success(scene->vk->BindAccelerationStructureMemoryNV(device, 1, &bind_info),
                   "vkBindAccelerationStructureMemoryNV");
    return accel;
}

void scene_call_nv(struct scene *scene)
{
    VkGeometryNV geometry = geometry_template;
    const VkAccelerationStructureInfoNV info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_INFO_NV,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV,
        .geometryCount = 1,
        .pGeometries = &geometry,
    };
    geometry.geometry.triangles.vertexData =
        scene_buffer(scene, SCENE_BUFFER_SIZE, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV).handle;
    const VkAccelerationStructureNV accel = make_accel(scene, &info);
    const struct test_buffer scratch = scene_buffer(
        scene,
        required_size(scene, accel,
                      VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV),
        VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    scene->vk->CmdBuildAccelerationStructureNV(scene->command_buffer, &info, VK_NULL_HANDLE, 0,
                                               VK_FALSE, accel, VK_NULL_HANDLE, scratch.handle, 0);
}
