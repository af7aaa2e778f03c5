/* SPDX-License-Identifier: Apache-2.0 */
/* Which memory the input of a build is looked up in: from each address, as many bytes as the build
 * may read. The layer copies no more of a device's memory than that. */
#include "src/model/build_parameters.h"
#include "src/model/input_names.h"
#include "src/snapshots/build_input.h"
#include "tests/fixture/geometry.h"
#include "tests/unit/unit_test.h"

enum {
    VERTICES = 0x1000,
    INDICES = 0x2000,
    TRANSFORMS = 0x3000,
    MOTION = 0x4000,
    RADII = 0x5000,
    OPACITIES = 0x6000,
    VECTORS = 0x7000,
    BIASES = 0x8000,
    FLAGS = 0x9000,
    MICROMAPS = 0xa000,
    MOST = 8,
};

struct lookup {
    uint64_t address, size;
};

static struct lookup found[MOST];
static uint32_t found_count;

/* Indices are zeros. */
static uint64_t find(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    static const uint8_t zeros[0x1000];
    (void)context;
    assert_true(found_count < MOST);
    found[found_count++] = (struct lookup){address, size};
    *bytes = zeros;
    return size < sizeof(zeros) ? size : sizeof(zeros);
}

/* Opens and closes the input of a build, and notes what is looked up. */
static struct build_input look_up(const struct build_parameters *build, bool is_later)
{
    const struct input_memory memory = {.find = find, .is_later = is_later};
    struct build_input input;
    found_count = 0;
    assert_int_equal(build_input_open(build, &memory, &input), VK_SUCCESS);
    const struct build_input opened = input;
    build_input_close(&input);
    return opened;
}

static void expect(const VkAccelerationStructureGeometryKHR *geometry,
                   struct chained_input *chained, VkBuildAccelerationStructureFlagsKHR flags,
                   VkAccelerationStructureBuildRangeInfoKHR range, const struct lookup *expected)
{
    VkAccelerationStructureGeometryKHR copy = *geometry;
    struct build_parameters build = {
        .info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .flags = flags,
                     .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, .geometryCount = 1),
        .geometries = &copy,
        .ranges = &range,
        .chained = chained,
    };
    uint32_t i = 0;
    look_up(&build, false);
    for (; expected[i].address; i++) {
        assert_true(i < found_count);
        assert_int_equal(found[i].address, expected[i].address);
        assert_int_equal(found[i].size, expected[i].size);
    }
    assert_int_equal(found_count, i);
    range.primitiveCount = 0;
    look_up(&build, false);
    assert_int_equal(found_count, 0);
}

#define EXPECT(geometry, chained, flags, range, ...)                                               \
    expect(geometry, chained, flags, (VkAccelerationStructureBuildRangeInfoKHR)range,              \
           (const struct lookup[MOST]){__VA_ARGS__})
#define RANGE(...)                                                                                 \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    } /* count, offset, first vertex, offset of the transform */

static VkAccelerationStructureGeometryKHR triangles(VkIndexType type, uint32_t max_vertex)
{
    return triangles_geometry(VERTICES, max_vertex, type, INDICES);
}

