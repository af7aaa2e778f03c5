/* SPDX-License-Identifier: Apache-2.0 */
/* The device of backend cpu, and structures there. */
#include "tests/cpu_backend/host_fixture.h"
#include "tests/fixture/copies.h"

#include <stdlib.h>
#include <string.h>

/* ---- the device */

struct platform platform;
struct instance_fixture instance;
struct messages *const messages = &instance.messages;
VkDevice device;
VkuDeviceDispatchTable vk;
PFN_vkTraceRaysASSAY trace_rays;
static PFN_vkGetCountersASSAY get_counters;
uint32_t host_memory_type;
VkQueue queue, second_queue;
VkCommandPool command_pool;

void fixture_use_device(VkDevice other, const VkuDeviceDispatchTable *other_vk)
{
    device = other;
    vk = *other_vk;
    trace_rays = (PFN_vkTraceRaysASSAY)instance.get_device_proc_addr(device, "vkTraceRaysASSAY");
    get_counters =
        (PFN_vkGetCountersASSAY)instance.get_device_proc_addr(device, "vkGetCountersASSAY");
    assert_non_null(trace_rays);
    assert_non_null(get_counters);
}

const char *unit_test_open(const char *name)
{
    static const struct instance_fixture_setup setup = {.backend = "cpu"};
    const char *reason = platform_open(&platform, name);
    if (reason)
        return reason;
    instance_fixture_open(&instance, &platform, &setup);
    instance.queue_count = platform.is_null ? 2 : 1;
    VkuDeviceDispatchTable table;
    VkDevice opened = instance_fixture_open_device(&instance, &table);
    fixture_use_device(opened, &table);
    host_memory_type = instance_fixture_memory_type(&instance);
    vk.GetDeviceQueue(device, 0, 0, &queue);
    if (instance.queue_count > 1)
        vk.GetDeviceQueue(device, 0, 1, &second_queue);
    command_pool = command_pool_create(&vk, device);
    return NULL;
}

void unit_test_close(void)
{
    vk.DestroyCommandPool(device, command_pool, NULL);
    vk.DestroyDevice(device, NULL);
    instance_fixture_close(&instance);
}

/* ---- the end of a test */

enum { OWNED_MOST = 4096 };

static struct {
    PFN_vkVoidFunction destroy;
    uint64_t handle;
} owned[OWNED_MOST];
static size_t owned_count;

void own(PFN_vkVoidFunction destroy_command, uint64_t handle)
{
    assert_true(owned_count < OWNED_MOST);
    owned[owned_count].destroy = destroy_command;
    owned[owned_count++].handle = handle;
}

void *own_block(void *block)
{
    own(NULL, (uint64_t)(uintptr_t)block);
    return block;
}

/* Handles are pointers here, so that one type stands for all commands. */
static void destroy_at(size_t i)
{
    const PFN_vkDestroyFence command = (PFN_vkDestroyFence)owned[i].destroy;
    if (command)
        command(device, (VkFence)owned[i].handle, NULL);
    else
        free((void *)(uintptr_t)owned[i].handle);
}

void destroy(uint64_t handle)
{
    size_t i = owned_count;
    while (i > 0 && owned[i - 1].handle != handle)
        i--;
    assert_true(i > 0);
    destroy_at(i - 1);
    memmove(&owned[i - 1], &owned[i], (--owned_count - (i - 1)) * sizeof(owned[0]));
}

void destroy_all(void)
{
    while (owned_count > 0)
        destroy_at(--owned_count);
}

void close_silent_test(void)
{
    destroy_all();
    messages_expect_none(messages);
}

void close_noisy_test(void)
{
    messages_clear(messages);
    close_silent_test();
}

/* ---- structures */

static struct fixture_structure create(VkAccelerationStructureTypeKHR type, VkDeviceSize size,
                                       const VkAccelerationStructureMotionInfoNV *motion)
{
    struct fixture_structure structure = {.size = size};
    const STRUCT(VkBufferCreateInfo, buffer, .size = size,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                          VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    structure.storage = buffer_create(&vk, device, host_memory_type, &buffer);
    OWN(FreeMemory, structure.storage.memory);
    OWN(DestroyBuffer, structure.storage.handle);
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .pNext = motion,
                 .createFlags = motion ? VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV : 0,
                 .buffer = structure.storage.handle, .size = size, .type = type);
    GET(vk.CreateAccelerationStructureKHR(device, &info, NULL, &structure.handle));
    OWN(DestroyAccelerationStructureKHR, structure.handle);
    return structure;
}

