/* SPDX-License-Identifier: Apache-2.0 */
/* Builds the scene's acceleration structures: two BLAS at once, an update, a compaction, a TLAS. */
#include <string.h>

#include "scene.h"
#include "tests/fixture/geometry.h"

#define BUILD_INPUT                                                                                \
    (VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |                        \
     VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)
#define BUILD_STAGE VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR
#define STRUCTURE_READ VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR
#define STRUCTURE_WRITE VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR

/* ---- build calls */

VkAccelerationStructureBuildGeometryInfoKHR *
build_call_add(struct build_call *call, VkAccelerationStructureTypeKHR type,
               VkBuildAccelerationStructureFlagsKHR flags,
               const VkAccelerationStructureGeometryKHR *geometry, uint32_t primitive_count)
{
    uint32_t i = call->count++;
    call->infos[i] =
        MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .type = type, .flags = flags,
             .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR, .geometryCount = 1);
    call->geometries[i][0] = *geometry;
    call->ranges[i][0] =
        (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = primitive_count};
    return &call->infos[i];
}

VkAccelerationStructureBuildSizesInfoKHR build_call_sizes(struct gpu *gpu, struct build_call *call,
                                                          uint32_t i)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes = MAKE(VkAccelerationStructureBuildSizesInfoKHR);
    call->infos[i].pGeometries = call->geometries[i];
    gpu->calls.GetAccelerationStructureBuildSizesKHR(
        gpu->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &call->infos[i],
        &call->ranges[i][0].primitiveCount, &sizes);
    return sizes;
}

void build_call_record(struct gpu *gpu, VkCommandBuffer commands, struct build_call *call)
{
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[BUILD_CALL_MAX];
    for (uint32_t i = 0; i < call->count; ++i) {
        call->infos[i].pGeometries = call->geometries[i];
        ranges[i] = call->ranges[i];
    }
    gpu->calls.CmdBuildAccelerationStructuresKHR(commands, call->count, call->infos, ranges);
}

/* ---- descriptions */

static VkAccelerationStructureGeometryKHR scene_triangles(const struct scene *scene,
                                                          VkDeviceAddress vertices)
{
    VkAccelerationStructureGeometryKHR geometry = triangles_geometry(
        vertices, scene->vertex_count - 1, VK_INDEX_TYPE_UINT32, scene->indices.address);
    geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    return geometry;
}

static void scene_aim(VkAccelerationStructureBuildGeometryInfoKHR *info, const struct gpu *gpu,
                      const struct scene_target *target)
{
    info->dstAccelerationStructure = target->structure.handle;
    info->scratchData.deviceAddress = gpu_scratch_address(gpu, &target->scratch);
}

static const VkBuildAccelerationStructureFlagsKHR mesh_flags =
    VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
static const VkBuildAccelerationStructureFlagsKHR field_flags =
    VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;

void scene_describe_bottom(const struct scene *scene, const struct gpu *gpu,
                           struct build_call *call)
{
    *call = (struct build_call){0};
    const VkAccelerationStructureGeometryKHR triangles =
        scene_triangles(scene, scene->vertices.address);
    const VkAccelerationStructureGeometryKHR boxes =
        boxes_geometry(scene->boxes.address, sizeof(VkAabbPositionsKHR));
    scene_aim(build_call_add(call, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, mesh_flags,
                             &triangles, scene->triangle_count),
              gpu, &scene->mesh);
    scene_aim(build_call_add(call, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, field_flags,
                             &boxes, scene->box_count),
              gpu, &scene->box_field);
}

void scene_describe_update(const struct scene *scene, const struct gpu *gpu,
                           struct build_call *call)
{
    *call = (struct build_call){0};
    const VkAccelerationStructureGeometryKHR triangles =
        scene_triangles(scene, scene->vertices.address + scene->vertex_count * 3 * sizeof(float));
    VkAccelerationStructureBuildGeometryInfoKHR *info =
        build_call_add(call, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, mesh_flags,
                       &triangles, scene->triangle_count);
    scene_aim(info, gpu, &scene->twisted);
    info->mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    info->srcAccelerationStructure = scene->mesh.structure.handle;
}

void scene_describe_top(const struct scene *scene, const struct gpu *gpu, struct build_call *call)
{
    *call = (struct build_call){0};
    const VkAccelerationStructureGeometryKHR instances =
        instances_geometry(scene->instances.address, false);
    scene_aim(build_call_add(call, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                             VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR, &instances,
                             scene->instance_count),
              gpu, &scene->top);
}

