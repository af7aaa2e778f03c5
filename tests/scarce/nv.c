/* SPDX-License-Identifier: Apache-2.0 */
/* The application's use of VK_NV_ray_tracing: builds, an update and a copy. */
#include "application_parts.h"
#include "tests/fixture/make.h"

enum { SCRATCH = 1 << 16, OBJECT = 1 << 16, GEOMETRIES_NV = 6 };

static VkBuffer scratch; /* behind the structures in one memory */

struct nv_call {
    VkGeometryNV geometries[GEOMETRIES_NV];
    VkAccelerationStructureInfoNV info;
};

static void start_call(struct nv_call *call)
{
    for (unsigned i = 0; i < GEOMETRIES_NV; i++)
        call->geometries[i] =
            MAKE(VkGeometryNV, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_NV,
                 .geometry = {.triangles = MAKE(VkGeometryTrianglesNV, .vertexData = scratch,
                                                .vertexCount = 3, .vertexStride = 12,
                                                .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                                                .indexType = VK_INDEX_TYPE_NONE_NV),
                              .aabbs = MAKE(VkGeometryAABBNV)});
    call->info =
        MAKE(VkAccelerationStructureInfoNV, .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV,
             .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_NV |
                      VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_NV,
             .geometryCount = GEOMETRIES_NV, .pGeometries = call->geometries);
}

void create_nv(void)
{
    struct nv_call call;
    const VkDeviceMemory memory = allocate(NV_STRUCTURES * OBJECT + SCRATCH, DEVICE_MEMORY);
    scratch = create_buffer(SCRATCH, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV, 0);
    bind_buffer(scratch, memory, NV_STRUCTURES * OBJECT);
    start_call(&call);
    const STRUCT(VkAccelerationStructureCreateInfoNV, info, .info = call.info);
    for (unsigned i = 0; i < NV_STRUCTURES; i++) {
        CREATE(AccelerationStructureNV, &info, &app.nv[i]);
        CALL(BindAccelerationStructureMemoryNV, device, 1,
             &MAKE(VkBindAccelerationStructureMemoryInfoNV, .accelerationStructure = app.nv[i],
                   .memory = memory, .memoryOffset = i * OBJECT));
        name_object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV, (uint64_t)app.nv[i], "nv", i);
    }
}

static void build(VkCommandBuffer command_buffer, const struct nv_call *call,
                  VkAccelerationStructureNV dst, VkAccelerationStructureNV src)
{
    vk.CmdBuildAccelerationStructureNV(command_buffer, &call->info, VK_NULL_HANDLE, 0,
                                       src != VK_NULL_HANDLE, dst, src, scratch, 0);
}

void record_nv(VkCommandBuffer command_buffer)
{
    struct nv_call call;
    start_call(&call);
    for (unsigned i = 0; i + 2 < NV_STRUCTURES; i++)
        build(command_buffer, &call, app.nv[i], VK_NULL_HANDLE);
    vk.CmdCopyAccelerationStructureNV(command_buffer, app.nv[NV_STRUCTURES - 2], app.nv[0],
                                      VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    build(command_buffer, &call, app.nv[NV_STRUCTURES - 1], app.nv[NV_STRUCTURES - 2]);
}
