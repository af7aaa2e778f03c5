/* SPDX-License-Identifier: Apache-2.0 */
/* What journals have, with setting hazards, of builds. */
#include "tests/fixture/geometry.h"
#include "tests/recording/device.h"

#include <stdio.h>

static VkAccelerationStructureBuildGeometryInfoKHR
info_of(const VkAccelerationStructureGeometryKHR *geometry)
{
    return MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                .type = geometry->geometryType == VK_GEOMETRY_TYPE_INSTANCES_KHR
                            ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                            : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                .dstAccelerationStructure = accel(1), .scratchData.deviceAddress = BUFFERS + 0x1800,
                .geometryCount = 1, .pGeometries = geometry);
}

/* A build of triangles. The call gives their number. */
static VkAccelerationStructureBuildGeometryInfoKHR plain_info(void)
{
    static VkAccelerationStructureGeometryKHR geometry;
    geometry = triangles_geometry(0, 0, VK_INDEX_TYPE_NONE_KHR, 0);
    return info_of(&geometry);
}

enum { INPUT = BUFFERS + 0x1000 };

static const VkAccelerationStructureBuildRangeInfoKHR two = {.primitiveCount = 2}, none = {0};

#define BUILD_OF "vkCmdBuildAccelerationStructuresKHR*1+0\n"
#define DST_AND_SCRATCH " B> dst accel1 0:100\n B> scratch buffer2 1800:1840\n"

/* Records the geometry, and compares the inputs. */
static void expect_inputs(const VkAccelerationStructureGeometryKHR *geometry,
                          const VkAccelerationStructureBuildRangeInfoKHR *range, const char *inputs)
{
    static char all[1024];
    bool is_top = geometry->geometryType == VK_GEOMETRY_TYPE_INSTANCES_KHR && range->primitiveCount;
    snprintf(all, sizeof(all), "vkCmdBuildAccelerationStructuresKHR*1+0%s\n%s%s", is_top ? "!" : "",
             DST_AND_SCRATCH, inputs);
    const VkAccelerationStructureBuildGeometryInfoKHR info = info_of(geometry);
    BUILD(.info = &info, .ranges = range);
    expect(all);
}

/* Bytes between elements may belong to something else, and a fourth component is not read. */
RECORDING_TEST(bytes_between_elements_are_not_read)
{
    VkAccelerationStructureGeometryKHR geometry =
        triangles_geometry(INPUT, 99, VK_INDEX_TYPE_NONE_KHR, 0);
    geometry.geometry.triangles.vertexFormat = VK_FORMAT_R16G16B16_SFLOAT;
    geometry.geometry.triangles.vertexStride = 6;
    expect_inputs(&geometry, &two, " B<shader vertices buffer2 1000:1024\n");
    geometry.geometry.triangles.vertexStride = 8;
    expect_inputs(&geometry, &two,
                  " B<shader vertices buffer2 1000:1006\n B<shader vertices buffer2 1028:102e\n");
    geometry.geometry.triangles.vertexFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
    expect_inputs(&geometry, &two,
                  " B<shader vertices buffer2 1000:1006\n B<shader vertices buffer2 1028:102e\n");
    geometry.geometry.triangles.vertexFormat = VK_FORMAT_A2B10G10R10_SNORM_PACK32;
    geometry.geometry.triangles.vertexStride = 4;
    expect_inputs(&geometry, &two, " B<shader vertices buffer2 1000:1018\n");
    geometry.geometry.triangles.vertexFormat = VK_FORMAT_R32G32_SFLOAT;
    geometry.geometry.triangles.vertexStride = 8;
    expect_inputs(&geometry, &two, " B<shader vertices buffer2 1000:1030\n");
}

RECORDING_TEST(instances)
{
    VkAccelerationStructureGeometryKHR geometry = instances_geometry(INPUT, false);
    expect_inputs(&geometry, &two, " B<shader instances buffer2 1000:1080\n");
    expect_inputs(&geometry, &none, "");
    geometry.geometry.instances.arrayOfPointers = VK_TRUE;
    expect_inputs(&geometry, &two, " B<shader pointers buffer2 1000:1010\n");
    geometry.geometry.instances.arrayOfPointers = VK_FALSE;
    VkAccelerationStructureBuildGeometryInfoKHR info = info_of(&geometry);
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    BUILD(.info = &info, .ranges = &two);
    expect("vkCmdBuildAccelerationStructuresKHR*1+0!\n" DST_AND_SCRATCH
           " B<shader instances buffer2 1000:1048\n B<shader instances buffer2 10a0:10e8\n");
}

