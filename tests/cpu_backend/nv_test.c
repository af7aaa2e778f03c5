/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing's build side on backend cpu, through the loader: what it builds is, byte for
 * byte, what the host builds of the same input by VK_KHR_acceleration_structure. */
#include "device_fixture.h"

#include <stdlib.h>
#include <string.h>

/* One buffer has all inputs. */
enum {
    TRIANGLES = 40,
    BOXES = 20,
    INSTANCES = 2,
    VERTEX_STRIDE = 16,
    BOX_STRIDE = 32,
    PLAIN_AT = 256,   /* three vertices a triangle */
    SHARED_AT = 4096, /* the same, which indices use */
    INDICES_AT = 8194,
    TRANSFORM_AT = 12288,
    BOXES_AT = 16392,
    INSTANCES_AT = 20496,
    DATA_SIZE = 32768,
};

static struct device_buffer data;

static void *data_at(size_t offset)
{
    return data.bytes + offset;
}

/* (x, y, 0), (x, y + 1, 0), (x, y, 1) for x = 0, 1, 2 ... */
static void put_triangles(size_t at, float y)
{
    for (int i = 0; i < TRIANGLES; i++)
        for (int corner = 0; corner < 3; corner++) {
            const float vertex[3] = {(float)i, y + (corner == 1), corner == 2};
            memcpy(data_at(at + (size_t)(3 * i + corner) * VERTEX_STRIDE), vertex, sizeof(vertex));
        }
}

static void open_data(void)
{
    data = device_buffer_create(DATA_SIZE);
    const VkTransformMatrixKHR up = {{{1, 0, 0, 0}, {0, 1, 0, 10}, {0, 0, 1, 0}}};
    put_triangles(PLAIN_AT, 0);
    put_triangles(SHARED_AT, 0);
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++) {
        const uint16_t index = (uint16_t)(3 * TRIANGLES - 1 - i);
        memcpy(data_at(INDICES_AT + i * sizeof(index)), &index, sizeof(index));
    }
    memcpy(data_at(TRANSFORM_AT), &up, sizeof(up));
    for (int i = 0; i < BOXES; i++) {
        const VkAabbPositionsKHR box = {(float)i, 0, 0, i + 0.5f, 1, 1};
        memcpy(data_at(BOXES_AT + (size_t)i * BOX_STRIDE), &box, sizeof(box));
    }
}

#define DATA_TEST(name) TEST_BETWEEN(name, open_data, close_silent_test)

/* ---- a build, said in both ways */

struct twins {
    VkGeometryNV nv_geometries[2];
    VkAccelerationStructureInfoNV nv;
    VkAccelerationStructureGeometryKHR geometries[2];
    VkAccelerationStructureBuildRangeInfoKHR ranges[2];
    VkAccelerationStructureBuildGeometryInfoKHR khr;
};

static void open_twins(struct twins *twins, VkAccelerationStructureTypeKHR type, uint32_t count,
                       VkBuildAccelerationStructureFlagsKHR flags)
{
    memset(twins, 0, sizeof(*twins));
    twins->nv = MAKE(VkAccelerationStructureInfoNV, .type = type, .flags = flags,
                     .geometryCount = count, .pGeometries = count ? twins->nv_geometries : NULL);
    twins->khr = MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .type = type, .flags = flags,
                      .geometryCount = count ? count : 1, .pGeometries = twins->geometries);
    for (int i = 0; i < 2; i++) {
        VkGeometryNV *nv = &twins->nv_geometries[i];
        *nv = nv_triangles(data.handle, i == 0 ? PLAIN_AT : SHARED_AT, VERTEX_STRIDE, TRIANGLES);
        twins->geometries[i].sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
        nv->flags = twins->geometries[i].flags = i == 0 ? VK_GEOMETRY_OPAQUE_BIT_KHR : 0;
    }
}

/* Plain triangles, then indexed ones 10 higher. */
static void describe_triangles(struct twins *twins, VkBuildAccelerationStructureFlagsKHR flags)
{
    open_twins(twins, BOTTOM, 2, flags);
    for (int i = 0; i < 2; i++) {
        twins->geometries[i].geometry.triangles =
            MAKE(VkAccelerationStructureGeometryTrianglesDataKHR,
                 .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexStride = VERTEX_STRIDE,
                 .vertexData.hostAddress = data_at(i == 0 ? PLAIN_AT : SHARED_AT),
                 .maxVertex = 3 * TRIANGLES - 1, .indexType = VK_INDEX_TYPE_NONE_KHR);
        twins->ranges[i].primitiveCount = TRIANGLES;
    }
    VkGeometryTrianglesNV *nv = &twins->nv_geometries[1].geometry.triangles;
    nv->indexType = VK_INDEX_TYPE_UINT16;
    nv->indexData = nv->transformData = data.handle;
    nv->indexOffset = INDICES_AT;
    nv->indexCount = 3 * TRIANGLES;
    nv->transformOffset = TRANSFORM_AT;
    VkAccelerationStructureGeometryTrianglesDataKHR *khr = &twins->geometries[1].geometry.triangles;
    khr->indexType = VK_INDEX_TYPE_UINT16;
    khr->indexData.hostAddress = data_at(INDICES_AT);
    khr->transformData.hostAddress = data_at(TRANSFORM_AT);
}

