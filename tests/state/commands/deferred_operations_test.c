/* SPDX-License-Identifier: Apache-2.0 */
/* Deferred operations: work that ends once, with the result of its own operation; reused handles,
 * and no memory. */
#include "src/state/commands/deferred_operations.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

struct work {
    uint32_t ends;
    VkResult result;
};

static VkDeferredOperationKHR handle(uintptr_t n)
{
    return (VkDeferredOperationKHR)n;
}

static void end(void *work, VkResult result)
{
    struct work *ended = work;
    ended->ends++;
    ended->result = result;
}

static struct deferred_operations *make(void)
{
    struct deferred_operations *operations;
    assert_int_equal(deferred_operations_create(&operations, end), VK_SUCCESS);
    deferred_operations_add(operations, handle(1));
    return operations;
}

TEST(work_ends_when_its_operation_completes)
{
    struct deferred_operations *operations = make();
    struct work work = {0};
    assert_int_equal(deferred_operations_ticket(operations, handle(1)), 0);
    assert_true(deferred_operations_defer(operations, handle(1), &work));
    const uint64_t first = deferred_operations_ticket(operations, handle(1));
    assert_true(deferred_operations_complete(operations, handle(1), first, VK_SUCCESS));
    assert_int_equal(work.ends, 1);
    assert_int_equal(work.result, VK_SUCCESS);
    assert_int_equal(deferred_operations_ticket(operations, handle(1)), 0);

    /* A query before the second began has returned the first. */
    assert_true(deferred_operations_defer(operations, handle(1), &work));
    const uint64_t second = deferred_operations_ticket(operations, handle(1));
    assert_false(deferred_operations_complete(operations, handle(1), first, VK_SUCCESS));
    assert_false(deferred_operations_complete(operations, handle(1), 0, VK_SUCCESS));
    assert_int_equal(work.ends, 1);
    assert_true(
        deferred_operations_complete(operations, handle(1), second, VK_ERROR_OUT_OF_HOST_MEMORY));
    assert_int_equal(work.result, VK_ERROR_OUT_OF_HOST_MEMORY);
    deferred_operations_destroy(operations);
    assert_int_equal(work.ends, 2);
}

TEST(uncompleted_work_is_not_known_to_have_succeeded)
{
    struct deferred_operations *operations = make();
    struct work works[4] = {{0}};
    deferred_operations_add(operations, handle(2));
    deferred_operations_add(operations, handle(3));
    assert_true(deferred_operations_defer(operations, handle(1), &works[0]));
    assert_true(deferred_operations_defer(operations, handle(1), &works[1]));
    assert_true(deferred_operations_defer(operations, handle(2), &works[2]));
    assert_true(deferred_operations_defer(operations, handle(3), &works[3]));
    assert_int_equal(works[0].ends, 1); /* as its operation has other work now */
    deferred_operations_remove(operations, handle(1));
    assert_int_equal(works[1].ends, 1);
    deferred_operations_add(operations, handle(2)); /* the driver reuses the handle */
    assert_int_equal(works[2].ends, 1);
    assert_int_equal(deferred_operations_ticket(operations, handle(2)), 0);
    deferred_operations_destroy(operations);
    for (uint32_t i = 0; i < 4; i++) {
        assert_int_equal(works[i].ends, 1);
        assert_int_equal(works[i].result, VK_ERROR_UNKNOWN);
    }
}

TEST(only_what_was_created_is_there)
{
    struct deferred_operations *operations = make();
    struct work work = {0};
    assert_int_equal(deferred_operations_has(operations, handle(1)), YES);
    assert_int_equal(deferred_operations_has(operations, handle(2)), NO);
    assert_false(deferred_operations_defer(operations, handle(2), &work));
    assert_false(deferred_operations_complete(operations, handle(2), 1, VK_SUCCESS));
    deferred_operations_remove(operations, handle(2));
    deferred_operations_remove(operations, handle(1));
    assert_int_equal(deferred_operations_has(operations, handle(1)), NO);
    deferred_operations_destroy(operations);
    deferred_operations_destroy(NULL);
    assert_int_equal(work.ends, 0);
}

TEST(without_memory_nothing_is_known)
{
    struct deferred_operations *operations = make();
    for (int i = 0; i < 2; i++) {
        WITHOUT_MEMORY(deferred_operations_add(operations, handle(2)));
        assert_int_equal(deferred_operations_has(operations, handle(2)), UNKNOWN);
        assert_int_equal(deferred_operations_has(operations, handle(1)), YES);
    }
    deferred_operations_destroy(operations);
    WITHOUT_MEMORY(assert_int_equal(deferred_operations_create(&operations, end),
                                    VK_ERROR_OUT_OF_HOST_MEMORY));
}
