/* SPDX-License-Identifier: Apache-2.0 */
/* Query pools: ids that are never used twice, reused handles, and no memory. */
#include "src/state/commands/query_pools.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

static VkQueryPool handle(uintptr_t n)
{
    return (VkQueryPool)n;
}

static struct query_pools *make(void)
{
    struct query_pools *pools;
    assert_int_equal(query_pools_create(&pools), VK_SUCCESS);
    return pools;
}

#define COMPACTED_SIZE VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR
static void add(struct query_pools *pools, unsigned number, uint32_t count)
{
    const VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                        .queryType = COMPACTED_SIZE,
                                        .queryCount = count};
    query_pools_add(pools, handle(number), &info, true);
}

#define POOLS_TEST(name) TEST_WITH(name, struct query_pools *pools, make, query_pools_destroy)

POOLS_TEST(ids_are_of_one_query_alone)
{
    struct query_pool first, second, again;
    add(pools, 1, 3);
    add(pools, 2, 2);
    assert_true(query_pools_find(pools, handle(1), &first));
    assert_true(query_pools_find(pools, handle(2), &second));
    assert_int_equal(first.count, 3);
    assert_true(first.first_id > UINT64_MAX / 2);
    assert_true(second.first_id == first.first_id + 3);

    assert_true(query_pools_remove(pools, handle(1), &first));
    assert_false(query_pools_find(pools, handle(1), &first));
    assert_false(query_pools_remove(pools, handle(1), &first));
    add(pools, 1, 1);
    add(pools, 2, 1); /* its destruction was not seen */
    assert_true(query_pools_find(pools, handle(1), &again));
    assert_true(again.first_id == second.first_id + 2);
    assert_true(query_pools_find(pools, handle(2), &again));
    assert_true(again.first_id == second.first_id + 3);
}

POOLS_TEST(the_first_untouched_query_is_found)
{
    uint32_t number = 9;
    struct query_pool pool;
    add(pools, 1, 4);
    assert_true(query_pools_touch(pools, handle(1), 1, 1, &pool));
    assert_int_equal(pool.count, 4);
    assert_true(query_pools_find_untouched(pools, handle(1), 0, 2, &number));
    assert_int_equal(number, 0);
    assert_true(query_pools_find_untouched(pools, handle(1), 1, UINT32_MAX, &number));
    assert_int_equal(number, 2);
    assert_false(query_pools_find_untouched(pools, handle(1), 1, 1, &number));
    assert_false(query_pools_find_untouched(pools, handle(1), 0, 0, &number));
    assert_true(query_pools_touch(pools, handle(1), 2, UINT32_MAX, &pool));
    assert_false(query_pools_touch(pools, handle(2), 0, 1, &pool));
    assert_false(query_pools_find_untouched(pools, handle(1), 1, 4, &number));
    assert_false(query_pools_find_untouched(pools, handle(2), 0, 1, &number));
}

POOLS_TEST(what_else_may_touch_queries_is_not_known)
{
    uint32_t number;
    VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                  .queryType = VK_QUERY_TYPE_OCCLUSION,
                                  .queryCount = 1};
    query_pools_add(pools, handle(1), &info, false);
    info.queryType = COMPACTED_SIZE;
    info.flags = VK_QUERY_POOL_CREATE_RESET_BIT_KHR;
    query_pools_add(pools, handle(2), &info, true);
    assert_false(query_pools_find_untouched(pools, handle(1), 0, 1, &number));
    assert_false(query_pools_find_untouched(pools, handle(2), 0, 1, &number));
}

POOLS_TEST(what_is_not_there_is_not_known)
{
    struct query_pool pool = {.count = 4};
    assert_false(query_pools_find(pools, handle(1), &pool));
    assert_false(query_pools_remove(pools, handle(1), &pool));
    assert_int_equal(query_pool_clamp(&pool, 0, 4), 4);
    assert_int_equal(query_pool_clamp(&pool, 3, UINT32_MAX), 1);
    assert_int_equal(query_pool_clamp(&pool, 4, 1), 0);
    assert_int_equal(query_pool_clamp(&pool, UINT32_MAX, 1), 0);
    query_pools_destroy(NULL);
}

/* One of the allocations fails: of the record, of the table, of what was touched. */
POOLS_TEST(without_memory_nothing_is_known)
{
    struct query_pool pool;
    uint32_t number;
    static const int lefts[] = {0, 2, 1};
    for (int i = 0; i < 3; i++) {
        memory_fail_after(lefts[i]);
        add(pools, 1, 3);
        assert_true(memory_fail_no_more());
        assert_int_equal(query_pools_find(pools, handle(1), &pool), lefts[i] == 1);
        assert_false(query_pools_find_untouched(pools, handle(1), 0, 1, &number));
    }
    add(pools, 1, 3);
    assert_true(query_pools_find(pools, handle(1), &pool));
}