RECORDING_TEST(a_skipped_call_leaves_nothing)
{
    VkAccelerationStructureBuildGeometryInfoKHR info = plain_info();
    BUILD(.info = &info, .ranges = &none);
    BUILD(.info = &info, .ranges = &none, .skip = true);
    expect(BUILD_OF DST_AND_SCRATCH);
}

/* The first byte of a structure is written in any case. */
RECORDING_TEST(unknown_sizes)
{
    const VkAccelerationStructureBuildGeometryInfoKHR info = plain_info();
    device.facts.limits.maxGeometryCount = 0;
    BUILD(.info = &info, .ranges = &none);
    expect(BUILD_OF " B> dst accel1 0:1\n");
}

/* A handle that is used again has another id. */
RECORDING_TEST(ids_of_memory_are_never_reused)
{
    struct journal *journal = journal_create(VK_NULL_HANDLE);
    uint64_t first = hazard_memory_id(journal, device.resources, memory(1));
    assert_int_equal(hazard_memory_id(journal, device.resources, memory(1)), first);
    assert_int_equal(hazard_memory_id(journal, device.resources, VK_NULL_HANDLE), 0);
    resources_remove_memory(device.resources, memory(1));
    assert_int_equal(hazard_memory_id(journal, device.resources, memory(1)), 0);
    have_memory(device.resources, 1);
    assert_int_not_equal(hazard_memory_id(journal, device.resources, memory(1)), first);
    journal_release(journal);
}

/* ---- VK_NV_ray_tracing */

static VkAccelerationStructureNV nv(unsigned n)
{
    return (VkAccelerationStructureNV)(uintptr_t)(0x400 + n);
}

/* Structures 1 and 2, of 0x100 bytes each, in memory 1 from 0x8000 on. */
static void have_nv(unsigned n)
{
    const struct nv_size_facts sizes = {true, 0x100, 0x40, 0x20};
    resources_add_nv_accel(device.resources, nv(n), NULL, &sizes);
    resources_bind_nv_accel(device.resources, nv(n), memory(1), 0x8000 + n * 0x100, false);
}

static bool never(void *user, enum resource_kind kind, uint64_t object)
{
    return false;
}

static void build_nv(const VkAccelerationStructureInfoNV *info, bool update, unsigned src)
{
    static const bool active[RULE_COUNT];
    struct readable_cache readable = {0};
    struct build_call call;
    struct nv_call_view view = {.call = &call.view,
                                .info_argument = info,
                                .instance_data = buffer(1),
                                .instance_offset = 64,
                                .update = update,
                                .dst = nv(1),
                                .src = src ? nv(src) : VK_NULL_HANDLE,
                                .scratch = buffer(2),
                                .scratch_offset = 0x800};
    struct check_context context = {.hooks = &(struct check_hooks){.of_another_device = never},
                                    .recorder = hazards_build_recorder(),
                                    .user = &call,
                                    .level = LEVEL_EXECUTION,
                                    .active = active,
                                    .readable = &readable,
                                    .resources = device.resources};
    build_call_start_recorded(&call, &device, COMMAND_NV, handle(1));
    call.view.info_count = 0;
    check_nv_build(&context, &view);
}

#define NV_BUILD "vkCmdBuildAccelerationStructureNV"

