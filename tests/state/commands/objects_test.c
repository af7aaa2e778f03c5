/* SPDX-License-Identifier: Apache-2.0 */
/* What no program shows: debug names and stacks of labels; query pools and deferred operations
 * whose handles are reused. */
#include <string.h>

#include "src/state/commands/deferred_operations.h"
#include "src/state/commands/object_names.h"
#include "src/state/commands/query_pools.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

/* ---- names */

TEST(types_without_messages_have_no_name)
{
    assert_null(object_type_name(VK_OBJECT_TYPE_IMAGE));
    assert_string_equal(object_type_name(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR),
                        "VkAccelerationStructureKHR");
}

TEST(names_are_cut_between_characters)
{
    static const struct {
        size_t size, length;
        const char *text;
    } rows[] = {{6, 4, "abcd"}, {5, 4, "abcd"}, {3, 2, "ab"}, {1, 0, ""}};
    char buffer[6];
    struct object_names *names;
    assert_int_equal(object_names_create(&names), VK_SUCCESS);
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 1, "abcd\xc3\xa9");
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        memcpy(buffer, "-----", 6);
        assert_int_equal(object_names_get(names, VK_OBJECT_TYPE_BUFFER, 1, buffer, rows[i].size),
                         rows[i].length);
        assert_string_equal(buffer, rows[i].text);
        memcpy(buffer, "-----", 6);
        assert_int_equal(
            object_names_try_get(names, VK_OBJECT_TYPE_BUFFER, 1, buffer, rows[i].size),
            rows[i].length);
        assert_string_equal(buffer, rows[i].text);
    }
    assert_int_equal(object_names_get(names, VK_OBJECT_TYPE_BUFFER, 1, NULL, 0), 0);
    assert_int_equal(object_names_try_get(names, VK_OBJECT_TYPE_BUFFER, 1, NULL, 0), 0);
    object_names_destroy(names);
}

/* ---- labels */

static void push(struct label_stack *stack, const char *name)
{
    label_stack_push(stack, &(VkDebugUtilsLabelEXT){.pLabelName = name, .color = {1, 0.5f, 0, 1}});
}

/* Also of labels for which there was no memory, and of those above them. */
TEST(each_pop_closes_its_own_label)
{
    const VkDebugUtilsLabelEXT inserted = {.pLabelName = "inserted"};
    struct label_stack stack = {0};
    push(&stack, "scene");
    label_stack_insert(&stack, &inserted);
    label_stack_pop(&stack);
    assert_int_equal(stack.count, 0);
    push(&stack, "frame");
    label_stack_push(&stack, NULL);
    label_stack_insert(&stack, &inserted);
    assert_int_equal(stack.count, 3);
    WITHOUT_MEMORY(push(&stack, "shadows")); /* takes the place of the inserted one */
    assert_int_equal(stack.count, 3);
    assert_string_equal(stack.labels[2].pLabelName, "");
    push(&stack, "lights");
    WITHOUT_MEMORY(push(&stack, "left out"));
    push(&stack, "above it");
    label_stack_insert(&stack, &inserted);
    assert_int_equal(stack.count, 4);
    assert_int_equal(stack.left_out, 2);

    struct label_stack copy = label_stack_copy(&stack);
    assert_int_equal(copy.count, 4);
    assert_string_equal(copy.labels[0].pLabelName, "frame");
    assert_true(copy.labels[0].color[1] == 0.5f);
    label_stack_clear(&copy);

    const uint32_t changes = stack.changes;
    for (int i = 0; i < 3; i++)
        label_stack_pop(&stack);
    assert_int_equal(stack.left_out, 0);
    assert_int_equal(stack.count, 3);
    assert_string_equal(stack.labels[2].pLabelName, "");
    label_stack_drop_all(&stack);
    assert_int_equal(stack.changes, changes + 4);
    assert_true(label_stack_is_clear(&stack));
}

/* ---- query pools */

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
    assert_true(query_pools_find_untouched(pools, handle(1), 1, UINT32_MAX, &number));
    assert_int_equal(number, 2);
    assert_false(query_pools_find_untouched(pools, handle(1), 1, 1, &number));
}

/* ---- deferred operations */

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

TEST(uncompleted_work_is_not_known_to_have_succeeded)
{
    struct deferred_operations *operations;
    struct work works[4] = {{0}};
    assert_int_equal(deferred_operations_create(&operations, end), VK_SUCCESS);
    for (uintptr_t n = 1; n <= 3; n++)
        deferred_operations_add(operations, operation(n));
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
