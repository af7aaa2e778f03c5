/* SPDX-License-Identifier: Apache-2.0 */
/* Only what a scene uses is computed: pairs of scenes that differ in one thing, and all that the
 * counters of backend cpu say of the difference. */
#include "device_fixture.h"

#include <string.h>

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

/* A clone that nobody changes is the same tree. */
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
