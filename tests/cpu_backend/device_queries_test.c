/* SPDX-License-Identifier: Apache-2.0 */
/* Queries about structures by command buffers on backend cpu, through the loader. */
#include <string.h>

#include "device_fixture.h"

#define NOT_READY(call) assert_int_equal(call, VK_NOT_READY)

SILENT_TEST(test_queries)
{
    open_queried_pair(COMPACTED_SIZE);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_blas(commands);
    record_queries(commands, COMPACTED_SIZE);
    device_finish(commands);

    const VkDeviceSize expected = fixture_property(pair.blas.handle, COMPACTED_SIZE);
    assert_in_range(expected, 1, pair.blas.size - 1);
    uint64_t wide[2][2];
    GET(vk.GetQueryPoolResults(device, on_device.pool, 0, 2, sizeof(wide), wide, sizeof(wide[0]),
                               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT |
                                   VK_QUERY_RESULT_WITH_AVAILABILITY_BIT));
    for (int i = 0; i < 2; i++) {
        assert_int_equal(wide[i][0], expected);
        assert_int_equal(wide[i][1], 1);
    }
    uint32_t narrow[QUERIES] = {7, 7, 7};
    NOT_READY(vk.GetQueryPoolResults(device, on_device.pool, 0, QUERIES, sizeof(narrow), narrow,
                                     sizeof(narrow[0]), 0));
    assert_int_equal(narrow[1], expected);
    assert_int_equal(narrow[2], 7);
    uint32_t partial[2] = {7, 7};
    NOT_READY(vk.GetQueryPoolResults(
        device, on_device.pool, 2, 1, sizeof(partial), partial, sizeof(partial),
        VK_QUERY_RESULT_PARTIAL_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT));
    assert_int_equal(partial[0], 0);
    assert_int_equal(partial[1], 0);
}

/* A query tells of the structure as it was when the query was written. */
SILENT_TEST(test_query_keeps_its_timestamp)
{
    open_queried_pair(SERIALIZATION_SIZE);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_blas(commands);
    record_queries(commands, SERIALIZATION_SIZE);
    pair.triangles.range.primitiveCount = 1;
    record_blas(commands);
    device_finish(commands);
    const uint64_t value = device_query(on_device.pool, 1);
    assert_in_range(value, fixture_property(pair.blas.handle, SERIALIZATION_SIZE) + 1, UINT64_MAX);
}

SILENT_TEST(test_other_queries)
{
    VkQueryPool pool = query_pool_create(&vk, device, VK_QUERY_TYPE_OCCLUSION, 1);
    OWN(DestroyQueryPool, pool);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdResetQueryPool(commands, pool, 0, 1);
    device_finish(commands);
    uint32_t value;
    NOT_READY(vk.GetQueryPoolResults(device, pool, 0, 1, sizeof(value), &value, sizeof(value), 0));
}

static const uint64_t untouched = ~0ull / 255 * 0xee;

/* Begins commands that write the queries, and fills a buffer for their results.
 */
static VkCommandBuffer begin_with_queries(struct device_buffer *buffer)
{
    open_queried_pair(COMPACTED_SIZE);
    *buffer = device_buffer_create(256);
    memset(buffer->bytes, 0xee, 256);
    VkCommandBuffer commands = device_begin(PRIMARY);
    record_blas(commands);
    record_queries(commands, COMPACTED_SIZE);
    return commands;
}

SILENT_TEST(test_copied_queries)
{
    struct device_buffer buffer;
    VkCommandBuffer commands = begin_with_queries(&buffer);
    vk.CmdCopyQueryPoolResults(commands, on_device.pool, 0, QUERIES, buffer.handle, 32, 32,
                               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    vk.CmdResetQueryPool(commands, on_device.pool, 0, QUERIES);
    device_finish(commands);
    const uint64_t expected = fixture_property(pair.blas.handle, COMPACTED_SIZE);
    const uint64_t *words = (uint64_t *)buffer.bytes;
    const uint64_t found[] = {words[4], words[5],  words[6], words[8],
                              words[9], words[12], words[13]};
    const uint64_t wanted[] = {expected, 1, untouched, expected, 1, untouched, 0};
    assert_memory_equal(found, wanted, sizeof(found));
}

/* Counts beyond the end of the pool mean no more than up to there, take no time, and nothing is
 * written for queries that there aren't. */
SILENT_TEST(test_wild_counts)
{
    struct device_buffer buffer;
    VkCommandBuffer commands = begin_with_queries(&buffer);
    vk.CmdCopyQueryPoolResults(commands, on_device.pool, 1, QUERIES, buffer.handle, 0, 8,
                               VK_QUERY_RESULT_64_BIT);
    vk.CmdResetQueryPool(commands, on_device.pool, 1, UINT32_MAX);
    device_finish(commands);
    const uint64_t expected = fixture_property(pair.blas.handle, COMPACTED_SIZE);
    const uint64_t wanted[] = {expected, untouched, untouched};
    assert_memory_equal(buffer.bytes, wanted, sizeof(wanted));
    uint64_t values[2] = {0};
    NOT_READY(vk.GetQueryPoolResults(device, on_device.pool, 0, 2, sizeof(values), values, 8,
                                     VK_QUERY_RESULT_64_BIT));
    assert_int_equal(values[0], expected);
    vk.ResetQueryPool(device, on_device.pool, 1, UINT32_MAX);
    GET(vk.GetQueryPoolResults(device, on_device.pool, 0, 1, sizeof(values), values, 8,
                               VK_QUERY_RESULT_64_BIT));
    vk.ResetQueryPool(device, on_device.pool, 0, UINT32_MAX);
    NOT_READY(vk.GetQueryPoolResults(device, on_device.pool, 0, 1, sizeof(values), values, 8,
                                     VK_QUERY_RESULT_64_BIT));
}
