/* SPDX-License-Identifier: Apache-2.0 */
/* What is known of query pools, deferred operations and events. */
#include "src/state/commands/deferred_operations.h"
#include "src/state/commands/events.h"
#include "src/state/commands/query_pools.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

/* ---- query pools: ids that are never used twice, reused handles, and no memory */

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

/* ---- deferred operations: work that ends once, with the result of its own operation; reused
 * handles, and no memory */

struct work {
    uint32_t ends;
    VkResult result;
};

static VkDeferredOperationKHR operation(uintptr_t n)
{
    return (VkDeferredOperationKHR)n;
}

static void end(void *work, VkResult result)
{
    struct work *ended = work;
    ended->ends++;
    ended->result = result;
}

static struct deferred_operations *make_operations(void)
{
    struct deferred_operations *operations;
    assert_int_equal(deferred_operations_create(&operations, end), VK_SUCCESS);
    deferred_operations_add(operations, operation(1));
    return operations;
}

TEST(work_ends_when_its_operation_completes)
{
    struct deferred_operations *operations = make_operations();
    struct work work = {0};
    assert_int_equal(deferred_operations_ticket(operations, operation(1)), 0);
    assert_true(deferred_operations_defer(operations, operation(1), &work));
    const uint64_t first = deferred_operations_ticket(operations, operation(1));
    assert_true(deferred_operations_complete(operations, operation(1), first, VK_SUCCESS));
    assert_int_equal(work.ends, 1);
    assert_int_equal(work.result, VK_SUCCESS);
    assert_int_equal(deferred_operations_ticket(operations, operation(1)), 0);

    /* A query before the second began has returned the first. */
    assert_true(deferred_operations_defer(operations, operation(1), &work));
    const uint64_t second = deferred_operations_ticket(operations, operation(1));
    assert_false(deferred_operations_complete(operations, operation(1), first, VK_SUCCESS));
    assert_false(deferred_operations_complete(operations, operation(1), 0, VK_SUCCESS));
    assert_int_equal(work.ends, 1);
    assert_true(deferred_operations_complete(operations, operation(1), second,
                                             VK_ERROR_OUT_OF_HOST_MEMORY));
    assert_int_equal(work.result, VK_ERROR_OUT_OF_HOST_MEMORY);
    deferred_operations_destroy(operations);
    assert_int_equal(work.ends, 2);
}

TEST(uncompleted_work_is_not_known_to_have_succeeded)
{
    struct deferred_operations *operations = make_operations();
    struct work works[4] = {{0}};
    deferred_operations_add(operations, operation(2));
    deferred_operations_add(operations, operation(3));
    assert_true(deferred_operations_defer(operations, operation(1), &works[0]));
    assert_true(deferred_operations_defer(operations, operation(1), &works[1]));
    assert_true(deferred_operations_defer(operations, operation(2), &works[2]));
    assert_true(deferred_operations_defer(operations, operation(3), &works[3]));
    assert_int_equal(works[0].ends, 1); /* as its operation has other work now */
    deferred_operations_remove(operations, operation(1));
    assert_int_equal(works[1].ends, 1);
    deferred_operations_add(operations, operation(2)); /* the driver reuses the handle */
    assert_int_equal(works[2].ends, 1);
    assert_int_equal(deferred_operations_ticket(operations, operation(2)), 0);
    deferred_operations_destroy(operations);
    for (uint32_t i = 0; i < 4; i++) {
        assert_int_equal(works[i].ends, 1);
        assert_int_equal(works[i].result, VK_ERROR_UNKNOWN);
    }
}

TEST(only_what_was_created_is_there)
{
    struct deferred_operations *operations = make_operations();
    struct work work = {0};
    assert_int_equal(deferred_operations_has(operations, operation(1)), YES);
    assert_int_equal(deferred_operations_has(operations, operation(2)), NO);
    assert_false(deferred_operations_defer(operations, operation(2), &work));
    assert_false(deferred_operations_complete(operations, operation(2), 1, VK_SUCCESS));
    deferred_operations_remove(operations, operation(2));
    deferred_operations_remove(operations, operation(1));
    assert_int_equal(deferred_operations_has(operations, operation(1)), NO);
    deferred_operations_destroy(operations);
    deferred_operations_destroy(NULL);
    assert_int_equal(work.ends, 0);
}

TEST(operations_without_memory_are_unknown)
{
    struct deferred_operations *operations = make_operations();
    for (int i = 0; i < 2; i++) {
        WITHOUT_MEMORY(deferred_operations_add(operations, operation(2)));
        assert_int_equal(deferred_operations_has(operations, operation(2)), UNKNOWN);
        assert_int_equal(deferred_operations_has(operations, operation(1)), YES);
    }
    deferred_operations_destroy(operations);
    WITHOUT_MEMORY(assert_int_equal(deferred_operations_create(&operations, end),
                                    VK_ERROR_OUT_OF_HOST_MEMORY));
}

/* ---- events of a device: they are freed with it, whether they were removed or not */

TEST(events_are_freed)
{
    struct events *events;
    const int before = allocations_now();
    assert_int_equal(events_create(&events), VK_SUCCESS);
    for (uintptr_t n = 1; n < 100; n++) {
        events_add(events, (VkEvent)n, n % 2);
        events_set(events, (VkEvent)n);
        if (n % 3 == 0)
            events_remove(events, (VkEvent)n);
    }
    events_destroy(events);
    assert_int_equal(allocations_now(), before);
    events_destroy(NULL);
}
