/* SPDX-License-Identifier: Apache-2.0 */
/* The application's use of VK_NV_ray_tracing: builds, an update, a copy, and one mistake. */
#include "application_parts.h"
#include "tests/fixture/make.h"

enum { SCRATCH = 1 << 16, OBJECT = 1 << 16, GEOMETRIES_NV = 6 };

struct nv_call {
    VkGeometryNV geometries[GEOMETRIES_NV];
    VkAccelerationStructureInfoNV info;
};

static void start_call(const struct application *app, struct nv_call *call)
{
    for (unsigned i = 0; i < GEOMETRIES_NV; i++)
        call->geometries[i] = MAKE(
            VkGeometryNV, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_NV,
            .geometry = {.triangles = MAKE(VkGeometryTrianglesNV, .vertexData = app->nv_scratch,
                                           .vertexCount = 3, .vertexStride = 12,
                                           .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                                           .indexType = VK_INDEX_TYPE_NONE_NV),
                         .aabbs = MAKE(VkGeometryAABBNV)});
    call->info =
        MAKE(VkAccelerationStructureInfoNV, .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV,
             .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_NV,
             .geometryCount = GEOMETRIES_NV, .pGeometries = call->geometries);
}

void create_nv(struct application *app)
{
    struct nv_call call;
    app->nv_memory = allocate(app, NV_STRUCTURES * OBJECT + SCRATCH, DEVICE_MEMORY);
    app->nv_scratch = create_buffer(app, SCRATCH, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV, 0);
    bind_buffer(app, app->nv_scratch, app->nv_memory, NV_STRUCTURES * OBJECT);
    start_call(app, &call);
    const STRUCT(VkAccelerationStructureCreateInfoNV, info, .info = call.info);
    for (unsigned i = 0; i < NV_STRUCTURES; i++) {
        CALL(app, CreateAccelerationStructureNV, app->device, &info, NULL, &app->nv[i]);
        CALL(app, BindAccelerationStructureMemoryNV, app->device, 1,
             &MAKE(VkBindAccelerationStructureMemoryInfoNV, .accelerationStructure = app->nv[i],
                   .memory = app->nv_memory, .memoryOffset = i * OBJECT));
        name_object(app, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV, (uint64_t)app->nv[i], "nv", i);
    }
}

void destroy_nv(struct application *app)
{
    for (unsigned i = 0; i < NV_STRUCTURES; i++)
        app->vk.DestroyAccelerationStructureNV(app->device, app->nv[i], NULL);
    app->vk.DestroyBuffer(app->device, app->nv_scratch, NULL);
    app->vk.FreeMemory(app->device, app->nv_memory, NULL);
}

static void build(const struct application *app, VkCommandBuffer command_buffer,
                  const struct nv_call *call, VkAccelerationStructureNV dst,
                  VkAccelerationStructureNV src)
{
    app->vk.CmdBuildAccelerationStructureNV(command_buffer, &call->info, VK_NULL_HANDLE, 0,
                                            src != VK_NULL_HANDLE, dst, src, app->nv_scratch, 0);
}

void record_nv(struct application *app, VkCommandBuffer command_buffer)
{
    struct nv_call call;
    start_call(app, &call);
    for (unsigned i = 0; i + 2 < NV_STRUCTURES; i++)
        build(app, command_buffer, &call, app->nv[i], VK_NULL_HANDLE);
    app->vk.CmdCopyAccelerationStructureNV(command_buffer, app->nv[NV_STRUCTURES - 2], app->nv[0],
                                           VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    build(app, command_buffer, &call, app->nv[NV_STRUCTURES - 1], app->nv[NV_STRUCTURES - 2]);
}

void mistake_nv(struct application *app, VkCommandBuffer command_buffer)
{
    struct nv_call call;
    start_call(app, &call);
    call.info.flags = 0;
    build(app, command_buffer, &call, app->nv[0], VK_NULL_HANDLE);
}
