/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu through the loader: builds, updates and copies by the host, what rays meet, and what
 * was counted meanwhile. The valid calls are silent. */
#include <stdlib.h>
#include <string.h>

#include "host_fixture.h"

SILENT_TEST(test_build_and_trace)
{
    open_pair(10, 0);
    expect_pair(pair.tlas.handle, 1);
    AssayHit hit = fixture_trace(pair.blas.handle, 0.25f, 0.25f);
    assert_true(hit.isHit);
    assert_int_equal(hit.instance, 0);
    assert_int_equal(hit.customIndex, 0);
}

SILENT_TEST(test_sizes)
{
    struct fixture_build build;
    fixture_triangles(&build, 1000, 0);
    VkAccelerationStructureBuildSizesInfoKHR sizes = fixture_sizes(&build), other = sizes;
    assert_true(sizes.accelerationStructureSize > 1000 * 48);
    assert_true(sizes.buildScratchSize > sizes.updateScratchSize);
    vk.GetAccelerationStructureBuildSizesKHR(
        device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_OR_DEVICE_KHR, &build.info,
        &build.range.primitiveCount, &other);
    assert_memory_equal(&sizes, &other, sizeof(sizes));
    build.info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR;
    VkDeviceSize fast = fixture_sizes(&build).buildScratchSize;
    build.info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    assert_true(fixture_sizes(&build).buildScratchSize > fast);

    const VkAccelerationStructureGeometryKHR *pointer = &build.geometry;
    build.info.pGeometries = NULL;
    build.info.ppGeometries = &pointer;
    assert_int_equal(fixture_sizes(&build).accelerationStructureSize,
                     sizes.accelerationStructureSize);
    build.info.geometryCount = 0;
    assert_true(fixture_sizes(&build).accelerationStructureSize > 0);
}

/* In place, and into another structure, which leaves the source as it was. */
SILENT_TEST(test_update)
{
    open_pair(10, UPDATABLE);
    struct fixture_structure other = fixture_create_blas(pair.blas.size);
    fixture_move(&pair.triangles, 2, 0, 0);
    GET(host_build(&pair.triangles, other.handle, pair.blas.handle));
    assert_float_equal(fixture_trace(other.handle, 0.25f, 0.25f).t, 3, 0);
    expect_pair(pair.tlas.handle, 1);
    GET(host_build(&pair.triangles, pair.blas.handle, pair.blas.handle));
    GET(host_build(&pair.instances, pair.tlas.handle, pair.tlas.handle));
    expect_pair(pair.tlas.handle, 3);
}

static AssayAnswer enter_half_way(void *data, uint32_t ray, AssayHit *candidate)
{
    (void)ray;
    *(uint32_t *)data += 1;
    candidate->t += candidate->primitive == 1 ? 0.5f : 50; /* behind what was accepted: ignored */
    return ASSAY_ANSWER_ACCEPT;
}

/* Boxes are hit where the ray enters, unless the application says where. */
SILENT_TEST(test_boxes)
{
    static const VkAabbPositionsKHR boxes[] = {{3, 0, 0, 4, 1, 1}, {1, 0, 0, 2, 1, 1}};
    struct fixture_build build;
    fixture_triangles(&build, 2, 0);
    build.geometry.geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
    build.geometry.geometry.aabbs = MAKE(VkAccelerationStructureGeometryAabbsDataKHR,
                                         .data.hostAddress = boxes, .stride = sizeof(boxes[0]));
    struct fixture_structure blas = fixture_create_for(&build);
    GET(host_build(&build, blas.handle, VK_NULL_HANDLE));
    AssayHit hit = fixture_trace(blas.handle, 0.5f, 0.5f);
    assert_true(hit.isAabb);
    expect_hit_at(hit, 2, 1);

    const AssayRay ray = {.origin = {-1, 0.5f, 0.5f}, .direction = {1, 0, 0}, .tMax = 10};
    uint32_t asked = 0;
    AssayTraceInfo info = trace_info((uint64_t)blas.handle, ASSAY_ACCURACY_ROBUST, 1, &ray, &hit);
    info.candidate = enter_half_way;
    info.userData = &asked;
    GET(trace_rays(device, &info));
    expect_hit_at(hit, 2.5f, 1);
    assert_true(asked >= 1);
}

/* ---- counters: paired scenes, one thing apart */

