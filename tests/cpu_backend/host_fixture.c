/* SPDX-License-Identifier: Apache-2.0 */
/* Devices of backend cpu, and their structures. */
#include "tests/cpu_backend/host_fixture.h"
#include "tests/fixture/copies.h"

#include <stdlib.h>
#include <string.h>

/* ---- the device */

void fixture_use_device(struct fixture *fixture, VkDevice device, const VkuDeviceDispatchTable *vk)
{
    PFN_vkGetDeviceProcAddr proc_addr = fixture->instance_fixture.get_device_proc_addr;
    fixture->device = device;
    fixture->vk = *vk;
    fixture->trace_rays = (PFN_vkTraceRaysASSAY)proc_addr(device, "vkTraceRaysASSAY");
    fixture->get_counters = (PFN_vkGetCountersASSAY)proc_addr(device, "vkGetCountersASSAY");
    assert_non_null(fixture->trace_rays);
    assert_non_null(fixture->get_counters);
}

const char *fixture_open(struct fixture *fixture, const char *platform)
{
    static const struct instance_fixture_setup setup = {.backend = "cpu"};
    memset(fixture, 0, sizeof(*fixture));
    const char *reason = platform_open(&fixture->platform, platform);
    if (reason)
        return reason;
    instance_fixture_open(&fixture->instance_fixture, &fixture->platform, &setup);
    VkuDeviceDispatchTable vk;
    VkDevice device = instance_fixture_open_device(&fixture->instance_fixture, &vk);
    fixture_use_device(fixture, device, &vk);
    fixture->host_memory_type = instance_fixture_memory_type(&fixture->instance_fixture);
    return NULL;
}

void fixture_close(struct fixture *fixture)
{
    fixture->vk.DestroyDevice(fixture->device, NULL);
    instance_fixture_close(&fixture->instance_fixture);
}

/* ---- structures */

static struct fixture_structure create(struct fixture *fixture, VkAccelerationStructureTypeKHR type,
                                       VkDeviceSize size,
                                       const VkAccelerationStructureMotionInfoNV *motion)
{
    struct fixture_structure structure = {.size = size};
    const STRUCT(VkBufferCreateInfo, buffer, .size = size,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    structure.storage =
        buffer_create(&fixture->vk, fixture->device, fixture->host_memory_type, &buffer);
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .pNext = motion,
                 .createFlags = motion ? VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV : 0,
                 .buffer = structure.storage.handle, .size = size, .type = type);
    GET(fixture->vk.CreateAccelerationStructureKHR(fixture->device, &info, NULL,
                                                   &structure.handle));
    return structure;
}

struct fixture_structure fixture_create(struct fixture *fixture,
                                        VkAccelerationStructureTypeKHR type, VkDeviceSize size)
{
    return create(fixture, type, size, NULL);
}

struct fixture_structure fixture_create_blas(struct fixture *fixture, VkDeviceSize size)
{
    return create(fixture, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, size, NULL);
}

void fixture_destroy(struct fixture *fixture, struct fixture_structure *structure)
{
    fixture->vk.DestroyAccelerationStructureKHR(fixture->device, structure->handle, NULL);
    buffer_destroy(&fixture->vk, fixture->device, &structure->storage);
}

/* ---- builds */

static void describe(struct fixture_build *build, VkAccelerationStructureTypeKHR type,
                     VkGeometryTypeKHR geometry, uint32_t count,
                     VkBuildAccelerationStructureFlagsKHR flags)
{
    memset(build, 0, sizeof(*build));
    build->geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    build->geometry.geometryType = geometry;
    build->geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    build->range.primitiveCount = count;
    build->info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .type = type, .flags = flags,
                       .geometryCount = 1, .pGeometries = &build->geometry);
}

void fixture_triangles(struct fixture_build *build, uint32_t count,
                       VkBuildAccelerationStructureFlagsKHR flags)
{
    describe(build, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, VK_GEOMETRY_TYPE_TRIANGLES_KHR,
             count, flags);
    build->data = malloc((size_t)count * 9 * sizeof(float));
    build->geometry.geometry.triangles = MAKE(
        VkAccelerationStructureGeometryTrianglesDataKHR, .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.hostAddress = build->data, .vertexStride = 3 * sizeof(float),
        .maxVertex = count * 3 - 1, .indexType = VK_INDEX_TYPE_NONE_KHR);
    fixture_move(build, 0, 0, 0);
}

void fixture_move(struct fixture_build *build, float x, float y, float z)
{
    float *to = build->data;
    for (uint32_t i = 0; i < build->range.primitiveCount; i++) {
        const float corners[9] = {x + i, y, z, x + i, y + 1, z, x + i, y, z + 1};
        memcpy(to + 9 * (size_t)i, corners, sizeof(corners));
    }
}

