/* SPDX-License-Identifier: Apache-2.0 */
/* Debug names of objects and stacks of labels: what no program shows. */
#include <string.h>

#include "src/state/commands/object_names.h"
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
