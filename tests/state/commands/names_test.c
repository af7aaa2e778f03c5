/* SPDX-License-Identifier: Apache-2.0 */
/* Debug names of objects, and stacks of labels, against naive models. */
#include <stdio.h>
#include <string.h>

#include "src/state/commands/object_names.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/property.h"

/* ---- names belong to objects: handles are reused, and some names of destroyed objects are kept */

enum { HANDLES = 40, IDS = 4, TEXTS = 9, STEPS = 2000 };

/* Messages never name objects of the last one. */
static const VkObjectType types[] = {VK_OBJECT_TYPE_BUFFER, VK_OBJECT_TYPE_DEVICE_MEMORY,
                                     VK_OBJECT_TYPE_COMMAND_BUFFER, VK_OBJECT_TYPE_IMAGE};
enum { TYPES = sizeof(types) / sizeof(types[0]), UNNAMED = TYPES - 1 };

/* Texts 0 and 1 are none. */
static const char *const texts[TEXTS] = {NULL,      "",        "tree",     "chunk", "scratch",
                                         "frame 1", "frame 2", "vertices", "heap"};

struct named {
    uint32_t type, handle, text, id;
    bool is_old; /* a later object that had the handle is destroyed, too */
};

struct names {
    struct object_names *names;
    struct named live[TYPES][HANDLES], past[STEPS];
    uint32_t past_count;
};

static void names_begin(void *state)
{
    EXPECT_EQUAL(object_names_create(&((struct names *)state)->names), VK_SUCCESS);
}

static void names_end(void *state)
{
    object_names_destroy(((struct names *)state)->names);
    object_names_destroy(NULL);
}

static uint32_t text_of(const char *found)
{
    for (uint32_t i = 2; i < TEXTS; i++)
        if (strcmp(texts[i], found) == 0)
            return i;
    EXPECT(!found[0]);
    return 0;
}

static uint32_t get_live(const struct names *names, uint32_t type, uint32_t handle)
{
    char found[64], again[64];
    const size_t length = object_names_get(names->names, types[type], handle, found, sizeof(found));
    EXPECT_EQUAL(length, strlen(found));
    EXPECT_EQUAL(object_names_try_get(names->names, types[type], handle, again, sizeof(again)),
                 length);
    EXPECT(strcmp(found, again) == 0);
    return text_of(found);
}

/* Without memory, the object has no name. */
static void name_set(void *state, const uint32_t *operands)
{
    struct names *names = state;
    const uint32_t type = operands[0], handle = operands[1], id = operands[3];
    const bool has_name = type != UNNAMED && handle && operands[2] > 1;
    struct named *live = &names->live[type][handle];
    const bool failed = PROPERTY_CALL(
        object_names_set_of(names->names, types[type], handle, id, texts[operands[2]]));
    *live = (struct named){type, handle, has_name ? operands[2] : 0, id, false};
    if (failed && !get_live(names, type, handle))
        live->text = 0;
}

static void name_end(void *state, const uint32_t *operands)
{
    struct names *names = state;
    const uint32_t type = operands[0], handle = operands[1];
    struct named *live = &names->live[type][handle];
    object_names_end(names->names, types[type], handle, operands[2]);
    for (uint32_t i = 0; i < names->past_count; i++)
        names->past[i].is_old |= names->past[i].type == type && names->past[i].handle == handle;
    if (live->text) {
        live->id = operands[2] ? operands[2] : live->id;
        names->past[names->past_count++] = *live;
    }
    live->text = 0;
}

/* The last OBJECT_NAMES_PAST are kept. */
static uint32_t past_text(const struct names *names, uint32_t type, uint32_t handle, uint32_t id)
{
    for (uint32_t i = names->past_count, left = OBJECT_NAMES_PAST; i-- && left--;) {
        const struct named *past = &names->past[i];
        if (past->type == type && past->handle == handle && (id ? past->id == id : !past->is_old))
            return past->text;
    }
    return 0;
}

static void name_look(void *state, const uint32_t *operands)
{
    const struct names *names = state;
    const uint32_t type = operands[0], handle = operands[1], id = operands[2];
    const struct named *live = &names->live[type][handle];
    const uint32_t past = past_text(names, type, handle, id);
    char found[64];
    EXPECT_EQUAL(get_live(names, type, handle), live->text);
    object_names_get_past(names->names, types[type], handle, id, found, sizeof(found));
    EXPECT_EQUAL(text_of(found), past);
    object_names_get_of(names->names, types[type], handle, id, found, sizeof(found));
    EXPECT_EQUAL(text_of(found), live->text && live->id == id ? live->text : past);
}

