/* SPDX-License-Identifier: Apache-2.0 */
/* Handles made of numbers, and resources, filled and asked in one line each. */
#ifndef ASSAY_TESTS_STATE_FIXTURE_H
#define ASSAY_TESTS_STATE_FIXTURE_H

#include "src/state/resources/resources.h"
#include "tests/fixture/make.h"
#include "tests/unit/unit_test.h"

/* The n-th handle of a type; 0 is none. */
static inline VkDeviceMemory memory(unsigned n)
{
    return (VkDeviceMemory)(uintptr_t)(n ? 0x100 + n : 0);
}

static inline VkBuffer buffer(unsigned n)
{
    return (VkBuffer)(uintptr_t)(n ? 0x200 + n : 0);
}

static inline VkAccelerationStructureKHR accel(unsigned n)
{
    return (VkAccelerationStructureKHR)(uintptr_t)(n ? 0x300 + n : 0);
}

/* ---- resources; functions take numbers of handles */

static inline struct resources *no_resources(void)
{
    struct resources *resources = NULL;
    assert_int_equal(resources_create(&resources), VK_SUCCESS);
    return resources;
}

/* A test of `resources` without anything in them. */
#define RESOURCES_TEST(name)                                                                       \
    TEST_WITH(name, struct resources *resources, no_resources, resources_destroy)

static inline void have_memory(struct resources *resources, unsigned n)
{
    resources_add_memory(resources, memory(n), 1 << 20, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
                         false);
}

/* `usage` 0: VK_BUFFER_USAGE_STORAGE_BUFFER_BIT. */
static inline void have_buffer(struct resources *resources, unsigned n, VkDeviceSize size,
                               VkBufferUsageFlags usage)
{
    const STRUCT(VkBufferCreateInfo, create_info, .size = size,
                 .usage = usage ? usage : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    resources_add_buffer(resources, buffer(n), &create_info);
}

static inline void have_bound_buffer(struct resources *resources, unsigned n, VkDeviceSize size,
                                     VkBufferUsageFlags usage, unsigned memory_n,
                                     VkDeviceSize offset)
{
    have_buffer(resources, n, size, usage);
    resources_bind_buffer(resources, buffer(n), memory(memory_n), offset, false);
}

static inline void have_accel(struct resources *resources, unsigned n, unsigned buffer_n,
                              VkDeviceSize offset, VkDeviceSize size)
{
    const STRUCT(VkAccelerationStructureCreateInfoKHR, create_info, .buffer = buffer(buffer_n),
                 .offset = offset, .size = size,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    resources_add_accel(resources, accel(n), &create_info);
}

/* Executed on queue 1. */
static const struct execution_clock all_of_queue_1 = {.queues = 2, .counts = {0, UINT64_MAX}};

/* ---- pieces of memory, as they are visited */

struct pieces {
    struct memory_span spans[64];
    unsigned count;
};

/* Adds one; `user` is struct pieces. */
static inline void note_piece(void *user, const struct memory_span *piece)
{
    struct pieces *pieces = user;
    assert_true(pieces->count < 64);
    pieces->spans[pieces->count++] = *piece;
}

/* Expects pieces, each a memory and a range of it: EXPECT_PIECES(pieces, {memory(1), 0, 16}). */
#define EXPECT_PIECES(pieces, ...)                                                                 \
    expect_pieces(pieces, (const struct memory_span[]){__VA_ARGS__},                               \
                  sizeof((const struct memory_span[]){__VA_ARGS__}) / sizeof(struct memory_span))

static inline void expect_pieces(struct pieces pieces, const struct memory_span *spans,
                                 unsigned count)
{
    assert_int_equal(pieces.count, count);
    for (unsigned i = 0; i < count; i++) {
        assert_ptr_equal(pieces.spans[i].memory, spans[i].memory);
        assert_int_equal(pieces.spans[i].begin, spans[i].begin);
        assert_int_equal(pieces.spans[i].end, spans[i].end);
    }
}

#endif