void fixture_instances(struct fixture_build *build, const VkAccelerationStructureKHR *blases,
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
    build->geometry.geometry.instances =
        MAKE(VkAccelerationStructureGeometryInstancesDataKHR, .data.hostAddress = instances);
}

void fixture_free(struct fixture_build *build)
{
    free(build->data);
    free(build->scratch);
}

VkAccelerationStructureBuildSizesInfoKHR fixture_sizes(struct fixture *fixture,
                                                       const struct fixture_build *build)
{
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    fixture->vk.GetAccelerationStructureBuildSizesKHR(
        fixture->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR, &build->info,
        &build->range.primitiveCount, &sizes);
    return sizes;
}

struct fixture_structure fixture_create_for(struct fixture *fixture, struct fixture_build *build)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes = fixture_sizes(fixture, build);
    VkDeviceSize scratch = sizes.buildScratchSize > sizes.updateScratchSize
                               ? sizes.buildScratchSize
                               : sizes.updateScratchSize;
    build->scratch = malloc(scratch);
    build->info.scratchData.hostAddress = build->scratch;
    const STRUCT(VkAccelerationStructureMotionInfoNV, motion,
                 .maxInstances = build->range.primitiveCount);
    bool moves = build->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    return create(fixture, build->info.type, sizes.accelerationStructureSize,
                  moves ? &motion : NULL);
}

VkResult fixture_build(struct fixture *fixture, VkDeferredOperationKHR operation,
                       struct fixture_build *build, VkAccelerationStructureKHR dst,
                       VkAccelerationStructureKHR src)
{
    build->info.mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                           : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    build->info.dstAccelerationStructure = dst;
    build->info.srcAccelerationStructure = src;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &build->range;
    return fixture->vk.BuildAccelerationStructuresKHR(fixture->device, operation, 1, &build->info,
                                                      &ranges);
}

/* ---- copies */

VkResult fixture_copy(struct fixture *fixture, VkDeferredOperationKHR operation,
                      VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                      VkCopyAccelerationStructureModeKHR mode)
{
    const VkCopyAccelerationStructureInfoKHR info = copy_info(src, dst, mode);
    return fixture->vk.CopyAccelerationStructureKHR(fixture->device, operation, &info);
}

VkResult fixture_save(struct fixture *fixture, VkDeferredOperationKHR operation,
                      VkAccelerationStructureKHR src, void *dst)
{
    const VkCopyAccelerationStructureToMemoryInfoKHR info = serialize_info(src, (uintptr_t)dst);
    return fixture->vk.CopyAccelerationStructureToMemoryKHR(fixture->device, operation, &info);
}

VkResult fixture_load(struct fixture *fixture, VkDeferredOperationKHR operation, const void *src,
                      VkAccelerationStructureKHR dst)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info = deserialize_info((uintptr_t)src, dst);
    return fixture->vk.CopyMemoryToAccelerationStructureKHR(fixture->device, operation, &info);
}

/* The values of two structures, which are the same, 16 bytes apart; the bytes between stay. */
uint64_t fixture_property(struct fixture *fixture, VkAccelerationStructureKHR structure,
                          VkQueryType type)
{
    uint64_t values[4] = {7, 7, 7, 7};
    const VkAccelerationStructureKHR both[] = {structure, structure};
    GET(fixture->vk.WriteAccelerationStructuresPropertiesKHR(fixture->device, 2, both, type,
                                                             sizeof(values), values, 16));
    assert_int_equal(values[0], values[2]);
    assert_int_equal(values[1], 7);
    assert_int_equal(values[3], 7);
    return values[0];
}

void *fixture_serialize(struct fixture *fixture, VkAccelerationStructureKHR structure, size_t *size)
{
    *size = fixture_property(fixture, structure,
                             VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR);
    void *bytes = aligned_alloc(16, (*size + 15) / 16 * 16);
    GET(fixture_save(fixture, VK_NULL_HANDLE, structure, bytes));
    return bytes;
}

/* ---- asking */

AssayHit fixture_trace(struct fixture *fixture, VkAccelerationStructureKHR structure, float y,
                       float z)
{
    return fixture_trace_at(fixture, structure, y, z, 0);
}

AssayHit fixture_trace_at(struct fixture *fixture, VkAccelerationStructureKHR structure, float y,
                          float z, float time)
{
    const AssayRay ray = {.origin = {-1, y, z},
                          .direction = {1, 0, 0},
                          .tMax = 1e30f,
                          .cullMask = 0xff,
                          .time = time};
    AssayHit hit;
    memset(&hit, 0xff, sizeof(hit));
    const AssayTraceInfo info =
        trace_info((uint64_t)structure, ASSAY_ACCURACY_EXACT, 1, &ray, &hit);
    GET(fixture->trace_rays(fixture->device, &info));
    return hit;
}

AssayCounters fixture_counters(struct fixture *fixture)
{
    AssayCounters counters;
    fixture->get_counters(fixture->device, sizeof(counters), &counters);
    return counters;
}