/* ---- inputs */

static void scene_upload_mesh(struct scene *scene, struct gpu *gpu, const struct mesh *mesh)
{
    const VkDeviceSize set = mesh->vertex_count * 3 * sizeof(float);
    scene->vertex_count = mesh->vertex_count;
    scene->triangle_count = mesh->triangle_count;
    scene->vertices = gpu_create_buffer(gpu, "mesh vertices", GPU_PLACE_HOST, BUILD_INPUT, 2 * set);
    scene->normals = gpu_create_buffer(gpu, "mesh normals", GPU_PLACE_HOST,
                                       VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, 2 * set);
    scene->indices = gpu_create_buffer(gpu, "mesh indices", GPU_PLACE_HOST,
                                       BUILD_INPUT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                       mesh->triangle_count * 3 * sizeof(uint32_t));

    float(*positions)[3] = scene->vertices.data;
    float(*normals)[3] = scene->normals.data;
    memcpy(positions, mesh->positions, set);
    mesh_normals(mesh, positions, normals);
    memcpy(scene->indices.data, mesh->indices, scene->indices.size);
}

static void scene_twist_mesh(struct scene *scene, const struct mesh *mesh)
{
    float(*positions)[3] = (float(*)[3])scene->vertices.data + mesh->vertex_count;
    float(*normals)[3] = (float(*)[3])scene->normals.data + mesh->vertex_count;
    mesh_twist(mesh, positions);
    mesh_normals(mesh, positions, normals);
}

static void scene_upload_boxes(struct scene *scene, struct gpu *gpu)
{
    scene->box_count = LAYOUT_BOX_COUNT;
    scene->boxes = gpu_create_buffer(gpu, "boxes", GPU_PLACE_HOST,
                                     BUILD_INPUT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                     LAYOUT_BOX_COUNT * sizeof(VkAabbPositionsKHR));
    layout_boxes(scene->boxes.data);
}

static void scene_upload_instances(struct scene *scene, struct gpu *gpu)
{
    scene->instance_count = LAYOUT_INSTANCE_COUNT;
    const VkDeviceSize size = LAYOUT_INSTANCE_COUNT * sizeof(VkAccelerationStructureInstanceKHR);
    scene->instances = gpu_create_buffer(gpu, "instances", GPU_PLACE_HOST, BUILD_INPUT, size);
    layout_instances(scene->instances.data,
                     &(struct layout_references){
                         .mesh = gpu_structure_address(gpu, &scene->mesh.structure),
                         .twisted = gpu_structure_address(gpu, &scene->twisted.structure),
                         .box_field = gpu_structure_address(gpu, &scene->compacted_field),
                     });
}

/* ---- builds */

static struct scene_target scene_create_target(struct gpu *gpu, const char *name,
                                               const char *scratch_name,
                                               VkAccelerationStructureTypeKHR type,
                                               VkDeviceSize size, VkDeviceSize scratch_size)
{
    return (struct scene_target){.structure = gpu_create_structure(gpu, name, type, size),
                                 .scratch = gpu_create_scratch(gpu, scratch_name, scratch_size)};
}

static void scene_build_bottom(struct scene *scene, struct gpu *gpu, VkQueryPool compacted_size)
{
    struct build_call call;
    scene_describe_bottom(scene, gpu, &call);
    VkAccelerationStructureBuildSizesInfoKHR mesh = build_call_sizes(gpu, &call, 0);
    VkAccelerationStructureBuildSizesInfoKHR field = build_call_sizes(gpu, &call, 1);
    const VkAccelerationStructureTypeKHR type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    scene->mesh = scene_create_target(gpu, "mesh BLAS", "mesh scratch", type,
                                      mesh.accelerationStructureSize, mesh.buildScratchSize);
    scene->twisted = scene_create_target(gpu, "twisted BLAS", "twisted scratch", type,
                                         mesh.accelerationStructureSize, mesh.updateScratchSize);
    scene->box_field = scene_create_target(gpu, "box BLAS", "box scratch", type,
                                           field.accelerationStructureSize, field.buildScratchSize);

    scene_describe_bottom(scene, gpu, &call);
    VkCommandBuffer commands = gpu_begin(gpu);
    gpu->calls.CmdResetQueryPool(commands, compacted_size, 0, 1);
    build_call_record(gpu, commands, &call);
    gpu_barrier(gpu, commands, BUILD_STAGE, STRUCTURE_WRITE, BUILD_STAGE, STRUCTURE_READ);
    gpu->calls.CmdWriteAccelerationStructuresPropertiesKHR(
        commands, 1, &scene->box_field.structure.handle,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, compacted_size, 0);
    gpu_submit(gpu, commands);
}

