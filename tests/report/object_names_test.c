/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of debug names and of label stacks. */
#include "hearing.h"

/* ---- names */

static const char *name_of(const struct object_names *names, VkObjectType type, uint64_t handle)
{
    static char buffer[64];
    size_t length = object_names_get(names, type, handle, buffer, sizeof(buffer));
    assert_int_equal(length, strlen(buffer));
    return buffer;
}

TEST(test_names_are_by_type_and_handle)
{
    struct object_names *names = names_create();
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 1, "vertices");
    object_names_set(names, VK_OBJECT_TYPE_DEVICE_MEMORY, 1, "heap");
    object_names_set(names, VK_OBJECT_TYPE_COMMAND_BUFFER, 1, "frame");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_BUFFER, 1), "vertices");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_DEVICE_MEMORY, 1), "heap");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_COMMAND_BUFFER, 1), "frame");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_BUFFER, 2), "");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_DEVICE, 1), "");

    object_names_set(names, VK_OBJECT_TYPE_DEVICE_MEMORY, 1, "pool");
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 1, NULL);
    object_names_set(names, VK_OBJECT_TYPE_COMMAND_BUFFER, 1, "");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_DEVICE_MEMORY, 1), "pool");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_BUFFER, 1), "");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_COMMAND_BUFFER, 1), "");
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 7, NULL); /* never had one */
    object_names_destroy(names);
}

TEST(test_types_without_messages_have_no_names)
{
    struct object_names *names = names_create();
    object_names_set(names, VK_OBJECT_TYPE_IMAGE, 1, "picture");
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 0, "null");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_IMAGE, 1), "");
    assert_string_equal(name_of(names, VK_OBJECT_TYPE_BUFFER, 0), "");
    assert_null(object_type_name(VK_OBJECT_TYPE_IMAGE));
    assert_string_equal(object_type_name(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR),
                        "VkAccelerationStructureKHR");
    object_names_destroy(names);
    object_names_destroy(NULL);
}

TEST(test_names_are_cut_between_characters)
{
    char buffer[6] = "-----";
    struct object_names *names = names_create();
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 1, "abcd\xc3\xa9");
    assert_int_equal(object_names_get(names, VK_OBJECT_TYPE_BUFFER, 1, buffer, 6), 4);
    assert_string_equal(buffer, "abcd");
    assert_int_equal(object_names_get(names, VK_OBJECT_TYPE_BUFFER, 1, buffer, 1), 0);
    assert_string_equal(buffer, "");
    assert_int_equal(object_names_get(names, VK_OBJECT_TYPE_BUFFER, 1, NULL, 0), 0);
    memcpy(buffer, "-----", 6);
    assert_int_equal(object_names_try_get(names, VK_OBJECT_TYPE_BUFFER, 1, buffer, 6), 4);
    assert_string_equal(buffer, "abcd");
    assert_int_equal(object_names_try_get(names, VK_OBJECT_TYPE_BUFFER, 1, NULL, 0), 0);
    object_names_destroy(names);
}

TEST(test_many_names)
{
    enum { COUNT = 5000 };
    char name[32];
    struct object_names *names = names_create();
    for (unsigned i = 1; i <= COUNT; i++) {
        snprintf(name, sizeof(name), "buffer %u", i);
        object_names_set(names, VK_OBJECT_TYPE_BUFFER, i, name);
        object_names_set(names, VK_OBJECT_TYPE_DEVICE_MEMORY, i, "memory");
    }
    for (unsigned i = 1; i <= COUNT; i += 2)
        object_names_set(names, VK_OBJECT_TYPE_BUFFER, i, NULL);
    for (unsigned i = 1; i <= COUNT; i++) {
        snprintf(name, sizeof(name), "buffer %u", i);
        assert_string_equal(name_of(names, VK_OBJECT_TYPE_BUFFER, i), i % 2 ? "" : name);
        assert_string_equal(name_of(names, VK_OBJECT_TYPE_DEVICE_MEMORY, i), "memory");
    }
    object_names_destroy(names);
}

/* Each object has the name that it was given last, or none. */
TEST(test_names_without_memory)
{
    for (int count = 0; memory_is_scarce(count); count++) {
        struct object_names *names = NULL;
        VkResult result = object_names_create(&names);
        for (unsigned i = 1; names && i <= 200; i++) {
            object_names_set(names, VK_OBJECT_TYPE_BUFFER, i, "old");
            object_names_set(names, VK_OBJECT_TYPE_DEVICE_MEMORY, i, "other");
            object_names_set(names, VK_OBJECT_TYPE_BUFFER, i, "new");
            if (i % 3 == 0)
                object_names_set(names, VK_OBJECT_TYPE_DEVICE_MEMORY, i, NULL);
        }
        const bool failed = memory_fail_no_more();
        assert_int_equal(result, names ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY);
        for (unsigned i = 1; names && i <= 200; i++) {
            const char *name = name_of(names, VK_OBJECT_TYPE_BUFFER, i);
            assert_true(strcmp(name, "new") == 0 || (failed && strcmp(name, "") == 0));
        }
        object_names_destroy(names);
    }
}

