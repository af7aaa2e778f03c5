/* SPDX-License-Identifier: Apache-2.0 */
/* Names belong to objects: handles are reused, and some names of destroyed objects are kept. */
#include "src/state/commands/object_names.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

enum { HANDLE = 0x10 };
static const VkObjectType type = VK_OBJECT_TYPE_BUFFER;

static struct object_names *names;

static void open_names(void)
{
    assert_int_equal(object_names_create(&names), VK_SUCCESS);
}

static void close_names(void)
{
    object_names_destroy(names);
}

static void name_and_destroy(uint64_t handle, uint64_t id, const char *name)
{
    object_names_set(names, type, handle, name);
    object_names_end(names, type, handle, id);
}

static void expect_name(uint64_t handle, const char *name)
{
    char found[64];
    object_names_get(names, type, handle, found, sizeof(found));
    assert_string_equal(found, name);
}

static void expect_past_name(uint64_t handle, uint64_t id, const char *name)
{
    char found[64];
    object_names_get_past(names, type, handle, id, found, sizeof(found));
    assert_string_equal(found, name);
}

TEST_BETWEEN(a_destroyed_object_keeps_its_name, open_names, close_names)
{
    name_and_destroy(HANDLE, 1, "tree");
    expect_name(HANDLE, "");
    expect_past_name(HANDLE, 1, "tree");
    object_names_set(names, type, HANDLE, "chunk");
    expect_name(HANDLE, "chunk");
    expect_past_name(HANDLE, 1, "tree");
    expect_past_name(HANDLE, 0, "tree");
    expect_past_name(HANDLE, 2, "");
}

TEST_BETWEEN(the_last_object_of_a_handle_counts, open_names, close_names)
{
    name_and_destroy(HANDLE, 1, "tree");
    name_and_destroy(HANDLE, 2, "chunk");
    expect_past_name(HANDLE, 0, "chunk");
    expect_past_name(HANDLE, 1, "tree");
    object_names_end(names, type, HANDLE, 3); /* has no name */
    expect_past_name(HANDLE, 0, "");
    expect_past_name(HANDLE, 3, "");
    expect_past_name(HANDLE, 2, "chunk");
}

static void expect_name_of(uint64_t id, const char *name)
{
    char found[64];
    object_names_get_of(names, VK_OBJECT_TYPE_COMMAND_BUFFER, HANDLE, id, found, sizeof(found));
    assert_string_equal(found, name);
}

TEST_BETWEEN(a_name_is_of_the_object_with_the_id, open_names, close_names)
{
    object_names_set_of(names, VK_OBJECT_TYPE_COMMAND_BUFFER, HANDLE, 1, "frame 1");
    expect_name_of(1, "frame 1");
    object_names_end(names, VK_OBJECT_TYPE_COMMAND_BUFFER, HANDLE, 0);
    object_names_end(names, VK_OBJECT_TYPE_COMMAND_BUFFER, HANDLE, 0); /* 2, without a name */
    object_names_set_of(names, VK_OBJECT_TYPE_COMMAND_BUFFER, HANDLE, 3, "frame 3");
    expect_name_of(1, "frame 1");
    expect_name_of(2, "");
    expect_name_of(3, "frame 3");
}

TEST_BETWEEN(objects_of_other_types_have_the_handle, open_names, close_names)
{
    object_names_set(names, VK_OBJECT_TYPE_QUEUE, HANDLE, "queue");
    name_and_destroy(HANDLE, 1, "tree");
    object_names_end(names, VK_OBJECT_TYPE_QUEUE, HANDLE, 0);
    expect_past_name(HANDLE, 0, "tree");
}

TEST_BETWEEN(old_names_are_forgotten, open_names, close_names)
{
    for (uint64_t i = 0; i <= OBJECT_NAMES_PAST; i++)
        name_and_destroy(HANDLE + i % 3, i + 1, "tree");
    expect_past_name(HANDLE, 1, "");
    expect_past_name(HANDLE + 1, 2, "tree");
    expect_past_name(HANDLE + OBJECT_NAMES_PAST % 3, OBJECT_NAMES_PAST + 1, "tree");
}

TEST_BETWEEN(without_memory_an_object_has_no_name, open_names, close_names)
{
    WITHOUT_MEMORY(object_names_set(names, type, HANDLE, "tree"));
    object_names_end(names, type, HANDLE, 1);
    expect_past_name(HANDLE, 1, "");
}
