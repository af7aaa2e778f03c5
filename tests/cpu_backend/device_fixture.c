/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers, buffers, and builds with them. */
#include "device_fixture.h"

/* ---- buffers */

struct device_buffer device_buffer_create(VkDeviceSize size)
{
    const STRUCT(VkBufferUsageFlags2CreateInfo, usage,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                          VK_BUFFER_USAGE_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT |
                          VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT |
                          VK_BUFFER_USAGE_RAY_TRACING_BIT_NV | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                          VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT |
                          VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                          VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                          VK_BUFFER_USAGE_2_COMPRESSED_DATA_DGF1_BIT_AMDX);
    const STRUCT(VkBufferCreateInfo, info, .pNext = &usage, .size = size,
                 .usage = (VkBufferUsageFlags)usage.usage);
    const struct device_buffer buffer = buffer_create(&vk, device, host_memory_type, &info);
    OWN(FreeMemory, buffer.memory);
    OWN(DestroyBuffer, buffer.handle);
    return buffer;
}

/* ---- command buffers */

VkCommandBuffer device_begin(VkCommandBufferLevel level)
{
    return commands_begin(&vk, device, command_pool, level, 0, NULL);
}

void device_end(VkCommandBuffer commands)
{
    GET(vk.EndCommandBuffer(commands));
}

void device_run(VkCommandBuffer commands)
{
    commands_run(&vk, device, queue, commands);
}

void device_finish(VkCommandBuffer commands)
{
    device_end(commands);
    device_run(commands);
    vk.FreeCommandBuffers(device, command_pool, 1, &commands);
}

void device_barrier(VkCommandBuffer commands)
{
    commands_barrier(&vk, commands);
}

/* ---- builds */

static VkDeviceOrHostAddressConstKHR *data_of(VkAccelerationStructureGeometryKHR *geometry)
{
    switch (geometry->geometryType) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        return &geometry->geometry.triangles.vertexData;
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        return &geometry->geometry.aabbs.data;
    default:
        return &geometry->geometry.instances.data;
    }
}

/* The aligned address of new scratch for builds and updates. */
static VkDeviceAddress create_scratch(const struct fixture_build *build)
{
    enum { ALIGNMENT = 256 };
    const VkDeviceSize size = fixture_scratch_size(build) + ALIGNMENT;
    return (device_buffer_create(size).address + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

void device_build_create(struct fixture_build *host, struct device_build *build)
{
    *build = (struct device_build){.host = host,
                                   .geometry = host->geometry,
                                   .info = host->info,
                                   .staging = device_buffer_create(host->size),
                                   .data = device_buffer_create(host->size)};
    data_of(&build->geometry)->deviceAddress = build->data.address;
    build->info.pGeometries = &build->geometry;
    build->info.scratchData.deviceAddress = create_scratch(host);
}

void device_build(VkCommandBuffer commands, struct device_build *build,
                  VkAccelerationStructureKHR dst, VkAccelerationStructureKHR src)
{
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &build->host->range;
    build->info.mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                           : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    build->info.dstAccelerationStructure = dst;
    build->info.srcAccelerationStructure = src;
    vk.CmdBuildAccelerationStructuresKHR(commands, 1, &build->info, &ranges);
    device_barrier(commands);
}

/* ---- VK_NV_ray_tracing */

VkMemoryRequirements nv_requirements(VkAccelerationStructureNV handle,
                                     VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    const STRUCT(VkAccelerationStructureMemoryRequirementsInfoNV, info, .type = type,
                 .accelerationStructure = handle);
    STRUCT(VkMemoryDedicatedRequirements, dedicated, .requiresDedicatedAllocation = VK_TRUE);
    STRUCT(VkMemoryRequirements2, requirements, .pNext = &dedicated);
    vk.GetAccelerationStructureMemoryRequirementsNV(device, &info, &requirements);
    assert_false(dedicated.requiresDedicatedAllocation);
    return requirements.memoryRequirements;
}

static VkDeviceSize scratch_size(VkAccelerationStructureNV handle)
{
    static const VkAccelerationStructureMemoryRequirementsTypeNV
        of_build = VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV,
        of_update = VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV;
    const VkDeviceSize build = nv_requirements(handle, of_build).size;
    const VkDeviceSize update = nv_requirements(handle, of_update).size;
    return build > update ? build : update;
}

static void bind_memory(struct nv_structure *structure)
{
    const VkMemoryRequirements requirements = nv_requirements(
        structure->handle, VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV);
    assert_true(requirements.memoryTypeBits >> host_memory_type & 1);
    structure->memory = memory_create(&vk, device, host_memory_type, requirements.size);
    OWN(FreeMemory, structure->memory);
    const STRUCT(VkBindAccelerationStructureMemoryInfoNV, bind,
                 .accelerationStructure = structure->handle, .memory = structure->memory);
    GET(vk.BindAccelerationStructureMemoryNV(device, 1, &bind));
}

struct nv_structure nv_create(const VkAccelerationStructureInfoNV *info)
{
    struct nv_structure structure = {0};
    const STRUCT(VkAccelerationStructureCreateInfoNV, create_info, .info = *info);
    GET(vk.CreateAccelerationStructureNV(device, &create_info, NULL, &structure.handle));
    OWN(DestroyAccelerationStructureNV, structure.handle);
    bind_memory(&structure);
    structure.scratch = device_buffer_create(scratch_size(structure.handle));
    return structure;
}

VkGeometryNV nv_triangles(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize stride,
                          uint32_t triangles)
{
    return MAKE(VkGeometryNV, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_NV,
                .geometry = {.triangles = MAKE(VkGeometryTrianglesNV, .vertexData = buffer,
                                               .vertexOffset = offset, .vertexCount = 3 * triangles,
                                               .vertexStride = stride,
                                               .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                                               .indexType = VK_INDEX_TYPE_NONE_NV),
                             .aabbs = MAKE(VkGeometryAABBNV)});
}

void nv_build(VkCommandBuffer commands, const VkAccelerationStructureInfoNV *info,
              VkBuffer instances, VkDeviceSize offset, struct nv_structure *dst,
              VkAccelerationStructureNV src)
{
    vk.CmdBuildAccelerationStructureNV(commands, info, instances, offset, src != VK_NULL_HANDLE,
                                       dst->handle, src, dst->scratch.handle, 0);
    device_barrier(commands);
}
