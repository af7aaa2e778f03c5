/* SPDX-License-Identifier: Apache-2.0 */
/* Devices of backend cpu, and their structures. */
#include "host_stage.h"

#include <stdlib.h>
#include <string.h>

#define GET(call) assert_int_equal(call, VK_SUCCESS)

/* ---- the device */

static void find_host_memory(struct stage *stage)
{
    const VkMemoryPropertyFlags wanted =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkPhysicalDeviceMemoryProperties memory;
    stage->kit.vk.GetPhysicalDeviceMemoryProperties(stage->kit.physical, &memory);
    while ((memory.memoryTypes[stage->host_memory_type].propertyFlags & wanted) != wanted)
        assert_true(++stage->host_memory_type < memory.memoryTypeCount);
}

void stage_use_device(struct stage *stage, VkDevice device, const VkuDeviceDispatchTable *vk)
{
    PFN_vkGetDeviceProcAddr proc_addr = stage->kit.get_device_proc_addr;
    stage->device = device;
    stage->vk = *vk;
    stage->trace_rays = (PFN_vkTraceRaysASSAY)proc_addr(device, "vkTraceRaysASSAY");
    stage->get_counters = (PFN_vkGetCountersASSAY)proc_addr(device, "vkGetCountersASSAY");
    assert_non_null(stage->trace_rays);
    assert_non_null(stage->get_counters);
}

const char *stage_open(struct stage *stage, const char *platform)
{
    static const struct kit_setup setup = {.backend = "cpu"};
    memset(stage, 0, sizeof(*stage));
    const char *reason = platform_open(&stage->platform, platform);
    if (reason)
        return reason;
    kit_open(&stage->kit, &stage->platform, &setup);
    VkuDeviceDispatchTable vk;
    VkDevice device = kit_open_device(&stage->kit, &vk);
    stage_use_device(stage, device, &vk);
    find_host_memory(stage);
    return NULL;
}

void stage_close(struct stage *stage)
{
    stage->vk.DestroyDevice(stage->device, NULL);
    kit_close(&stage->kit);
}

/* ---- structures */

static struct stage_structure create(struct stage *stage, VkAccelerationStructureTypeKHR type,
                                     VkDeviceSize size,
                                     const VkAccelerationStructureMotionInfoNV *motion)
{
    struct stage_structure structure = {.size = size};
    const VkBufferCreateInfo buffer = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = size,
        .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    };
    GET(stage->vk.CreateBuffer(stage->device, &buffer, NULL, &structure.buffer));
    VkMemoryRequirements requirements;
    stage->vk.GetBufferMemoryRequirements(stage->device, structure.buffer, &requirements);
    const VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .pNext = &flags,
                                         .allocationSize = requirements.size,
                                         .memoryTypeIndex = stage->host_memory_type};
    GET(stage->vk.AllocateMemory(stage->device, &memory, NULL, &structure.memory));
    GET(stage->vk.BindBufferMemory(stage->device, structure.buffer, structure.memory, 0));
    const VkAccelerationStructureCreateInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
        .pNext = motion,
        .createFlags = motion ? VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV : 0,
        .buffer = structure.buffer,
        .size = size,
        .type = type,
    };
    GET(stage->vk.CreateAccelerationStructureKHR(stage->device, &info, NULL, &structure.handle));
    return structure;
}

struct stage_structure stage_create(struct stage *stage, VkAccelerationStructureTypeKHR type,
                                    VkDeviceSize size)
{
    return create(stage, type, size, NULL);
}

void stage_destroy(struct stage *stage, struct stage_structure *structure)
{
    stage->vk.DestroyAccelerationStructureKHR(stage->device, structure->handle, NULL);
    stage->vk.DestroyBuffer(stage->device, structure->buffer, NULL);
    stage->vk.FreeMemory(stage->device, structure->memory, NULL);
}

/* ---- builds */

static void describe(struct stage_build *build, VkAccelerationStructureTypeKHR type,
                     VkGeometryTypeKHR geometry, uint32_t count,
                     VkBuildAccelerationStructureFlagsKHR flags)
{
    memset(build, 0, sizeof(*build));
    build->geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    build->geometry.geometryType = geometry;
    build->geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    build->range.primitiveCount = count;
    build->info = (VkAccelerationStructureBuildGeometryInfoKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = type,
        .flags = flags,
        .geometryCount = 1,
        .pGeometries = &build->geometry,
    };
}

