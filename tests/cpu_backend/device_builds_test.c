/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of command buffers on backend cpu, through the loader: what they read is what was there
 * when they executed, whenever the tree is asked for; and only what a scene uses is computed. */
#include <stdlib.h>
#include <string.h>

#include "device_fixture.h"

/* Triangles at (x, y, z), as far as the command buffer goes. */
static void record_triangles(VkCommandBuffer commands, float y, VkAccelerationStructureKHR dst,
                             VkAccelerationStructureKHR src)
{
    fixture_move(&pair.triangles, 0, y, 0);
    device_upload(commands, &on_device.triangles);
    device_build(commands, &on_device.triangles, dst, src);
}

static void record_scene(VkCommandBuffer commands)
{
    record_blas(commands);
    device_upload(commands, &on_device.instances);
    device_build(commands, &on_device.instances, pair.tlas.handle, VK_NULL_HANDLE);
}

/* Whether the triangles of a structure are where they are after record_triangles(y). */
static bool is_at(VkAccelerationStructureKHR structure, float y)
{
    return fixture_trace(structure, y + 0.25f, 0.25f).isHit &&
           !fixture_trace(structure, y - 0.25f, 0.25f).isHit;
}

static void record_clone(VkCommandBuffer commands, VkAccelerationStructureKHR src,
                         VkAccelerationStructureKHR dst)
{
    device_copy(commands, src, dst, CLONE);
    device_barrier(commands);
}

/* ---- tests */

SILENT_TEST(test_same_as_host_build)
{
    open_device_pair(0);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_scene(commands);
    device_finish(commands);
    assert_true(fixture_trace(pair.tlas.handle, 0.25f, 0.25f).isHit);
    assert_true(fixture_trace(pair.tlas.handle, 2.25f, 0.25f).isHit);
    assert_false(fixture_trace(pair.tlas.handle, 1.25f, 0.25f).isHit);

    struct fixture_structure blas = fixture_create_for(&pair.triangles);
    struct fixture_structure tlas = fixture_create_for(&pair.instances);
    GET(host_build(&pair.triangles, blas.handle, VK_NULL_HANDLE));
    GET(host_build(&pair.instances, tlas.handle, VK_NULL_HANDLE));
    expect_same_bytes(pair.blas.handle, blas.handle);
    expect_same_bytes(pair.tlas.handle, tlas.handle);
}

SILENT_TEST(test_only_what_is_asked_for)
{
    open_device_pair(UPDATABLE);
    const AssayCounters before = fixture_counters();
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_scene(commands);
    device_end(commands);
    for (int i = 0; i < 3; i++)
        device_run(commands);
    const AssayCounters submitted = fixture_counters();
    assert_int_equal(submitted.builds, before.builds);
    assert_int_equal(submitted.bytesSnapshot - before.bytesSnapshot,
                     pair.triangles.size + pair.instances.size);
    assert_true(is_at(pair.blas.handle, 0));
    assert_int_equal(fixture_counters().builds - before.builds, 1);
    fixture_trace(pair.tlas.handle, 0, 0);
    assert_int_equal(fixture_counters().builds - before.builds, 2);
}

/* However many updates nobody looked at, one is carried out. */
SILENT_TEST(test_updates)
{
    open_device_pair(UPDATABLE);
    const AssayCounters before = fixture_counters();
    for (int i = 0; i < 20; i++) {
        VkCommandBuffer commands = device_begin(PRIMARY);
        record_triangles(commands, (float)i, pair.blas.handle,
                         i ? pair.blas.handle : VK_NULL_HANDLE);
        device_finish(commands);
    }
    assert_true(is_at(pair.blas.handle, 19));
    const AssayCounters after = fixture_counters();
    assert_int_equal(after.builds - before.builds, 1);
    assert_int_equal(after.updates - before.updates, 1);
}

/* A TLAS is built over its BLAS as it was then, though that is rebuilt, or gone, before anybody
 * asks. */
