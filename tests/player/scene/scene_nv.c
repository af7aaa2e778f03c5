/* SPDX-License-Identifier: Apache-2.0 */
/* A build of VK_NV_ray_tracing. */
#include <string.h>

#include "tests/player/scene/scene.h"

/* ---- objects ---- */

SCENE_CREATES(create, AccelerationStructureNV, VkAccelerationStructureNV,
              VkAccelerationStructureCreateInfoNV)

VkMemoryRequirements scene_nv_requirements(const struct scene *scene,
                                           VkAccelerationStructureNV accel,
                                           VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    const STRUCT(VkAccelerationStructureMemoryRequirementsInfoNV, info, .type = type,
                 .accelerationStructure = accel);
    STRUCT(VkMemoryRequirements2, requirements);
    scene->vk->GetAccelerationStructureMemoryRequirementsNV(scene->fixture->device, &info,
                                                            &requirements);
    return requirements.memoryRequirements;
}

VkAccelerationStructureNV scene_nv_create(struct scene *scene)
{
    const STRUCT(VkAccelerationStructureCreateInfoNV, create_info, .info = scene->nv.info);
    return create(scene, &create_info);
}

struct test_memory scene_nv_allocate(struct scene *scene, VkAccelerationStructureNV accel,
                                     VkDeviceSize size)
{
    const VkMemoryRequirements requirements = scene_nv_requirements(
        scene, accel, VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV);
    return scene_allocate_of_type(scene, size != 0 ? size : requirements.size,
                                  requirements.memoryTypeBits);
}

void scene_nv_bind(struct scene *scene, VkAccelerationStructureNV accel, VkDeviceMemory memory,
                   VkDeviceSize offset)
{
    const STRUCT(VkBindAccelerationStructureMemoryInfoNV, bind_info, .accelerationStructure = accel,
                 .memory = memory, .memoryOffset = offset);
    GET(scene->vk->BindAccelerationStructureMemoryNV(scene->fixture->device, 1, &bind_info));
}

VkAccelerationStructureNV scene_nv_accel(struct scene *scene)
{
    const VkAccelerationStructureNV accel = scene_nv_create(scene);
    scene_nv_bind(scene, accel, scene_nv_allocate(scene, accel, 0).handle, 0);
    return accel;
}

static VkDeviceSize larger_scratch(const struct scene *scene, VkAccelerationStructureNV accel)
{
    const VkDeviceSize build_size =
        scene_nv_requirements(scene, accel,
                              VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV)
            .size;
    const VkDeviceSize update_size =
        scene_nv_requirements(scene, accel,
                              VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV)
            .size;
    return build_size < update_size ? update_size : build_size;
}