TEST(triangles_are_looked_up)
{
    VkAccelerationStructureGeometryKHR list = triangles(VK_INDEX_TYPE_NONE_KHR, 100);
    EXPECT(&list, NULL, 0, RANGE(3, 24, 1, 0), {VERTICES, 24 + 9 * 12 + 12});
    list = triangles(VK_INDEX_TYPE_NONE_KHR, 7);
    EXPECT(&list, NULL, 0, RANGE(3, 24, 1, 0), {VERTICES, 24 + 7 * 12 + 12});
    list = triangles(VK_INDEX_TYPE_UINT8_KHR, 9);
    EXPECT(&list, NULL, 0, RANGE(3, 8, 2, 0), {VERTICES, 9 * 12 + 12}, {INDICES, 8 + 9});
    list = triangles(VK_INDEX_TYPE_UINT16, 9);
    EXPECT(&list, NULL, 0, RANGE(3, 8, 2, 0), {VERTICES, 9 * 12 + 12}, {INDICES, 8 + 18});
    list = triangles(VK_INDEX_TYPE_UINT32, 9);
    list.geometry.triangles.transformData.deviceAddress = TRANSFORMS;
    struct chained_input chained = {.motion_vertices.deviceAddress = MOTION};
    EXPECT(&list, &chained, VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV, RANGE(3, 8, 2, 96),
           {VERTICES, 9 * 12 + 12}, {MOTION, 9 * 12 + 12}, {INDICES, 8 + 36},
           {TRANSFORMS, 96 + sizeof(VkTransformMatrixKHR)});
}

TEST(micromaps_of_triangles_are_looked_up)
{
    const VkAccelerationStructureGeometryKHR list = triangles(VK_INDEX_TYPE_UINT32, 9);
    struct chained_input chained = {
        .has_opacity = true,
        .opacity = MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT,
                        .indexType = VK_INDEX_TYPE_UINT16, .indexStride = 6,
                        .indexBuffer.deviceAddress = OPACITIES),
    };
    EXPECT(&list, &chained, 0, RANGE(5, 0, 0, 0), {VERTICES, 9 * 12 + 12}, {INDICES, 60},
           {OPACITIES, 4 * 6 + 2});
    chained.has_opacity = false;
    chained.has_displacement = true;
    chained.displacement =
        MAKE(VkAccelerationStructureTrianglesDisplacementMicromapNV,
             .displacementVectorFormat = VK_FORMAT_R16G16B16_SFLOAT,
             .displacementVectorBuffer.deviceAddress = VECTORS, .displacementVectorStride = 8,
             .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
             .displacementBiasAndScaleBuffer.deviceAddress = BIASES,
             .displacementBiasAndScaleStride = 16,
             .displacedMicromapPrimitiveFlags.deviceAddress = FLAGS,
             .displacedMicromapPrimitiveFlagsStride = 3, .indexType = VK_INDEX_TYPE_UINT32,
             .indexBuffer.deviceAddress = MICROMAPS, .indexStride = 4,
             .micromap = (VkMicromapEXT)(uintptr_t)1);
    EXPECT(&list, &chained, 0, RANGE(5, 0, 2, 0), {VERTICES, 9 * 12 + 12}, {INDICES, 60},
           {VECTORS, 9 * 8 + 6}, {BIASES, 9 * 16 + 8}, {FLAGS, 4 * 3 + 1}, {MICROMAPS, 4 * 4 + 4});
    chained.displacement.indexType = VK_INDEX_TYPE_NONE_KHR;
    chained.displacement.displacementBiasAndScaleBuffer.deviceAddress = 0;
    chained.displacement.displacedMicromapPrimitiveFlags.deviceAddress = 0;
    EXPECT(&list, &chained, 0, RANGE(5, 0, 2, 0), {VERTICES, 9 * 12 + 12}, {INDICES, 60},
           {VECTORS, 9 * 8 + 6});
}

TEST(boxes_and_instances_are_looked_up)
{
    const VkAccelerationStructureGeometryKHR boxes = boxes_geometry(VERTICES, 32);
    EXPECT(&boxes, NULL, 0, RANGE(4, 16, 0, 0), {VERTICES, 16 + 3 * 32 + 24});
    VkAccelerationStructureGeometryKHR instances = instances_geometry(VERTICES, false);
    EXPECT(&instances, NULL, 0, RANGE(3, 64, 0, 0), {VERTICES, 64 + 3 * 64});
    EXPECT(&instances, NULL, VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV, RANGE(3, 64, 0, 0),
           {VERTICES, 64 + 2 * 160 + sizeof(VkAccelerationStructureMotionInstanceNV)});
    instances.geometry.instances.arrayOfPointers = VK_TRUE;
    EXPECT(&instances, NULL, 0, RANGE(3, 64, 0, 0), {VERTICES, 64 + 3 * 8});
}