static void scene_create_compacted(struct scene *scene, struct gpu *gpu, VkQueryPool pool)
{
    VkDeviceSize size = 0;
    TOOL_CALL(gpu->calls, GetQueryPoolResults, gpu->device, pool, 0, 1, sizeof(size), &size,
              sizeof(size), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    scene->compacted_field = gpu_create_structure(
        gpu, "compacted box BLAS", VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, size);
}

static void scene_create_top(struct scene *scene, struct gpu *gpu)
{
    struct build_call call;
    scene_describe_top(scene, gpu, &call);
    VkAccelerationStructureBuildSizesInfoKHR sizes = build_call_sizes(gpu, &call, 0);
    scene->top = scene_create_target(gpu, "TLAS", "TLAS scratch",
                                     VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                                     sizes.accelerationStructureSize, sizes.buildScratchSize);
}

/* The update, the compaction and the TLAS; the compute shader of a later submission may trace. */
static void scene_build_rest(struct scene *scene, struct gpu *gpu)
{
    struct build_call update;
    struct build_call top;
    scene_describe_update(scene, gpu, &update);
    scene_describe_top(scene, gpu, &top);

    VkCommandBuffer commands = gpu_begin(gpu);
    gpu_barrier(gpu, commands, BUILD_STAGE, STRUCTURE_WRITE, BUILD_STAGE,
                STRUCTURE_READ | STRUCTURE_WRITE);
    build_call_record(gpu, commands, &update);
    gpu->calls.CmdCopyAccelerationStructureKHR(
        commands,
        &MAKE(VkCopyAccelerationStructureInfoKHR, .src = scene->box_field.structure.handle,
              .dst = scene->compacted_field.handle,
              .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR));
    gpu_barrier(gpu, commands, BUILD_STAGE, STRUCTURE_WRITE, BUILD_STAGE, STRUCTURE_READ);
    build_call_record(gpu, commands, &top);
    gpu_barrier(gpu, commands, BUILD_STAGE, STRUCTURE_WRITE, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                STRUCTURE_READ);
    gpu_submit(gpu, commands);
}

void scene_create(struct scene *scene, struct gpu *gpu, const struct mesh *mesh)
{
    if (mesh->triangle_count > gpu->limits.maxPrimitiveCount)
        tool_fail("the mesh has %u triangles, and the device takes %llu", mesh->triangle_count,
                  (unsigned long long)gpu->limits.maxPrimitiveCount);
    *scene = (struct scene){0};
    scene_upload_mesh(scene, gpu, mesh);
    scene_upload_boxes(scene, gpu);

    VkQueryPool compacted_size;
    TOOL_CALL(gpu->calls, CreateQueryPool, gpu->device,
              &MAKE(VkQueryPoolCreateInfo,
                    .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                    .queryCount = 1),
              NULL, &compacted_size);
    scene_build_bottom(scene, gpu, compacted_size);
    scene_create_compacted(scene, gpu, compacted_size);
    gpu->calls.DestroyQueryPool(gpu->device, compacted_size, NULL);

    scene_twist_mesh(scene, mesh);
    scene_upload_instances(scene, gpu);
    scene_create_top(scene, gpu);
    scene_build_rest(scene, gpu);
}

static void scene_destroy_target(struct gpu *gpu, struct scene_target *target)
{
    gpu_destroy_structure(gpu, &target->structure);
    gpu_destroy_buffer(gpu, &target->scratch);
}

void scene_destroy(struct scene *scene, struct gpu *gpu)
{
    scene_destroy_target(gpu, &scene->top);
    gpu_destroy_structure(gpu, &scene->compacted_field);
    scene_destroy_target(gpu, &scene->box_field);
    scene_destroy_target(gpu, &scene->twisted);
    scene_destroy_target(gpu, &scene->mesh);
    gpu_destroy_buffer(gpu, &scene->instances);
    gpu_destroy_buffer(gpu, &scene->boxes);
    gpu_destroy_buffer(gpu, &scene->indices);
    gpu_destroy_buffer(gpu, &scene->normals);
    gpu_destroy_buffer(gpu, &scene->vertices);
}