SILENT_TEST(test_counters)
{
    AssayCounters start = fixture_counters();
    open_pair(10, UPDATABLE);
    AssayCounters did = fixture_counters_since(&start);
    AssayCounters expected = {
        .builds = 2, .primitives = 12, .bytesBuilt = pair.blas.size + pair.tlas.size};
    assert_memory_equal(&did, &expected, sizeof(did));

    start = fixture_counters();
    host_build(&pair.triangles, pair.blas.handle, pair.blas.handle);
    did = fixture_counters_since(&start);
    expected = (AssayCounters){.updates = 1, .primitives = 10, .bytesBuilt = pair.blas.size};
    assert_memory_equal(&did, &expected, sizeof(did));

    /* Beside the triangles nothing is tested; within one, without need of exactness; through an
     * edge with. */
    start = fixture_counters();
    fixture_trace(pair.blas.handle, 5, 5);
    did = fixture_counters_since(&start);
    assert_int_equal(did.rays, 1);
    assert_int_equal(did.primitivesTested, 0);
    fixture_trace(pair.blas.handle, 0.25f, 0.25f);
    did = fixture_counters_since(&start);
    assert_true(did.primitivesTested > 0);
    assert_int_equal(did.exactCalls, 0);
    fixture_trace(pair.blas.handle, 0.5f, 0.5f);
    did = fixture_counters_since(&start);
    assert_true(did.exactCalls > 0);
    assert_int_equal(did.builds + did.updates + did.copies + did.instancesEntered, 0);

    char part[12];
    memset(part, 0x55, sizeof(part));
    get_counters(device, 8, (AssayCounters *)(void *)part);
    uint64_t builds;
    memcpy(&builds, part, 8);
    assert_int_equal(builds, fixture_counters().builds);
    assert_int_equal(part[8], 0x55);
}

SILENT_TEST(test_counters_of_a_micromap)
{
    static const VkMicromapUsageEXT usage = {.count = 1, .format = 1};
    static const VkMicromapTriangleEXT triangle = {.format = 1};
    const struct fixture_structure blas = fixture_create_blas(4096);
    const STRUCT(VkMicromapCreateInfoEXT, create_info, .buffer = blas.storage.handle, .size = 4096);
    STRUCT(VkMicromapBuildInfoEXT, info, .usageCountsCount = 1, .pUsageCounts = &usage,
           .data.hostAddress = &usage, .triangleArray.hostAddress = &triangle,
           .triangleArrayStride = sizeof(triangle));
    GET(vk.CreateMicromapEXT(device, &create_info, NULL, &info.dstMicromap));
    OWN(DestroyMicromapEXT, info.dstMicromap);
    const AssayCounters start = fixture_counters();
    GET(vk.BuildMicromapsEXT(device, VK_NULL_HANDLE, 1, &info));
    const AssayCounters did = fixture_counters_since(&start);
    assert_int_equal(did.builds, 1);
    assert_true(did.bytesBuilt > 0);
}

/* ---- tracing */

SILENT_TEST(test_trace_arguments)
{
    open_pair(10, 0);
    AssayRay rays[2] = {0};
    AssayHit hits[2];
    const AssayTraceInfo valid =
        trace_info((uint64_t)pair.tlas.handle, ASSAY_ACCURACY_FAST, 2, rays, hits);
    GET(trace_rays(device, &valid));
    assert_false(hits[0].isHit || hits[1].isHit); /* no direction */
    AssayTraceInfo mistakes[] = {valid, valid, valid, valid, valid, valid};
    mistakes[0].raySize--;
    mistakes[1].hitSize++;
    mistakes[2].accuracy = (AssayAccuracy)3;
    mistakes[3].rays = NULL;
    mistakes[4].hits = (AssayHit *)(uintptr_t)0x1000;
    mistakes[5].accelerationStructure++;
    for (size_t i = 0; i < ARRAY_COUNT(mistakes); i++)
        expect_mistake(trace_rays(device, &mistakes[i]));
    GET(trace_rays(device, &valid));
    expect_mistake(trace_rays(device, NULL));
}

struct answers {
    AssayAnswer answer;
    uint32_t asked;
};

/* Accepts no triangle before the plane x = 3. */
static AssayAnswer answer(void *data, uint32_t ray, AssayHit *candidate)
{
    struct answers *answers = data;
    assert_true(ray < 2);
    answers->asked++;
    return candidate->t < 3.5f ? ASSAY_ANSWER_IGNORE : answers->answer;
}

SILENT_TEST(test_trace_candidates)
{
    open_pair(10, 0);
    const AssayRay ray = {
        .origin = {-1, 0.25f, 0.25f}, .direction = {1, 0, 0}, .tMax = 100, .cullMask = 0xff};
    const AssayRay rays[2] = {ray, ray};
    AssayHit hits[2];
    struct answers answers = {ASSAY_ANSWER_ACCEPT, 0};
    AssayTraceInfo info =
        trace_info((uint64_t)pair.tlas.handle, ASSAY_ACCURACY_EXACT, 2, rays, hits);
    info.candidate = answer;
    info.userData = &answers;
    GET(trace_rays(device, &info));
    for (int i = 0; i < 2; i++)
        expect_hit_at(hits[i], 4, 3);
    assert_true(answers.asked >= 8);
    answers = (struct answers){ASSAY_ANSWER_STOP, 0};
    GET(trace_rays(device, &info));
    assert_false(hits[0].isHit || hits[1].isHit);
}