RECORDING_TEST(nv_builds)
{
    const VkGeometryNV geometries[] = {
        MAKE(VkGeometryNV, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_NV,
             .geometry.triangles =
                 MAKE(VkGeometryTrianglesNV, .vertexData = buffer(1), .vertexCount = 3,
                      .vertexStride = 12, .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                      .indexData = buffer(2), .indexCount = 3, .indexType = VK_INDEX_TYPE_UINT32,
                      .transformData = buffer(2), .transformOffset = 0x100)),
        MAKE(VkGeometryNV, .geometryType = VK_GEOMETRY_TYPE_AABBS_NV,
             .geometry.aabbs = MAKE(VkGeometryAABBNV, .aabbData = buffer(1), .numAABBs = 2,
                                    .stride = 32, .offset = 0x40))};
    STRUCT(VkAccelerationStructureInfoNV, info,
           .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV, .geometryCount = 2,
           .pGeometries = geometries);
    have_nv(1);
    have_nv(2);
    build_nv(&info, true, 2);
    expect(NV_BUILD
           "\n B> dst nv1 8100:8200\n B< src nv2 8200:8300\n"
           " B> scratch buffer2 1800:1820\n"
           " B<shader vertices buffer1 0:1000 of indices*12+12\n"
           " B<shader indices buffer2 1000:100c\n"
           " B<shader transform buffer2 1100:1130\n"
           " B<shader boxes buffer1 40:58 0.1\n B<shader boxes buffer1 60:78 0.1\n");
    info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV;
    info.geometryCount = 0;
    info.instanceCount = 2;
    build_nv(&info, false, 0);
    expect(NV_BUILD
           "!\n B> dst nv1 8100:8200\n B> scratch buffer2 1800:1840\n"
           " B<shader instances buffer1 40:c0\n");
}

/* ---- extensions */

static void enable_extensions(void)
{
    device_open();
    device.facts.dense_geometry_format = true;
    device.facts.extension.adds_to_inputs = true;
    device.facts.extension.dense_geometry_format_amdx = true;
    device.facts.extension.motion_blur_nv = true;
    device.facts.extension.linear_swept_spheres_nv = true;
    device.facts.spheres = device.facts.linear_swept_spheres = true;
    device.facts.extension.opacity_micromap_ext = device.facts.micromap.any = true;
    device.facts.extension.displacement_micromap_nv = true;
}

static void build_bottom(const VkAccelerationStructureGeometryKHR *geometry,
                         const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    const VkAccelerationStructureBuildGeometryInfoKHR info = info_of(geometry);
    BUILD(.info = &info, .ranges = range);
}

TEST_BETWEEN(motion, enable_extensions, device_close)
{
    const STRUCT(VkAccelerationStructureGeometryMotionTrianglesDataNV, data,
                 .vertexData.deviceAddress = BUFFERS + 0x800);
    VkAccelerationStructureGeometryKHR geometry =
        triangles_geometry(INPUT, 99, VK_INDEX_TYPE_NONE_KHR, 0);
    geometry.geometry.triangles.pNext = &data;
    build_bottom(&geometry, &two);
    expect(
        BUILD_OF
        " B<shader vertices buffer2 1000:1048\n B<shader other buffer1 800:848\n" DST_AND_SCRATCH);
}

/* If a geometry has indices, only the indices are certain. */
TEST_BETWEEN(spheres, enable_extensions, device_close)
{
    STRUCT(VkAccelerationStructureGeometrySpheresDataNV, data,
           .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexData.deviceAddress = INPUT,
           .vertexStride = 12, .radiusFormat = VK_FORMAT_R32_SFLOAT,
           .radiusData.deviceAddress = BUFFERS + 0x800, .radiusStride = 4,
           .indexType = VK_INDEX_TYPE_NONE_KHR, .indexData.deviceAddress = BUFFERS,
           .indexStride = 2);
    const STRUCT(VkAccelerationStructureGeometryKHR, geometry, .pNext = &data,
                 .geometryType = (VkGeometryTypeKHR)VK_GEOMETRY_TYPE_SPHERES_NV);
    build_bottom(&geometry, &two);
    expect(BUILD_OF
           " B<shader other buffer2 1000:1018\n B<shader other buffer1 800:808\n" DST_AND_SCRATCH);
    data.indexType = VK_INDEX_TYPE_UINT16;
    build_bottom(&geometry, &two);
    expect(BUILD_OF " B<shader other buffer1 0:4\n" DST_AND_SCRATCH);
}