PROPERTY_TEST(object_names, .size = sizeof(struct names), .begin = names_begin, .end = names_end,
              .operations = {{"set", name_set, {TYPES, HANDLES, TEXTS, IDS}, 40, .scarce = 8},
                             {"end", name_end, {TYPES, HANDLES, IDS}, 20},
                             {"look", name_look, {TYPES, HANDLES, IDS}, 40}},
              .sequences = 30, .steps = STEPS)

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
    object_names_set(names, types[0], 1, "abcd\xc3\xa9");
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        memcpy(buffer, "-----", 6);
        assert_int_equal(object_names_get(names, types[0], 1, buffer, rows[i].size),
                         rows[i].length);
        assert_string_equal(buffer, rows[i].text);
        memcpy(buffer, "-----", 6);
        assert_int_equal(object_names_try_get(names, types[0], 1, buffer, rows[i].size),
                         rows[i].length);
        assert_string_equal(buffer, rows[i].text);
    }
    assert_int_equal(object_names_get(names, types[0], 1, NULL, 0), 0);
    assert_int_equal(object_names_try_get(names, types[0], 1, NULL, 0), 0);
    object_names_destroy(names);
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

TEST(threads_share_names)
{
    struct object_names *names;
    assert_int_equal(object_names_create(&names), VK_SUCCESS);
    unit_test_run_threads(4, name_and_read, names, 0);
    object_names_destroy(names);
    WITHOUT_MEMORY(assert_int_equal(object_names_create(&names), VK_ERROR_OUT_OF_HOST_MEMORY));
}

/* ---- labels: each pop closes its own label, also if some were lost */

struct labels {
    struct label_stack stack;
    uint32_t names[STEPS], count, left_out, changes;
    bool inserted;
};

static void labels_begin_change(struct labels *labels)
{
    labels->count -= labels->inserted;
    labels->inserted = false;
    labels->changes++;
}

/* Name 0: no label. Name 1: a label without a name. */
static void label_add(struct labels *labels, uint32_t name, bool inserts)
{
    char copied[] = "name 0";
    const VkDebugUtilsLabelEXT label = {.pLabelName = name == 1 ? NULL : copied,
                                        .color = {1, 0.5f, 0, (float)name}};
    copied[5] = (char)('0' + name);
    labels_begin_change(labels);
    const bool failed =
        inserts ? PROPERTY_CALL(label_stack_insert(&labels->stack, name ? &label : NULL))
                : PROPERTY_CALL(label_stack_push(&labels->stack, name ? &label : NULL));
    if (labels->left_out || (failed && labels->stack.count == labels->count)) {
        labels->left_out += !inserts;
        return;
    }
    labels->names[labels->count++] = failed ? 1 : name;
    labels->inserted = inserts;
}

static void label_push_one(void *state, const uint32_t *operands)
{
    label_add(state, operands[0], false);
}

static void label_insert_one(void *state, const uint32_t *operands)
{
    label_add(state, operands[0], true);
}

static void label_pop_one(void *state, const uint32_t *operands)
{
    struct labels *labels = state;
    labels_begin_change(labels);
    label_stack_pop(&labels->stack);
    if (labels->left_out)
        labels->left_out--;
    else
        labels->count -= labels->count > 0;
}

static void label_drop_all(void *state, const uint32_t *operands)
{
    struct labels *labels = state;
    label_stack_drop_all(&labels->stack);
    labels->count = labels->left_out = 0;
    labels->inserted = false;
    labels->changes++;
}

static void expect_labels(const struct labels *labels, const struct label_stack *stack)
{
    EXPECT_EQUAL(stack->count, labels->count);
    for (uint32_t i = 0; i < stack->count; i++) {
        const uint32_t name = labels->names[i];
        const char expected[] = {'n', 'a', 'm', 'e', ' ', (char)('0' + name), '\0'};
        EXPECT_EQUAL(stack->labels[i].sType, VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT);
        EXPECT(strcmp(stack->labels[i].pLabelName, name > 1 ? expected : "") == 0);
        EXPECT(name < 2 || stack->labels[i].color[3] == (float)name);
    }
}

static void labels_check(void *state)
{
    const struct labels *labels = state;
    struct label_stack copy = label_stack_copy(&labels->stack);
    expect_labels(labels, &labels->stack);
    expect_labels(labels, &copy);
    label_stack_clear(&copy);
    EXPECT_EQUAL(labels->stack.left_out, labels->left_out);
    EXPECT_EQUAL(labels->stack.changes, labels->changes);
}

static void labels_end(void *state)
{
    struct label_stack *stack = &((struct labels *)state)->stack;
    label_stack_clear(stack);
    EXPECT(label_stack_is_clear(stack) && !stack->labels);
}

PROPERTY_TEST(label_stack, .size = sizeof(struct labels), .check = labels_check, .end = labels_end,
              .operations = {{"push", label_push_one, {9}, 20, .scarce = 6},
                             {"insert", label_insert_one, {9}, 8, .scarce = 6},
                             {"pop", label_pop_one, {0}, 20},
                             {"drop_all", label_drop_all, {0}, 1}},
              .sequences = 30, .steps = 400, .check_steps = 1)