SILENT_TEST(test_tlas_keeps_its_timestamp)
{
    open_device_pair(0);
    struct fixture_structure twin = fixture_create_for(&pair.instances);
    GET(host_build(&pair.triangles, pair.blas.handle, VK_NULL_HANDLE));
    GET(host_build(&pair.instances, twin.handle, VK_NULL_HANDLE));
    size_t twin_size, size;
    const void *twin_bytes = fixture_serialize(twin.handle, &twin_size);
    destroy((uint64_t)twin.handle);

    VkCommandBuffer commands = device_begin(PRIMARY);
    record_scene(commands);
    device_finish(commands);
    commands = device_begin(PRIMARY);
    record_triangles(commands, 100, pair.blas.handle, VK_NULL_HANDLE);
    device_finish(commands);
    destroy((uint64_t)pair.blas.handle);
    const void *bytes = fixture_serialize(pair.tlas.handle, &size);
    assert_int_equal(size, twin_size);
    assert_memory_equal(bytes, twin_bytes, size);
}

/* A command buffer that runs again overwrites the snapshots of its last run, which a clone still
 * needs. */
SILENT_TEST(test_resubmission)
{
    open_device_pair(0);
    struct fixture_structure clone = fixture_create_for(&pair.triangles);
    VkCommandBuffer build = device_begin(PRIMARY);
    record_blas(build);
    device_end(build);
    VkCommandBuffer copy = device_begin(PRIMARY);
    record_clone(copy, pair.blas.handle, clone.handle);
    device_end(copy);

    const AssayCounters before = fixture_counters();
    device_run(build);
    device_run(copy);
    fixture_move(&pair.triangles, 0, 7, 0);
    memcpy(on_device.triangles.staging.bytes, pair.triangles.data, pair.triangles.size);
    device_run(build);
    assert_int_equal(fixture_counters().builds, before.builds);
    assert_true(is_at(clone.handle, 0));
    assert_true(is_at(pair.blas.handle, 7));
}

SILENT_TEST(test_secondary)
{
    open_device_pair(0);
    VkCommandBuffer secondary = device_begin(SECONDARY);
    record_scene(secondary);
    device_end(secondary);
    VkCommandBuffer primary = device_begin(PRIMARY);
    vk.CmdExecuteCommands(primary, 1, &secondary);
    device_finish(primary);
    vk.FreeCommandBuffers(device, command_pool, 1, &secondary);
    assert_true(is_at(pair.blas.handle, 0));
    assert_true(fixture_trace(pair.tlas.handle, 2.25f, 0.25f).isHit);
}

/* Each execution copies to the same place. Only what is asked for is told, and only once. */
NOISY_TEST(test_executed_twice_at_once)
{
    open_device_pair(0);
    struct fixture_structure clone = fixture_create_for(&pair.triangles);
    VkCommandBuffer secondary = device_begin(SECONDARY);
    record_blas(secondary);
    device_end(secondary);
    VkCommandBuffer primary = device_begin(PRIMARY);
    vk.CmdExecuteCommands(primary, 1, &secondary);
    record_clone(primary, pair.blas.handle, clone.handle);
    vk.CmdExecuteCommands(primary, 1, &secondary);
    device_end(primary);
    for (int i = 0; i < 2; i++) {
        device_run(primary);
        assert_true(is_at(pair.blas.handle, 0));
        messages_expect_none(messages);
    }
    assert_true(is_at(clone.handle, 0));
    assert_int_equal(messages->count, 1);
    assert_non_null(strstr(messages->items[0].text, "what the last one copied"));
    device_run(primary);
    assert_true(is_at(clone.handle, 0));
    assert_int_equal(messages->count, 1);
}

SILENT_TEST(test_indirect)
{
    open_device_pair(0);
    enum { SKIPPED = 10, COUNT = 5 };
    const VkAccelerationStructureBuildRangeInfoKHR range = {
        .primitiveCount = COUNT, .primitiveOffset = SKIPPED * 9 * sizeof(float)};
    VkCommandBuffer commands = device_begin(PRIMARY);
    device_upload(commands, &on_device.triangles);
    on_device.triangles.info.dstAccelerationStructure = pair.blas.handle;
    device_build_indirect(commands, &on_device.triangles.info, TRIANGLES_OF_PAIR, &range);
    device_finish(commands);
    /* The ray begins at x = -1. */
    expect_hit_at(fixture_trace(pair.blas.handle, 0.25f, 0.25f), SKIPPED + 1, 0);
}

/* ---- pairs of scenes that differ in one thing, and all that counters say of the difference */