static void describe_boxes(struct twins *twins)
{
    open_twins(twins, BOTTOM, 1, 0);
    twins->nv_geometries[0].geometryType = VK_GEOMETRY_TYPE_AABBS_NV;
    VkGeometryAABBNV *nv = &twins->nv_geometries[0].geometry.aabbs;
    nv->aabbData = data.handle;
    nv->numAABBs = BOXES;
    nv->stride = BOX_STRIDE;
    nv->offset = BOXES_AT;
    twins->geometries[0].geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
    twins->geometries[0].geometry.aabbs =
        MAKE(VkAccelerationStructureGeometryAabbsDataKHR, .data.hostAddress = data_at(BOXES_AT),
             .stride = BOX_STRIDE);
    twins->ranges[0].primitiveCount = BOXES;
}

/* Instances of one BLAS, 20 apart in y. */
static void describe_instances(struct twins *twins, uint64_t reference)
{
    open_twins(twins, TOP, 0, UPDATABLE);
    twins->nv.instanceCount = INSTANCES;
    for (int i = 0; i < INSTANCES; i++) {
        const VkAccelerationStructureInstanceKHR element = {
            .transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 20.0f * i}, {0, 0, 1, 0}},
            .mask = 0xff,
            .accelerationStructureReference = reference,
        };
        memcpy(data_at(INSTANCES_AT + (size_t)i * sizeof(element)), &element, sizeof(element));
    }
    twins->geometries[0].geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    twins->geometries[0].flags = 0;
    twins->geometries[0].geometry.instances = MAKE(VkAccelerationStructureGeometryInstancesDataKHR,
                                                   .data.hostAddress = data_at(INSTANCES_AT));
    twins->ranges[0].primitiveCount = INSTANCES;
}

static void record(const struct twins *twins, VkCommandBuffer commands, struct nv_structure *dst,
                   VkAccelerationStructureNV src)
{
    const bool is_top = twins->nv.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV;
    nv_build(commands, &twins->nv, is_top ? data.handle : VK_NULL_HANDLE, is_top ? INSTANCES_AT : 0,
             dst, src);
}

static void build(const struct twins *twins, struct nv_structure *dst,
                  VkAccelerationStructureNV src)
{
    VkCommandBuffer commands = device_begin(PRIMARY);
    record(twins, commands, dst, src);
    device_finish(commands);
}

/* The backend has one kind of structures, so the host can be asked for the bytes of these. */
static VkAccelerationStructureKHR as_khr(const struct nv_structure *structure)
{
    return (VkAccelerationStructureKHR)structure->handle;
}

/* The commands of KHR read the bytes, which is not valid: the layer reports the handles, and
 * backend cpu serializes what they stand for. */
static void expect_equal(const struct nv_structure *a, VkAccelerationStructureKHR b)
{
    messages_expect_none(messages);
    expect_same_bytes(as_khr(a), b);
    messages_clear(messages);
}

static void expect_host_build(struct twins *twins, const struct nv_structure *built)
{
    uint32_t counts[2] = {twins->ranges[0].primitiveCount, twins->ranges[1].primitiveCount};
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = twins->ranges;
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    vk.GetAccelerationStructureBuildSizesKHR(device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR,
                                             &twins->khr, counts, &sizes);
    assert_int_equal(built->size, sizes.accelerationStructureSize);
    struct fixture_structure twin =
        fixture_create(twins->khr.type, sizes.accelerationStructureSize);
    twins->khr.dstAccelerationStructure = twin.handle;
    twins->khr.scratchData.hostAddress = own_block(malloc(sizes.buildScratchSize));
    GET(vk.BuildAccelerationStructuresKHR(device, VK_NULL_HANDLE, 1, &twins->khr, &ranges));
    expect_equal(built, twin.handle);
}

static bool is_hit(const struct nv_structure *structure, float y)
{
    return fixture_trace(as_khr(structure), y + 0.25f, 0.25f).isHit;
}

/* ---- tests */