static struct chained_input spheres(VkIndexType type, VkFormat radius_format)
{
    return (struct chained_input){
        .spheres =
            MAKE(VkAccelerationStructureGeometryLinearSweptSpheresDataNV,
                 .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexData.deviceAddress = VERTICES,
                 .vertexStride = 12, .radiusFormat = radius_format,
                 .radiusData.deviceAddress = RADII, .radiusStride = 6, .indexType = type,
                 .indexData.deviceAddress = INDICES, .indexStride = 8)};
}

/* Indices are zeros: one vertex follows the first one. */
TEST(spheres_are_looked_up)
{
    STRUCT(VkAccelerationStructureGeometryKHR, geometry,
           .geometryType = VK_GEOMETRY_TYPE_SPHERES_NV);
    struct chained_input chained = spheres(VK_INDEX_TYPE_NONE_KHR, VK_FORMAT_R32_SFLOAT);
    EXPECT(&geometry, &chained, 0, RANGE(3, 4, 1, 0), {VERTICES, 4 + 3 * 12 + 12},
           {RADII, 4 + 3 * 6 + 4});
    chained = spheres(VK_INDEX_TYPE_UINT16, VK_FORMAT_R16_SFLOAT);
    EXPECT(&geometry, &chained, 0, RANGE(3, 4, 1, 0), {INDICES, 4 + 2 * 8 + 2}, {VERTICES, 12 + 12},
           {RADII, 6 + 2});
    geometry.geometryType = VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV;
    EXPECT(&geometry, &chained, 0, RANGE(3, 4, 1, 0), {INDICES, 4 + 5 * 8 + 2}, {VERTICES, 12 + 12},
           {RADII, 6 + 2});
    chained.spheres.indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
    EXPECT(&geometry, &chained, 0, RANGE(3, 4, 1, 0), {INDICES, 4 + 2 * 8 + 2},
           {VERTICES, 2 * 12 + 12}, {RADII, 2 * 6 + 2});
    chained.spheres.radiusFormat = VK_FORMAT_R8_UNORM; /* unknown */
    EXPECT(&geometry, &chained, 0, RANGE(3, 4, 1, 0), {0, 0});
}

TEST(dense_blocks_are_looked_up)
{
    const STRUCT(VkAccelerationStructureGeometryKHR, geometry,
                 .geometryType =
                     (VkGeometryTypeKHR)VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX);
    struct chained_input chained = {
        .dense = MAKE(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX,
                      .compressedData.deviceAddress = VERTICES, .dataSize = 384, .numTriangles = 2,
                      .maxPrimitiveIndex = 6),
        .has_opacity = true,
        .opacity = MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT,
                        .indexType = VK_INDEX_TYPE_UINT32, .indexStride = 4,
                        .indexBuffer.deviceAddress = OPACITIES),
    };
    EXPECT(&geometry, &chained, 0, RANGE(2, 0, 0, 0), {VERTICES, 384}, {OPACITIES, 7 * 4});
}

/* How much data a micromap has is known when its triangles can be read. */
TEST(micromaps_are_looked_up)
{
    static VkMicromapUsageEXT usages[2] = {{3, 1, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
                                           {4, 2, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT}};
    VkAccelerationStructureGeometryKHR geometry = {.geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR};
    VkAccelerationStructureBuildRangeInfoKHR range = {0};
    struct chained_input chained = {.micromap = {.type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
                                                 .usage_count = 2,
                                                 .usages = usages,
                                                 .data.deviceAddress = VERTICES,
                                                 .triangles.deviceAddress = INDICES,
                                                 .stride = 12}};
    const struct build_parameters build = {
        .info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .geometryCount = 1,
                     .type = (VkAccelerationStructureTypeKHR)
                         VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR),
        .geometries = &geometry,
        .ranges = &range,
        .chained = &chained,
    };
    const struct build_input input = look_up(&build, true);
    assert_true(input.is_micromap && input.micromap.stride == 12);
    assert_int_equal(found_count, 2);
    assert_true(found[0].address == INDICES && found[0].size == 6 * 12 + 8);
    assert_true(found[1].address == VERTICES && found[1].size == UINT64_MAX);
    chained.micromap.usage_count = 0;
    look_up(&build, true);
    assert_int_equal(found_count, 0);
}