enum { TRIANGLES = 12, DATA_SIZE = TRIANGLES * 9 * sizeof(float) };

static const VkTransformMatrixKHR moved = {{{1, 0, 0, 0}, {0, 1, 0, 3}, {0, 0, 1, 0}}};

/* ---- a BLAS, and what its command buffer does */

struct deeds {
    bool transforms; /* its triangles */
    bool builds_twice, clones, compacts, is_traced, grazes_an_edge;
};

static AssayCounters run(const struct deeds *deeds)
{
    struct fixture_build host;
    struct device_build build;
    const AssayCounters before = fixture_counters();
    fixture_triangles(&host, TRIANGLES, COMPACTABLE);
    struct fixture_structure blas = fixture_create_for(&host);
    struct fixture_structure copy = fixture_create_blas(blas.size);
    struct device_buffer transform = device_buffer_create(sizeof(moved));
    device_build_create(&host, &build);
    memcpy(transform.bytes, &moved, sizeof(moved));
    if (deeds->transforms)
        build.geometry.geometry.triangles.transformData.deviceAddress = transform.address;

    VkCommandBuffer commands = device_begin(PRIMARY);
    device_upload(commands, &build);
    for (int i = 0; i < (deeds->builds_twice ? 2 : 1); i++)
        device_build(commands, &build, blas.handle, VK_NULL_HANDLE);
    if (deeds->clones || deeds->compacts)
        device_copy(commands, blas.handle, copy.handle, deeds->compacts ? COMPACT : CLONE);
    device_finish(commands);
    const float y = deeds->transforms ? 3 : 0;
    if (deeds->is_traced)
        fixture_trace(deeds->clones || deeds->compacts ? copy.handle : blas.handle,
                      y + (deeds->grazes_an_edge ? 0.5f : 0.25f),
                      deeds->grazes_an_edge ? 0.5f : 0.25f);
    const AssayCounters did = fixture_counters_since(&before);
    close_silent_test();
    return did;
}

/* `extra`: what the second scene does beyond the first. */
static void expect_difference(const struct deeds *plain, const struct deeds *with,
                              const AssayCounters *extra)
{
    const AssayCounters first = run(plain), second = run(with);
    const uint64_t *a = (const uint64_t *)&first, *b = (const uint64_t *)&second;
    for (size_t i = 0; i < sizeof(first) / sizeof(*a); i++)
        if (b[i] - a[i] != ((const uint64_t *)extra)[i])
            fail_msg("counter %zu: %llu and %llu", i, (unsigned long long)a[i],
                     (unsigned long long)b[i]);
}

/* ---- tests */

TEST(test_untouched)
{
    const AssayCounters did = run(&(struct deeds){0});
    const AssayCounters expected = {.bytesSnapshot = DATA_SIZE};
    assert_memory_equal(&did, &expected, sizeof(did));
}

TEST(test_transform)
{
    expect_difference(
        &(struct deeds){.is_traced = true}, &(struct deeds){.is_traced = true, .transforms = true},
        &(AssayCounters){.bytesSnapshot = sizeof(moved), .matrixProducts = 3 * TRIANGLES});
}

TEST(test_rebuild)
{
    expect_difference(&(struct deeds){.is_traced = true},
                      &(struct deeds){.is_traced = true, .builds_twice = true},
                      &(AssayCounters){.bytesSnapshot = DATA_SIZE});
}

/* An unchanged clone shares the tree of its source. */
TEST(test_clone)
{
    expect_difference(&(struct deeds){.is_traced = true},
                      &(struct deeds){.is_traced = true, .clones = true}, &(AssayCounters){0});
}

TEST(test_compaction)
{
    expect_difference(&(struct deeds){.clones = true}, &(struct deeds){.compacts = true},
                      &(AssayCounters){0});
    const AssayCounters did = run(&(struct deeds){.compacts = true, .is_traced = true});
    assert_int_equal(did.builds, 1);
    assert_int_equal(did.copies, 1);
}

TEST(test_exactness)
{
    const AssayCounters inside = run(&(struct deeds){.is_traced = true});
    const AssayCounters edge = run(&(struct deeds){.is_traced = true, .grazes_an_edge = true});
    assert_int_equal(inside.exactCalls, 0);
    assert_true(edge.exactCalls > 0);
}
