/* SPDX-License-Identifier: Apache-2.0 */
/* Which query of sizes explains a size, and in what it differs from a build, beyond the programs of
 * tests/programs/execution/size_queries.cases. */
#include "src/state/builds/size_queries.h"
#include "tests/unit/unit_test.h"

static const VkAccelerationStructureBuildTypeKHR build_type =
    VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR;
static struct size_queries *queries;
static VkAccelerationStructureGeometryKHR geometry;
static VkAccelerationStructureBuildGeometryInfoKHR info;

static void open_queries(void)
{
    assert_int_equal(size_queries_create(&queries), VK_SUCCESS);
    geometry = (VkAccelerationStructureGeometryKHR){.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR};
    info = (VkAccelerationStructureBuildGeometryInfoKHR){
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .geometryCount = 1,
        .pGeometries = &geometry};
}

static void close_queries(void)
{
    size_queries_destroy(queries);
}

static void ask(uint32_t count, VkDeviceSize size)
{
    const VkAccelerationStructureBuildSizesInfoKHR sizes = {
        .accelerationStructureSize = size, .buildScratchSize = size / 2, .updateScratchSize = 10};
    size_queries_add(queries, &info, &count, build_type, &sizes);
}

static struct size_differences find(uint32_t count, VkDeviceSize size)
{
    struct size_differences found = {.build = 7};
    size_queries_find(queries, &info, &count, build_type, SIZE_OF_STRUCTURE, size, &found);
    assert_int_equal(found.build, 7);
    return found;
}

TEST_BETWEEN(sizes_may_be_rounded_up, open_queries, close_queries)
{
    ask(1, 1000);
    assert_int_equal(find(2, 1024).count, 1);
    assert_int_equal(find(2, 1256).count, 0);
    assert_int_equal(find(2, 999).count, 0);
}

TEST_BETWEEN(each_geometry_has_a_stride, open_queries, close_queries)
{
    VkAccelerationStructureGeometryKHR geometries[2] = {geometry, geometry};
    const uint32_t counts[2] = {1, 1};
    struct size_differences found = {.build = 7};
    const VkAccelerationStructureBuildSizesInfoKHR sizes = {.accelerationStructureSize = 1000};
    info.geometryCount = 2;
    info.pGeometries = geometries;
    geometries[0].geometry.triangles.vertexStride = 12;
    geometries[1].geometry.triangles.vertexStride = 16;
    size_queries_add(queries, &info, counts, build_type, &sizes);
    geometries[1].geometry.triangles.vertexStride = 20;
    size_queries_find(queries, &info, counts, build_type, SIZE_OF_STRUCTURE, 1000, &found);
    assert_int_equal(found.count, 1);
    assert_int_equal(found.items[0].member, SIZED_STRIDE);
    assert_int_equal(found.items[0].queried, 16);
    assert_int_equal(found.items[0].built, 20);
}

TEST_BETWEEN(few_differences_are_listed, open_queries, close_queries)
{
    ask(1, 1000);
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    geometry.geometry.triangles.maxVertex = 5;
    assert_int_equal(find(2, 1000).count, SIZE_DIFFERENCES);
}