TEST(the_copy_of_pointers_is_an_array)
{
    const STRUCT(VkAccelerationStructureGeometryKHR, geometry,
                 .geometryType = VK_GEOMETRY_TYPE_AABBS_KHR);
    const VkAccelerationStructureGeometryKHR *pointer = &geometry;
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info, .geometryCount = 1,
                 .ppGeometries = &pointer);
    struct readable_cache cache = {0};
    struct build_parameters copy;
    assert_int_equal(build_parameters_copy(&cache, &info, NULL, &copy), VK_SUCCESS);
    assert_null(copy.info.ppGeometries);
    assert_ptr_equal(copy.info.pGeometries, copy.geometries);
    assert_int_equal(copy.geometries[0].geometryType, VK_GEOMETRY_TYPE_AABBS_KHR);
    build_parameters_release(&copy);
}

/* Geometry of another kind is nothing that a build of VK_NV_ray_tracing takes. */
TEST(other_geometry_of_nv_has_no_primitives)
{
    static const VkGeometryTypeKHR types[] = {VK_GEOMETRY_TYPE_TRIANGLES_NV,
                                              VK_GEOMETRY_TYPE_INSTANCES_KHR};
    for (int i = 0; i < 2; i++) {
        const STRUCT(VkGeometryNV, geometry, .geometryType = types[i],
                     .geometry = {.triangles = MAKE(VkGeometryTrianglesNV, .vertexCount = 3,
                                                    .indexType = VK_INDEX_TYPE_NONE_NV),
                                  .aabbs = MAKE(VkGeometryAABBNV, .numAABBs = 1)});
        const STRUCT(VkAccelerationStructureInfoNV, info,
                     .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV, .geometryCount = 1,
                     .pGeometries = &geometry);
        struct readable_cache cache = {0};
        struct build_parameters build;
        assert_int_equal(nv_info_copy(&cache, &info, NULL, &build), VK_SUCCESS);
        assert_int_equal(build.ranges[0].primitiveCount, i == 0);
        assert_int_equal(build.geometries[0].geometryType,
                         i == 0 ? VK_GEOMETRY_TYPE_TRIANGLES_KHR : VK_GEOMETRY_TYPE_MAX_ENUM_KHR);
        build_parameters_release(&build);
    }
}

TEST(each_input_of_a_geometry_has_a_member)
{
    const VkAccelerationStructureGeometryKHR geometry = {.sType = 0};
    const struct chained_input chained = {.has_opacity = false};
    for (enum input_role role = 0; role < INPUT_ROLES; role++)
        assert_int_equal(input_place(&geometry, &chained, role) == NULL,
                         role == INPUT_SCRATCH || role == INPUT_UPDATE_SCRATCH ||
                             role == INPUT_INDIRECT);
}

/* Only inputs of VK_NV_ray_tracing have a name there. */
TEST(each_input_has_names)
{
    for (unsigned role = 0; role < INPUT_ROLES; role++)
        for (unsigned form = INPUT_PLAIN; form < INPUT_OF_NV; form++)
            assert_true(input_name((enum input_role)role, (enum input_form)form) != NULL);
    assert_has(input_name(INPUT_AABBS, INPUT_OF_HOST), "geometry.aabbs.data.hostAddress");
    assert_has(input_name(INPUT_AABBS, INPUT_OF_NV), "geometry.aabbs.aabbData");
}
