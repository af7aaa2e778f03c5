/* SPDX-License-Identifier: Apache-2.0 */
/* Spheres, linear swept spheres and dense geometry on backend cpu, through the loader: built by the
 * host and by command buffers, from what was there when they executed, and traced. */
#include <string.h>

#include "dense_blocks.h"
#include "input_scene.h"

/* ---- spheres: centers at x = 4, 8, 12 ... with radius 1, 0.5 apart in y and z from each other */

enum { SPHERES = 6, FIRST = 2, OFFSET = 8 };

static void fill_spheres(struct input_scene *scene)
{
    float *center = (float *)scene->vertices.bytes, *radius = (float *)scene->radii.bytes;
    uint16_t *index = (uint16_t *)scene->indices.bytes;
    for (uint32_t i = 0; i < SPHERES; i++) {
        const float at[3] = {4.0f * (float)(i + 1), 3.0f * (float)i, 0};
        memcpy(center + 4 * (FIRST + i), at, sizeof(at));
        radius[FIRST + i] = 1;
        index[OFFSET / 2 + i] = (uint16_t)(SPHERES - 1 - i);
    }
}

/* Primitive i is center SPHERES - 1 - i; indices lie behind an offset, centers behind others. */
static const VkAccelerationStructureBuildRangeInfoKHR all_spheres = {
    .primitiveCount = SPHERES, .primitiveOffset = OFFSET, .firstVertex = FIRST};

#define SPHERE_MEMBERS                                                                             \
    .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexStride = 16,                                \
    .radiusFormat = VK_FORMAT_R32_SFLOAT, .radiusStride = 4, .indexType = VK_INDEX_TYPE_UINT16,    \
    .indexStride = 2

static const STRUCT(VkAccelerationStructureGeometrySpheresDataNV, sphere_data, SPHERE_MEMBERS);

static const STRUCT(VkAccelerationStructureGeometryLinearSweptSpheresDataNV, swept_data,
                    SPHERE_MEMBERS, .indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV,
                    .endCapsMode = VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_CHAINED_NV);

/* Either structure's addresses. */
#define GIVE_ADDRESSES(data, scene, member)                                                        \
    ((data)->vertexData.deviceAddress = (uint64_t)(uintptr_t)(scene)->vertices.member,             \
     (data)->radiusData.deviceAddress = (uint64_t)(uintptr_t)(scene)->radii.member,                \
     (data)->indexData.deviceAddress = (uint64_t)(uintptr_t)(scene)->indices.member)

static void expect_spheres(const struct input_scene *scene)
{
    for (uint32_t i = 0; i < SPHERES; i++)
        input_scene_expect_hit(scene, 3.0f * (float)i, 0, 4.0f * (float)(i + 1), SPHERES - 1 - i);
    input_scene_expect_miss(scene, 0, 1.25f);
}

static void open_spheres(struct input_scene *scene,
                         VkAccelerationStructureGeometrySpheresDataNV *data)
{
    *data = sphere_data;
    input_scene_open(scene, VK_GEOMETRY_TYPE_SPHERES_NV, data);
    scene->build.range = all_spheres;
    fill_spheres(scene);
    input_scene_create(scene);
}

SILENT_TEST(test_spheres)
{
    for (int by = 0; by < 3; by++) {
        struct input_scene scene;
        VkAccelerationStructureGeometrySpheresDataNV data;
        open_spheres(&scene, &data);
        if (by == 0) {
            GIVE_ADDRESSES(&data, &scene, bytes);
            scene.build.info.scratchData.hostAddress = scene.build.scratch;
            GET(host_build(&scene.build, scene.blas.handle, 0));
        } else {
            GIVE_ADDRESSES(&data, &scene, address);
            input_scene_build(&scene, &all_spheres, by == 2);
        }
        expect_spheres(&scene);
    }
}

/* Without indices: centers and radii both begin at the offset. */
SILENT_TEST(test_spheres_without_indices)
{
    for (int by = 1; by < 3; by++) {
        struct input_scene scene;
        VkAccelerationStructureGeometrySpheresDataNV data;
        const VkAccelerationStructureBuildRangeInfoKHR range = {
            .primitiveCount = 2, .primitiveOffset = 16, .firstVertex = FIRST};
        open_spheres(&scene, &data);
        data.indexType = VK_INDEX_TYPE_NONE_KHR;
        data.radiusStride = 16;
        for (uint32_t i = 0; i < INPUT_SIZE / sizeof(float); i++)
            ((float *)scene.radii.bytes)[i] = 0.5f;
        GIVE_ADDRESSES(&data, &scene, address);
        data.indexData.deviceAddress = 0;
        input_scene_build(&scene, &range, by == 2);
        input_scene_expect_hit(&scene, 3, 0, 8.5f, 0);
        input_scene_expect_hit(&scene, 6, 0, 12.5f, 1);
        input_scene_expect_miss(&scene, 0, 0);
        input_scene_expect_miss(&scene, 9, 0);
    }
}