struct fixture_structure fixture_create(VkAccelerationStructureTypeKHR type, VkDeviceSize size)
{
    return create(type, size, NULL);
}

struct fixture_structure fixture_create_blas(VkDeviceSize size)
{
    return create(BOTTOM, size, NULL);
}

/* ---- builds */

static void describe(struct fixture_build *build, VkGeometryTypeKHR type, uint32_t count,
                     size_t size, VkBuildAccelerationStructureFlagsKHR flags)
{
    *build = (struct fixture_build){
        .geometry = MAKE(VkAccelerationStructureGeometryKHR, .geometryType = type,
                         .flags = VK_GEOMETRY_OPAQUE_BIT_KHR),
        .info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                     .type = type == VK_GEOMETRY_TYPE_INSTANCES_KHR ? TOP : BOTTOM, .flags = flags,
                     .geometryCount = 1, .pGeometries = &build->geometry),
        .range.primitiveCount = count,
        .data = own_block(calloc(count, size)),
        .size = count * size};
}

void fixture_triangles(struct fixture_build *build, uint32_t count,
                       VkBuildAccelerationStructureFlagsKHR flags)
{
    describe(build, VK_GEOMETRY_TYPE_TRIANGLES_KHR, count, 9 * sizeof(float), flags);
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
    VkAccelerationStructureInstanceKHR *instances;
    describe(build, VK_GEOMETRY_TYPE_INSTANCES_KHR, count, sizeof(*instances), flags);
    instances = build->data;
    for (uint32_t i = 0; i < count; i++) {
        instances[i] = (VkAccelerationStructureInstanceKHR){
            .transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 2.0f * i}, {0, 0, 1, 0}},
            .instanceCustomIndex = 100 + i,
            .mask = 0xff,
            .accelerationStructureReference = (uint64_t)blases[i],
        };
    }
    build->geometry.geometry.instances =
        MAKE(VkAccelerationStructureGeometryInstancesDataKHR, .data.hostAddress = instances);
}

VkAccelerationStructureBuildSizesInfoKHR fixture_sizes(const struct fixture_build *build)
{
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    vk.GetAccelerationStructureBuildSizesKHR(device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR,
                                             &build->info, &build->range.primitiveCount, &sizes);
    return sizes;
}

VkDeviceSize fixture_scratch_size(const struct fixture_build *build)
{
    const VkAccelerationStructureBuildSizesInfoKHR sizes = fixture_sizes(build);
    return sizes.buildScratchSize > sizes.updateScratchSize ? sizes.buildScratchSize
                                                            : sizes.updateScratchSize;
}

struct fixture_structure fixture_create_for(struct fixture_build *build)
{
    build->scratch = own_block(malloc(fixture_scratch_size(build)));
    build->info.scratchData.hostAddress = build->scratch;
    const STRUCT(VkAccelerationStructureMotionInfoNV, motion,
                 .maxInstances = build->range.primitiveCount);
    bool moves = build->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    return create(build->info.type, fixture_sizes(build).accelerationStructureSize,
                  moves ? &motion : NULL);
}

VkResult fixture_build(VkDeferredOperationKHR operation, struct fixture_build *build,
                       VkAccelerationStructureKHR dst, VkAccelerationStructureKHR src)
{
    build->info.mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                           : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    build->info.dstAccelerationStructure = dst;
    build->info.srcAccelerationStructure = src;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &build->range;
    return vk.BuildAccelerationStructuresKHR(device, operation, 1, &build->info, &ranges);
}

VkResult host_build(struct fixture_build *build, VkAccelerationStructureKHR dst,
                    VkAccelerationStructureKHR src)
{
    return fixture_build(VK_NULL_HANDLE, build, dst, src);
}

/* ---- copies */

VkResult fixture_copy(VkDeferredOperationKHR operation, VkAccelerationStructureKHR src,
                      VkAccelerationStructureKHR dst, VkCopyAccelerationStructureModeKHR mode)
{
    const VkCopyAccelerationStructureInfoKHR info = copy_info(src, dst, mode);
    return vk.CopyAccelerationStructureKHR(device, operation, &info);
}

VkResult host_copy(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                   VkCopyAccelerationStructureModeKHR mode)
{
    return fixture_copy(VK_NULL_HANDLE, src, dst, mode);
}

VkResult fixture_save(VkDeferredOperationKHR operation, VkAccelerationStructureKHR src, void *dst)
{
    const VkCopyAccelerationStructureToMemoryInfoKHR info = serialize_info(src, (uintptr_t)dst);
    return vk.CopyAccelerationStructureToMemoryKHR(device, operation, &info);
}