TEST_BETWEEN(linear_swept_spheres, enable_extensions, device_close)
{
    STRUCT(VkAccelerationStructureGeometryLinearSweptSpheresDataNV, data,
           .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexData.deviceAddress = INPUT,
           .vertexStride = 12, .radiusFormat = VK_FORMAT_R16_SFLOAT,
           .radiusData.deviceAddress = BUFFERS + 0x800, .radiusStride = 2,
           .indexType = VK_INDEX_TYPE_NONE_KHR, .indexData.deviceAddress = BUFFERS,
           .indexStride = 4, .indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV);
    const STRUCT(VkAccelerationStructureGeometryKHR, geometry, .pNext = &data,
                 .geometryType = (VkGeometryTypeKHR)VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV);
    build_bottom(&geometry, &two);
    expect(BUILD_OF
           " B<shader other buffer2 1000:1030\n B<shader other buffer1 800:808\n" DST_AND_SCRATCH);
    data.indexType = VK_INDEX_TYPE_UINT32;
    data.indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
    build_bottom(&geometry, &two);
    expect(BUILD_OF " B<shader other buffer1 0:8\n" DST_AND_SCRATCH);
}

TEST_BETWEEN(indices_of_micromaps, enable_extensions, device_close)
{
    const VkMicromapEXT micromap = (VkMicromapEXT)(uintptr_t)0x701;
    STRUCT(VkAccelerationStructureTrianglesDisplacementMicromapNV, displacement,
           .micromap = micromap, .indexType = VK_INDEX_TYPE_UINT32, .indexStride = 4,
           .indexBuffer.deviceAddress = BUFFERS,
           .displacedMicromapPrimitiveFlags.deviceAddress = BUFFERS + 0x100,
           .displacedMicromapPrimitiveFlagsStride = 1);
    STRUCT(VkAccelerationStructureTrianglesOpacityMicromapEXT, opacity, .pNext = &displacement,
           .micromap = micromap, .indexType = VK_INDEX_TYPE_UINT16, .indexStride = 2,
           .indexBuffer.deviceAddress = BUFFERS + 0x800);
    VkAccelerationStructureGeometryKHR geometry =
        triangles_geometry(INPUT, 99, VK_INDEX_TYPE_NONE_KHR, 0);
    geometry.geometry.triangles.pNext = &opacity;
    build_bottom(&geometry, &two);
    expect(BUILD_OF
           " B<shader vertices buffer2 1000:1048\n B<shader other buffer1 800:804\n"
           " B<shader other buffer1 0:8\n B<shader other buffer1 100:102\n" DST_AND_SCRATCH);
    opacity.micromap = displacement.micromap = VK_NULL_HANDLE;
    build_bottom(&geometry, &two);
    expect(BUILD_OF " B<shader vertices buffer2 1000:1048\n" DST_AND_SCRATCH);
}

/* A chain that cannot be read is not followed. */
TEST_BETWEEN(dense_geometries, enable_extensions, device_close)
{
    const STRUCT(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX, data,
                 .compressedData.deviceAddress = INPUT, .dataSize = 0x40, .numTriangles = 1,
                 .numVertices = 3, .format = VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_AMDX);
    STRUCT(VkAccelerationStructureGeometryKHR, geometry, .pNext = &data,
           .geometryType =
               (VkGeometryTypeKHR)VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX);
    build_bottom(&geometry, &none);
    expect(BUILD_OF " B<shader other buffer2 1000:1040\n" DST_AND_SCRATCH);
    geometry.pNext = (const void *)(uintptr_t)16;
    build_bottom(&geometry, &none);
    expect(BUILD_OF " B> dst accel1 0:1\n");
}

/* The first byte, of structures that are micromaps, too; once for consecutive geometries. */
RECORDING_TEST(attached_micromaps)
{
    struct micromap_use items[] = {{.handle = 0x301, .accel = accel_facts(device.resources, 1)},
                                   {.handle = 0x301, .accel = accel_facts(device.resources, 1)},
                                   {.handle = 0x701, .is_ext = true, .geometry = 1},
                                   {.handle = 0}};
    struct micromap_uses uses = {.items = items, .count = 4};
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info, .geometryCount = 0);
    struct build_call call;
    const struct build_view view = {.call = &call.view, .info = &info, .micromaps = &uses};
    resources_add_micromap(
        device.resources, (VkMicromapEXT)(uintptr_t)0x701,
        &MAKE(VkMicromapCreateInfoEXT, .buffer = buffer(2), .offset = 0x100, .size = 0x80));
    build_call_start_recorded(&call, &device, COMMAND_DEVICE, handle(1));
    call.view.info_count = 1;
    hazards_build_recorder()->record_build(&call, &view, NULL);
    expect(BUILD_OF
           " anywhere\n B< micromap accel1 0:1\n B<micromap micromap micromap1 1100:1101 0.1\n");
}