void scene_nv_give_objects(struct scene *scene)
{
    struct scene_nv *nv = &scene->nv;

    nv->dst = scene_nv_accel(scene);
    const VkDeviceSize size = larger_scratch(scene, nv->dst);
    nv->scratch_buffer =
        scene_buffer(scene, size != 0 ? size : 1, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    nv->scratch = nv->scratch_buffer.handle;
}

void scene_nv_give_large_scratch(struct scene *scene)
{
    scene->nv.scratch_buffer = scene_buffer(scene, 1 << 16, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    scene->nv.scratch = scene->nv.scratch_buffer.handle;
}

uint64_t scene_nv_foreign_buffer(struct scene *scene)
{
    scene_enter_other_device(scene);
    const struct device_buffer buffer =
        scene_buffer(scene, SCENE_BUFFER_SIZE, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    scene_leave_other_device(scene);
    return (uint64_t)buffer.handle;
}

/* ---- geometries ---- */

static struct device_buffer copy_of(struct scene *scene, const struct device_buffer *input)
{
    const struct device_buffer copy =
        scene_input(scene, input->size, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    memcpy(copy.bytes, input->bytes, input->size);
    return copy;
}

static VkGeometryNV empty_geometry(VkGeometryTypeKHR type)
{
    return MAKE(VkGeometryNV, .geometryType = type,
                .geometry = {.triangles = {.sType = VK_STRUCTURE_TYPE_GEOMETRY_TRIANGLES_NV},
                             .aabbs = {.sType = VK_STRUCTURE_TYPE_GEOMETRY_AABB_NV}});
}

static void set_triangles(struct scene *scene)
{
    struct scene_nv *nv = &scene->nv;

    for (uint32_t i = 0; i < 2; i++) {
        nv->geometries[i] = empty_geometry(VK_GEOMETRY_TYPE_TRIANGLES_NV);
        VkGeometryTrianglesNV *triangles = &nv->geometries[i].geometry.triangles;
        triangles->vertexData = nv->vertices.handle;
        triangles->vertexCount = 6;
        triangles->vertexStride = 12;
        triangles->vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
        triangles->indexType = VK_INDEX_TYPE_NONE_NV;
    }
    VkGeometryTrianglesNV *indexed = &nv->geometries[0].geometry.triangles;
    indexed->indexType = VK_INDEX_TYPE_UINT32;
    indexed->indexData = nv->indices.handle;
    indexed->indexCount = 6;
    indexed->transformData = nv->transforms.handle;
}

static void set_info(struct scene *scene, VkAccelerationStructureTypeNV type,
                     uint32_t geometry_count, uint32_t instance_count)
{
    scene->nv.info = MAKE(VkAccelerationStructureInfoNV, .type = type,
                          .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_NV,
                          .instanceCount = instance_count, .geometryCount = geometry_count,
                          .pGeometries = geometry_count != 0 ? scene->nv.geometries : NULL);
}

void scene_nv_open(struct scene *scene)
{
    struct scene_nv *nv = &scene->nv;

    nv->vertices = copy_of(scene, &scene->vertices);
    nv->indices = copy_of(scene, &scene->indices);
    nv->transforms = copy_of(scene, &scene->transforms);
    nv->boxes = copy_of(scene, &scene->boxes);
    nv->instances = copy_of(scene, &scene->instances);
    nv->info_argument = &nv->info;
    set_triangles(scene);
    set_info(scene, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV, 2, 0);
    scene_nv_give_objects(scene);
}

void scene_nv_use_boxes(struct scene *scene)
{
    struct scene_nv *nv = &scene->nv;

    for (uint32_t i = 0; i < 2; i++) {
        nv->geometries[i] = empty_geometry(VK_GEOMETRY_TYPE_AABBS_NV);
        nv->geometries[i].geometry.aabbs.aabbData = nv->boxes.handle;
        nv->geometries[i].geometry.aabbs.numAABBs = 3;
        nv->geometries[i].geometry.aabbs.stride = i == 0 ? 24 : 32; /* as the boxes lie */
        nv->geometries[i].geometry.aabbs.offset = i * 1024;
    }
    scene_nv_give_objects(scene);
}

void scene_nv_use_instances(struct scene *scene)
{
    set_info(scene, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV, 0, 3);
    scene->nv.instance_data = scene->nv.instances.handle;
    scene_nv_give_objects(scene);
}

/* ---- the call ---- */

void scene_nv_build(struct scene *scene, VkAccelerationStructureNV dst)
{
    const struct scene_nv *nv = &scene->nv;
    const VkCommandBuffer command_buffer = scene_begin_before(scene);
    scene->vk->CmdBuildAccelerationStructureNV(command_buffer, &nv->info, nv->instance_data, 0,
                                               VK_FALSE, dst, VK_NULL_HANDLE, nv->scratch, 0);
    scene_end_before(scene, command_buffer);
}

void scene_nv_use_update(struct scene *scene)
{
    scene->nv.src = scene_nv_accel(scene);
    scene_nv_build(scene, scene->nv.src);
    scene->nv.update = VK_TRUE;
}

void scene_nv_call(struct scene *scene)
{
    const struct scene_nv *nv = &scene->nv;

    scene_inputs_copy(scene, scene->command_buffer);
    scene->vk->CmdBuildAccelerationStructureNV(scene->command_buffer, nv->info_argument,
                                               nv->instance_data, nv->instance_offset, nv->update,
                                               nv->dst, nv->src, nv->scratch, nv->scratch_offset);
}