/* From the first to the second center, and from the third to the fourth; or from each to the next.
 */
SILENT_TEST(test_swept_spheres)
{
    for (int by = 1; by < 5; by++) {
        const bool is_successive = by > 2;
        struct input_scene scene;
        VkAccelerationStructureGeometryLinearSweptSpheresDataNV data = swept_data;
        const uint16_t indices[4] = {0, 1, 2, 3};
        const VkAccelerationStructureBuildRangeInfoKHR range = {
            .primitiveCount = 2, .primitiveOffset = OFFSET, .firstVertex = FIRST};
        if (is_successive)
            data.indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
        input_scene_open(&scene, VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, &data);
        fill_spheres(&scene);
        memcpy(scene.indices.bytes + OFFSET, indices, sizeof(indices));
        scene.build.range = range;
        input_scene_create(&scene);
        GIVE_ADDRESSES(&data, &scene, address);
        input_scene_build(&scene, &range, by % 2 == 0);
        const AssayHit first = input_scene_trace(&scene, 1.5f, 0);
        const AssayHit second = input_scene_trace(&scene, is_successive ? 4.5f : 7.5f, 0);
        assert_true(first.isHit && first.primitive == 0);
        assert_true(second.isHit && second.primitive == 1);
        assert_int_equal(input_scene_trace(&scene, 4.5f, 0).isHit, is_successive);
        input_scene_expect_miss(&scene, 13, 0);
    }
}

/* An index that leads out of the centers; and indices that lead nowhere. */
NOISY_TEST(test_spheres_out_of_range)
{
    struct input_scene scene;
    VkAccelerationStructureGeometrySpheresDataNV data;
    open_spheres(&scene, &data);
    ((uint16_t *)scene.indices.bytes)[OFFSET / 2] = 0xffff;
    GIVE_ADDRESSES(&data, &scene, address);
    input_scene_build(&scene, &all_spheres, false);
    expect_mistake(fixture_trace_none(scene.blas.handle));
    fill_spheres(&scene);
    GIVE_ADDRESSES(&data, &scene, bytes);
    data.indexData.deviceAddress = 0x1000;
    scene.build.info.scratchData.hostAddress = scene.build.scratch;
    expect_mistake(fixture_build(VK_NULL_HANDLE, &scene.build, scene.blas.handle, 0));
}

/* ---- dense geometry */

enum { BLOCKS = 3 };

static void open_dense(struct input_scene *scene,
                       VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *data)
{
    *data = MAKE(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX,
                 .dataSize = BLOCKS * DENSE_BLOCK, .numTriangles = BLOCKS * DENSE_BLOCK_TRIANGLES,
                 .numVertices = BLOCKS * DENSE_BLOCK_VERTICES,
                 .maxPrimitiveIndex = BLOCKS * DENSE_BLOCK_TRIANGLES - 1,
                 .format = VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_AMDX);
    input_scene_open(scene, VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX, data);
    dense_blocks_write(scene->vertices.bytes, BLOCKS);
    input_scene_create(scene);
    data->compressedData.deviceAddress = scene->vertices.address;
}

/* Of block 0, whose plane is z = 0: from above, triangle 2 i has its corner at x = i. */
static void expect_dense(const struct input_scene *scene)
{
    for (uint32_t i = 0; i < DENSE_BLOCK_TRIANGLES / 2; i++) {
        const AssayRay ray = {.origin = {0.25f + (float)i, 0.25f, -2},
                              .direction = {0, 0, 1},
                              .tMax = 100,
                              .cullMask = 0xff};
        const AssayHit hit = fixture_trace_ray(scene->blas.handle, &ray);
        expect_hit_at(hit, 2, 2 * i);
        assert_false(hit.isOpaque);
    }
}

SILENT_TEST(test_dense)
{
    for (int is_indirect = 0; is_indirect < 2; is_indirect++) {
        struct input_scene scene;
        VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX data;
        open_dense(&scene, &data);
        const AssayCounters before = fixture_counters();
        input_scene_build(&scene, NULL, is_indirect);
        if (!is_indirect)
            assert_int_equal(fixture_counters().bytesSnapshot - before.bytesSnapshot,
                             BLOCKS * DENSE_BLOCK);
        expect_dense(&scene);
    }
}

/* A chain that can't be read: nothing is built, and sizes are 0. */
NOISY_TEST(test_unreadable_chain)
{
    struct input_scene scene;
    VkAccelerationStructureGeometrySpheresDataNV data;
    open_spheres(&scene, &data);
    scene.build.geometry.pNext = (void *)(uintptr_t)0x1000;
    assert_int_equal(fixture_sizes(&scene.build).accelerationStructureSize, 0);
    scene.build.info.scratchData.hostAddress = scene.build.scratch;
    expect_mistake(fixture_build(VK_NULL_HANDLE, &scene.build, scene.blas.handle, 0));
}