static void *name_and_read(void *context)
{
    struct object_names *names = context;
    char buffer[32];
    for (unsigned i = 0; i < 3000; i++) {
        uint64_t handle = i % 17 + 1;
        object_names_set(names, VK_OBJECT_TYPE_BUFFER, handle, i % 3 ? "name" : NULL);
        object_names_get(names, VK_OBJECT_TYPE_BUFFER, handle, buffer, sizeof(buffer));
        assert_true(!buffer[0] || strcmp(buffer, "name") == 0);
    }
    return NULL;
}

TEST(test_names_on_many_threads)
{
    struct object_names *names = names_create();
    unit_test_run_threads(4, name_and_read, names, 0);
    object_names_destroy(names);
}

/* ---- labels */

static void push(struct label_stack *stack, const char *name)
{
    label_stack_push(stack, &(VkDebugUtilsLabelEXT){.pLabelName = name, .color = {1, 0.5f, 0, 1}});
}

static void insert(struct label_stack *stack, const char *name)
{
    label_stack_insert(stack, &(VkDebugUtilsLabelEXT){.pLabelName = name});
}

/* The labels as a path. */
static void assert_labels(const struct label_stack *stack, const char *expected)
{
    char path[256] = "";
    for (uint32_t i = 0; i < stack->count; i++) {
        strcat(path, i ? ">" : "");
        strcat(path, stack->labels[i].pLabelName);
    }
    assert_string_equal(path, expected);
}

TEST(test_labels_nest)
{
    struct label_stack stack = {0};
    char name[] = "frame";
    push(&stack, name);
    name[0] = 'X'; /* it is a copy */
    push(&stack, "BLAS");
    assert_labels(&stack, "frame>BLAS");
    assert_int_equal(stack.labels[1].sType, VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT);
    assert_true(stack.labels[1].color[1] == 0.5f);
    label_stack_pop(&stack);
    push(&stack, "TLAS");
    assert_labels(&stack, "frame>TLAS");
    label_stack_pop(&stack);
    label_stack_pop(&stack);
    label_stack_pop(&stack); /* opened in another command buffer */
    assert_labels(&stack, "");
    for (unsigned i = 0; i < 20; i++)
        push(&stack, "x");
    assert_int_equal(stack.count, 20);
    label_stack_clear(&stack);
    assert_int_equal(stack.count, 0);
    assert_null(stack.labels);
}

TEST(test_an_inserted_label_stands_until_the_next)
{
    struct label_stack stack = {0};
    push(&stack, "frame");
    insert(&stack, "here");
    assert_labels(&stack, "frame>here");
    insert(&stack, "there");
    assert_labels(&stack, "frame>there");
    push(&stack, "BLAS");
    assert_labels(&stack, "frame>BLAS");
    insert(&stack, "inside");
    label_stack_pop(&stack);
    assert_labels(&stack, "frame");
    insert(&stack, "end");
    label_stack_clear(&stack);
    insert(&stack, "alone");
    assert_labels(&stack, "alone");
    label_stack_clear(&stack);
}

TEST(test_labels_may_be_null)
{
    struct label_stack stack = {0};
    label_stack_push(&stack, NULL);
    push(&stack, NULL);
    insert(&stack, NULL);
    assert_labels(&stack, ">>");
    label_stack_pop(&stack);
    label_stack_pop(&stack);
    assert_labels(&stack, "");
    label_stack_clear(&stack);
}

/* Whatever is lost, every pop closes its own label. */
TEST(test_labels_without_memory)
{
    for (int count = 0; memory_is_scarce(count); count++) {
        struct label_stack stack = {0};
        push(&stack, "a");
        uint32_t before = stack.count;
        for (unsigned i = 0; i < 6; i++)
            push(&stack, "b");
        insert(&stack, "c");
        for (unsigned i = 0; i < 6; i++)
            label_stack_pop(&stack);
        memory_fail_no_more();
        assert_int_equal(stack.count, before);
        label_stack_pop(&stack);
        assert_int_equal(stack.count, 0);
        assert_int_equal(stack.left_out, 0);
        label_stack_clear(&stack);
    }
}
