/* SPDX-License-Identifier: Apache-2.0 */
/* Query pools: ids that are never used twice, reused handles, and no memory. */
#include "src/state/commands/query_pools.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/unit_test.h"

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
#define POOLS_TEST(name) TEST_WITH(name, struct query_pools *pools, make, query_pools_destroy)

POOLS_TEST(ids_are_of_one_query_alone)
{
    struct query_pool first, second, again;
    query_pools_add(pools, handle(1), COMPACTED_SIZE, 3);
    query_pools_add(pools, handle(2), COMPACTED_SIZE, 2);
    assert_true(query_pools_find(pools, handle(1), &first));
    assert_true(query_pools_find(pools, handle(2), &second));
    assert_int_equal(first.count, 3);
    assert_true(first.first_id > UINT64_MAX / 2);
    assert_true(second.first_id == first.first_id + 3);

    assert_true(query_pools_remove(pools, handle(1), &first));
    assert_false(query_pools_find(pools, handle(1), &first));
    assert_false(query_pools_remove(pools, handle(1), &first));
    query_pools_add(pools, handle(1), COMPACTED_SIZE, 1);
    query_pools_add(pools, handle(2), COMPACTED_SIZE, 1); /* its destruction was not seen */
    assert_true(query_pools_find(pools, handle(1), &again));
    assert_true(again.first_id == second.first_id + 2);
    assert_true(query_pools_find(pools, handle(2), &again));
    assert_true(again.first_id == second.first_id + 3);
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

POOLS_TEST(without_memory_a_pool_is_not_known)
{
    struct query_pool pool;
    for (int left = 0; left < 2; left++) {
        memory_fail_after(left);
        query_pools_add(pools, handle(1), COMPACTED_SIZE, 3);
        assert_true(memory_fail_no_more());
        assert_false(query_pools_find(pools, handle(1), &pool));
    }
    query_pools_add(pools, handle(1), COMPACTED_SIZE, 3);
    assert_true(query_pools_find(pools, handle(1), &pool));
}