void stage_triangles(struct stage_build *build, uint32_t count,
                     VkBuildAccelerationStructureFlagsKHR flags)
{
    describe(build, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, VK_GEOMETRY_TYPE_TRIANGLES_KHR,
             count, flags);
    build->data = malloc((size_t)count * 9 * sizeof(float));
    build->geometry.geometry.triangles = (VkAccelerationStructureGeometryTrianglesDataKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
        .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.hostAddress = build->data,
        .vertexStride = 3 * sizeof(float),
        .maxVertex = count * 3 - 1,
        .indexType = VK_INDEX_TYPE_NONE_KHR,
    };
    stage_move(build, 0, 0, 0);
}

void stage_move(struct stage_build *build, float x, float y, float z)
{
    float *to = build->data;
    for (uint32_t i = 0; i < build->range.primitiveCount; i++) {
        const float corners[9] = {x + i, y, z, x + i, y + 1, z, x + i, y, z + 1};
        memcpy(to + 9 * (size_t)i, corners, sizeof(corners));
    }
}

void stage_instances(struct stage_build *build, const VkAccelerationStructureKHR *blases,
                     uint32_t count, VkBuildAccelerationStructureFlagsKHR flags)
{
    describe(build, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, VK_GEOMETRY_TYPE_INSTANCES_KHR,
             count, flags);
    VkAccelerationStructureInstanceKHR *instances = calloc(count, sizeof(*instances));
    for (uint32_t i = 0; i < count; i++) {
        instances[i] = (VkAccelerationStructureInstanceKHR){
            .transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 2.0f * i}, {0, 0, 1, 0}},
            .instanceCustomIndex = 100 + i,
            .mask = 0xff,
            .accelerationStructureReference = (uint64_t)blases[i],
        };
    }
    build->data = instances;
    build->geometry.geometry.instances = (VkAccelerationStructureGeometryInstancesDataKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
        .data.hostAddress = instances,
    };
}

void stage_free(struct stage_build *build)
{
    free(build->data);
    free(build->scratch);
}

VkAccelerationStructureBuildSizesInfoKHR stage_sizes(struct stage *stage,
                                                     const struct stage_build *build)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    stage->vk.GetAccelerationStructureBuildSizesKHR(
        stage->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR, &build->info,
        &build->range.primitiveCount, &sizes);
    return sizes;
}

struct stage_structure stage_create_for(struct stage *stage, struct stage_build *build)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes = stage_sizes(stage, build);
    VkDeviceSize scratch = sizes.buildScratchSize > sizes.updateScratchSize
                               ? sizes.buildScratchSize
                               : sizes.updateScratchSize;
    build->scratch = malloc(scratch);
    build->info.scratchData.hostAddress = build->scratch;
    const VkAccelerationStructureMotionInfoNV motion = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV,
        .maxInstances = build->range.primitiveCount,
    };
    bool moves = build->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    return create(stage, build->info.type, sizes.accelerationStructureSize, moves ? &motion : NULL);
}

VkResult stage_build(struct stage *stage, VkDeferredOperationKHR operation,
                     struct stage_build *build, VkAccelerationStructureKHR dst,
                     VkAccelerationStructureKHR src)
{
    build->info.mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                           : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    build->info.dstAccelerationStructure = dst;
    build->info.srcAccelerationStructure = src;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &build->range;
    return stage->vk.BuildAccelerationStructuresKHR(stage->device, operation, 1, &build->info,
                                                    &ranges);
}

/* ---- asking */

AssayHit stage_trace(struct stage *stage, VkAccelerationStructureKHR structure, float y, float z)
{
    return stage_trace_at(stage, structure, y, z, 0);
}

AssayHit stage_trace_at(struct stage *stage, VkAccelerationStructureKHR structure, float y, float z,
                        float time)
{
    const AssayRay ray = {.origin = {-1, y, z},
                          .direction = {1, 0, 0},
                          .tMax = 1e30f,
                          .cullMask = 0xff,
                          .time = time};
    AssayHit hit;
    memset(&hit, 0xff, sizeof(hit));
    const AssayTraceInfo info = {.accelerationStructure = (uint64_t)structure,
                                 .accuracy = ASSAY_ACCURACY_EXACT,
                                 .rayCount = 1,
                                 .raySize = sizeof(ray),
                                 .hitSize = sizeof(hit),
                                 .rays = &ray,
                                 .hits = &hit};
    GET(stage->trace_rays(stage->device, &info));
    return hit;
}

AssayCounters stage_counters(struct stage *stage)
{
    AssayCounters counters;
    stage->get_counters(stage->device, sizeof(counters), &counters);
    return counters;
}