DATA_TEST(test_same_as_host_builds)
{
    struct twins triangles, boxes, instances;
    describe_triangles(&triangles, 0);
    describe_boxes(&boxes);
    struct nv_structure blas = nv_create(&triangles.nv, 0);
    struct nv_structure of_boxes = nv_create(&boxes.nv, 0);
    describe_instances(&instances, nv_reference(blas.handle));
    struct nv_structure tlas = nv_create(&instances.nv, 0);

    VkCommandBuffer commands = device_begin(PRIMARY);
    record(&triangles, commands, &blas, VK_NULL_HANDLE);
    record(&boxes, commands, &of_boxes, VK_NULL_HANDLE);
    record(&instances, commands, &tlas, VK_NULL_HANDLE);
    device_finish(commands);
    assert_true(is_hit(&blas, 0) && is_hit(&blas, 10) && !is_hit(&blas, 5));
    assert_true(is_hit(&tlas, 0) && is_hit(&tlas, 30) && !is_hit(&tlas, 40));
    assert_int_equal(fixture_trace(as_khr(&tlas), 30.25f, 0.25f).geometry, 1);
    assert_true(fixture_trace(as_khr(&of_boxes), 0.25f, 0.25f).isAabb);
    expect_host_build(&triangles, &blas);
    expect_host_build(&boxes, &of_boxes);
    expect_host_build(&instances, &tlas);
}

/* What a build copies is what it reads, once. */
DATA_TEST(test_snapshots)
{
    struct twins twins;
    describe_triangles(&twins, 0);
    twins.nv_geometries[0].geometry.triangles.vertexOffset = SHARED_AT;
    twins.geometries[0].geometry.triangles.vertexData.hostAddress = data_at(SHARED_AT);
    struct nv_structure blas = nv_create(&twins.nv, 0);
    const AssayCounters before = fixture_counters();
    build(&twins, &blas, VK_NULL_HANDLE);
    const AssayCounters after = fixture_counters();
    const uint64_t vertices = 3 * TRIANGLES * VERTEX_STRIDE, indices = 3 * TRIANGLES * 2;
    const uint64_t copied = after.bytesSnapshot - before.bytesSnapshot;
    assert_true(copied >= vertices + indices && copied < vertices + indices + 128);
    assert_int_equal(after.builds, before.builds);
    expect_host_build(&twins, &blas);
}

DATA_TEST(test_updates)
{
    struct twins twins, instances;
    describe_triangles(&twins, UPDATABLE);
    struct nv_structure first = nv_create(&twins.nv, 0);
    struct nv_structure second = nv_create(&twins.nv, 0);
    describe_instances(&instances, nv_reference(second.handle));
    struct nv_structure tlas = nv_create(&instances.nv, 0);
    const AssayCounters before = fixture_counters();
    build(&twins, &first, VK_NULL_HANDLE);
    put_triangles(PLAIN_AT, 3);
    build(&twins, &second, first.handle);
    build(&instances, &tlas, VK_NULL_HANDLE);
    put_triangles(PLAIN_AT, 6);
    build(&twins, &first, first.handle);
    put_triangles(PLAIN_AT, 0);
    assert_true(is_hit(&second, 3) && !is_hit(&second, 0) && !is_hit(&second, 6));
    assert_true(is_hit(&first, 6) && !is_hit(&first, 0) && !is_hit(&first, 3));
    assert_true(is_hit(&tlas, 23) && !is_hit(&tlas, 20));
    const AssayCounters after = fixture_counters();
    assert_int_equal(after.updates - before.updates, 2);

    destroy((uint64_t)second.handle); /* instances of what is gone aren't hit */
    assert_false(is_hit(&tlas, 23));
}

static VkDeviceSize compacted_size(const struct nv_structure *structure)
{
    const VkQueryType type = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV;
    VkQueryPool pool = query_pool_create(&vk, device, type, 2);
    uint64_t unwritten;
    OWN(DestroyQueryPool, pool);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdResetQueryPool(commands, pool, 0, 2);
    vk.CmdWriteAccelerationStructuresPropertiesNV(commands, 1, &structure->handle, type, pool, 1);
    device_finish(commands);
    assert_int_equal(
        vk.GetQueryPoolResults(device, pool, 0, 1, 8, &unwritten, 8, VK_QUERY_RESULT_64_BIT),
        VK_NOT_READY);
    return device_query(pool, 1);
}

DATA_TEST(test_copies)
{
    struct twins twins;
    describe_triangles(&twins, COMPACTABLE);
    struct nv_structure blas = nv_create(&twins.nv, 0);
    struct nv_structure clone = nv_create(&twins.nv, 0);
    build(&twins, &blas, VK_NULL_HANDLE);
    const VkDeviceSize size = compacted_size(&blas);
    assert_true(size > 0 && size < blas.size);
    const STRUCT(VkAccelerationStructureInfoNV, nothing,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV, .flags = COMPACTABLE);
    struct nv_structure compact = nv_create(&nothing, size);
    assert_int_equal(compact.size, size);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdCopyAccelerationStructureNV(commands, clone.handle, blas.handle, CLONE);
    vk.CmdCopyAccelerationStructureNV(commands, compact.handle, blas.handle, COMPACT);
    device_finish(commands);
    expect_equal(&blas, as_khr(&clone));
    destroy((uint64_t)blas.handle);
    assert_true(is_hit(&clone, 0) && is_hit(&clone, 10) && !is_hit(&clone, 5));
    assert_true(is_hit(&compact, 0) && is_hit(&compact, 10) && !is_hit(&compact, 5));
}