VkResult fixture_load(VkDeferredOperationKHR operation, const void *src,
                      VkAccelerationStructureKHR dst)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info = deserialize_info((uintptr_t)src, dst);
    return vk.CopyMemoryToAccelerationStructureKHR(device, operation, &info);
}

/* The values of two structures, which are the same, 16 bytes apart; the bytes between stay. */
static uint64_t fixture_property(VkAccelerationStructureKHR structure, VkQueryType type)
{
    uint64_t values[4] = {7, 7, 7, 7};
    const VkAccelerationStructureKHR both[] = {structure, structure};
    GET(vk.WriteAccelerationStructuresPropertiesKHR(device, 2, both, type, sizeof(values), values,
                                                    16));
    assert_int_equal(values[0], values[2]);
    assert_int_equal(values[1], 7);
    assert_int_equal(values[3], 7);
    return values[0];
}

void *fixture_serialize(VkAccelerationStructureKHR structure, size_t *size)
{
    *size = fixture_property(structure, SERIALIZATION_SIZE);
    void *bytes = own_block(aligned_alloc(16, (*size + 15) / 16 * 16));
    GET(fixture_save(VK_NULL_HANDLE, structure, bytes));
    return bytes;
}

void expect_same_bytes(VkAccelerationStructureKHR a, VkAccelerationStructureKHR b)
{
    size_t size_a, size_b;
    const void *bytes_a = fixture_serialize(a, &size_a), *bytes_b = fixture_serialize(b, &size_b);
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
}

/* ---- a pair */

struct pair pair;

static void open_unbuilt_pair(uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags)
{
    fixture_triangles(&pair.triangles, triangles, flags);
    pair.blas = fixture_create_for(&pair.triangles);
    const VkAccelerationStructureKHR blases[] = {pair.blas.handle, pair.blas.handle};
    fixture_instances(&pair.instances, blases, 2, flags);
    pair.tlas = fixture_create_for(&pair.instances);
}

void open_pair(uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags)
{
    open_unbuilt_pair(triangles, flags);
    GET(host_build(&pair.triangles, pair.blas.handle, VK_NULL_HANDLE));
    GET(host_build(&pair.instances, pair.tlas.handle, VK_NULL_HANDLE));
}

void destroy_pair(void)
{
    destroy((uint64_t)pair.tlas.handle);
    destroy((uint64_t)pair.blas.handle);
}

/* ---- rays and counters */

VkResult fixture_trace_none(VkAccelerationStructureKHR structure)
{
    const AssayTraceInfo info = trace_info((uint64_t)structure, ASSAY_ACCURACY_FAST, 0, NULL, NULL);
    return trace_rays(device, &info);
}

AssayHit fixture_trace(VkAccelerationStructureKHR structure, float y, float z)
{
    const AssayRay ray = {
        .origin = {-1, y, z}, .direction = {1, 0, 0}, .tMax = 1e30f, .cullMask = 0xff};
    AssayHit hit;
    memset(&hit, 0xff, sizeof(hit));
    const AssayTraceInfo info =
        trace_info((uint64_t)structure, ASSAY_ACCURACY_EXACT, 1, &ray, &hit);
    GET(trace_rays(device, &info));
    return hit;
}

/* The ray at (y, 0.25) hits the first triangle of an instance at t. */
static void expect_hit(VkAccelerationStructureKHR structure, float y, float t, uint32_t number)
{
    AssayHit hit = fixture_trace(structure, y, 0.25f);
    assert_true(hit.isHit);
    assert_float_equal(hit.t, t, 0);
    assert_int_equal(hit.primitive, 0);
    assert_float_equal(hit.u, 0.25, 1e-6);
    assert_float_equal(hit.v, 0.25, 1e-6);
    assert_int_equal(hit.instance, number);
    assert_int_equal(hit.customIndex, 100 + number);
    assert_true(hit.isOpaque);
    assert_false(hit.isAabb);
}

void expect_pair(VkAccelerationStructureKHR tlas, float t)
{
    expect_hit(tlas, 0.25f, t, 0);
    expect_hit(tlas, 2.25f, t, 1);
    assert_false(fixture_trace(tlas, 1.5f, 0.25f).isHit);
}

AssayCounters fixture_counters(void)
{
    AssayCounters counters;
    get_counters(device, sizeof(counters), &counters);
    return counters;
}