/* ---- clones, compaction and properties; structures that go to memory and come back */

NOISY_TEST(test_copies)
{
    open_pair(100, COMPACTABLE | UPDATABLE);
    uint64_t size = fixture_property(pair.blas.handle, COMPACTED_SIZE);
    assert_true(size > 0 && size <= pair.blas.size);
    assert_int_equal(fixture_property(pair.blas.handle, STRUCTURE_SIZE), pair.blas.size);
    struct fixture_structure compact = fixture_create_blas(size);
    struct fixture_structure clone = fixture_create_blas(pair.blas.size);
    GET(host_copy(pair.blas.handle, compact.handle, COMPACT));
    GET(host_copy(pair.blas.handle, clone.handle, CLONE));
    messages_expect_none(messages);
    assert_int_equal(fixture_property(compact.handle, STRUCTURE_SIZE), size);
    fixture_move(&pair.triangles, 2, 0, 0);
    GET(host_build(&pair.triangles, compact.handle, compact.handle));
    assert_float_equal(fixture_trace(compact.handle, 0.25f, 0.25f).t, 3, 0);
    assert_float_equal(fixture_trace(clone.handle, 0.25f, 0.25f).t, 1, 0);
    messages_expect_none(messages);

    if (size < pair.blas.size)
        expect_mistake(host_copy(pair.blas.handle, compact.handle, CLONE));
    destroy((uint64_t)clone.handle);
    expect_mistake(host_copy(pair.blas.handle, clone.handle, CLONE));
    expect_mistake(host_copy(clone.handle, compact.handle, COMPACT));
}

static VkResult deserialize(const void *bytes, VkAccelerationStructureKHR dst)
{
    return fixture_load(VK_NULL_HANDLE, bytes, dst);
}

static VkAccelerationStructureCompatibilityKHR compatibility(const void *bytes)
{
    const STRUCT(VkAccelerationStructureVersionInfoKHR, info, .pVersionData = bytes);
    VkAccelerationStructureCompatibilityKHR answer;
    vk.GetDeviceAccelerationStructureCompatibilityKHR(device, &info, &answer);
    return answer;
}

/* A pair written to memory, destroyed, and read back with other references. */
NOISY_TEST(test_serialize_and_relocate)
{
    open_pair(100, 0);
    size_t blas_size, tlas_size;
    uint64_t pointers = fixture_property(
        pair.tlas.handle,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR);
    assert_int_equal(pointers, 2);
    uint64_t *blas = fixture_serialize(pair.blas.handle, &blas_size);
    uint64_t *tlas = fixture_serialize(pair.tlas.handle, &tlas_size);
    assert_int_equal(blas[4], blas_size);
    assert_int_equal(tlas[4], tlas_size);
    assert_int_equal(tlas[6], 2);
    assert_int_equal(tlas[7], (uint64_t)pair.blas.handle);
    destroy_pair();

    struct fixture_structure new_blas = fixture_create_blas(blas[5]);
    struct fixture_structure new_tlas = fixture_create(TOP, tlas[5]);
    assert_int_equal(compatibility(tlas), VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR);
    GET(deserialize(blas, new_blas.handle));
    GET(deserialize(tlas, new_tlas.handle));
    assert_false(fixture_trace(new_tlas.handle, 0.25f, 0.25f).isHit); /* its BLAS is gone */
    tlas[7] = tlas[8] = structure_address(&vk, device, new_blas.handle);
    GET(deserialize(tlas, new_tlas.handle));
    expect_pair(new_tlas.handle, 1);
    messages_expect_none(messages);

    tlas[4] -= 8;
    expect_mistake(deserialize(tlas, new_tlas.handle));
    tlas[4] = UINT64_MAX;
    expect_mistake(deserialize(tlas, new_tlas.handle));
    ((uint8_t *)tlas)[VK_UUID_SIZE] ^= 1;
    assert_int_equal(compatibility(tlas), VK_ACCELERATION_STRUCTURE_COMPATIBILITY_INCOMPATIBLE_KHR);
    expect_mistake(deserialize(tlas, new_tlas.handle));
    expect_mistake(deserialize(NULL, new_tlas.handle));
    expect_mistake(deserialize((void *)(uintptr_t)0x1000, new_tlas.handle));
    expect_pair(new_tlas.handle, 1);
}
