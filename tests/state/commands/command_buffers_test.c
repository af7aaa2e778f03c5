/* SPDX-License-Identifier: Apache-2.0 */
/* Command pools and command buffers: which are there, and what no rule about them sees of
 * recording. */
#include <string.h>

#include "src/state/commands/bound_shaders.h"
#include "src/state/commands/command_buffers.h"
#include "src/state/commands/label_stack.h"
#include "tests/fixture/make.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

static VkCommandPool pool(unsigned n)
{
    return (VkCommandPool)(uintptr_t)(0x1000 + n);
}

static VkCommandBuffer handle(unsigned n)
{
    return (VkCommandBuffer)(uintptr_t)(0x2000 + n);
}

/* Pool 1 of a graphics and compute family, with primary 1 and 2 and secondary 3. */
static struct command_buffers *some_command_buffers(void)
{
    const VkCommandBuffer primaries[] = {handle(1), handle(2)}, secondary = handle(3);
    struct command_buffers *all = NULL;
    assert_int_equal(command_buffers_create(&all), VK_SUCCESS);
    command_buffers_add_pool(all, pool(1), 0, VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT, false);
    command_buffers_add(all, pool(1), VK_COMMAND_BUFFER_LEVEL_PRIMARY, 2, primaries);
    command_buffers_add(all, pool(1), VK_COMMAND_BUFFER_LEVEL_SECONDARY, 1, &secondary);
    return all;
}

#define COMMAND_BUFFERS_TEST(name)                                                                 \
    TEST_WITH(name, struct command_buffers *all, some_command_buffers, command_buffers_destroy)

static void add(struct command_buffers *all, unsigned pool_n, unsigned n)
{
    const VkCommandBuffer added = handle(n);
    command_buffers_add(all, pool(pool_n), VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &added);
}

static void take_away(struct command_buffers *all, unsigned n)
{
    const VkCommandBuffer removed = handle(n);
    command_buffers_remove(all, 1, &removed);
}

static struct command_buffer_facts facts_of(struct command_buffers *all, unsigned n)
{
    struct command_buffer_facts facts;
    command_buffers_facts(all, command_buffers_find(all, handle(n)), handle(n), &facts);
    return facts;
}

static struct command_buffer *begin(struct command_buffers *all, unsigned n)
{
    struct command_buffer *begun = command_buffers_find(all, handle(n));
    command_buffer_begin(begun, &MAKE(VkCommandBufferBeginInfo), 0, VK_SUCCESS);
    return begun;
}

/* ---- pools and command buffers that come and go */

static void note_gone(void *user, VkCommandBuffer gone)
{
    unsigned *seen = user;
    for (unsigned n = 1; n <= 9; n++)
        if (gone == handle(n))
            *seen |= 1u << n;
}

/* Removes a pool, and returns a bit for each command buffer that goes with it. */
static unsigned remove_pool(struct command_buffers *all, unsigned pool_n)
{
    unsigned seen = 0;
    command_buffers_remove_pool(all, pool(pool_n), note_gone, &seen);
    return seen;
}

/* Each digit is the pool of a command buffer, from number 1 on; 0: there is no such one. */
static void expect_pools(struct command_buffers *all, const char *pools)
{
    for (unsigned n = 1; n <= strlen(pools); n++) {
        const unsigned pool_n = (unsigned)(pools[n - 1] - '0');
        assert_int_equal(facts_of(all, n).alive, pool_n ? YES : NO);
        assert_int_equal(facts_of(all, n).queue_flags, pool_n);
    }
}

TEST(pools_take_their_command_buffers_along)
{
    struct command_buffers *all = NULL;
    assert_int_equal(command_buffers_create(&all), VK_SUCCESS);
    for (unsigned i = 1; i <= 3; i++)
        command_buffers_add_pool(all, pool(i), 0, i, false);
    for (unsigned n = 1; n <= 9; n++) {
        add(all, (n - 1) % 3 + 1, n);
        begin(all, n);
    }
    expect_pools(all, "123123123");
    take_away(all, 7); /* the last one of a pool, one in the middle, the first, and none */
    take_away(all, 5);
    take_away(all, 3);
    take_away(all, 12);
    expect_pools(all, "120103023");
    add(all, 2, 4); /* its end was not seen */
    add(all, 3, 3);
    expect_pools(all, "123203023");
    take_away(all, 3); /* it was in the middle of its pool before, and is the last one now */
    assert_int_equal(remove_pool(all, 2), 1 << 2 | 1 << 4 | 1 << 8);
    assert_int_equal(remove_pool(all, 2), 0);
    expect_pools(all, "100003003");
    command_buffers_add_pool(all, pool(2), 0, 2, false);
    add(all, 2, 5);
    assert_int_equal(remove_pool(all, 3), 1 << 6 | 1 << 9);
    expect_pools(all, "100020000");
    command_buffers_destroy(all);
    command_buffers_destroy(NULL);
}

COMMAND_BUFFERS_TEST(what_was_lost_is_unknown)
{
    WITHOUT_MEMORY(add(all, 1, 4));
    assert_int_equal(facts_of(all, 4).alive, UNKNOWN);
    assert_int_equal(facts_of(all, 9).alive, UNKNOWN);
    assert_int_equal(facts_of(all, 4).state, COMMAND_BUFFER_UNKNOWN);
    assert_int_equal(facts_of(all, 4).queue_flags, 0);
    assert_int_equal(facts_of(all, 1).alive, YES);
}

COMMAND_BUFFERS_TEST(the_command_buffers_of_a_lost_pool_are_unknown)
{
    WITHOUT_MEMORY(command_buffers_add_pool(all, pool(2), 0, VK_QUEUE_TRANSFER_BIT, false));
    add(all, 2, 4);
    assert_int_equal(facts_of(all, 4).alive, UNKNOWN);
    /* A successor. */
    WITHOUT_MEMORY(command_buffers_add_pool(all, pool(1), 0, VK_QUEUE_TRANSFER_BIT, false));
    assert_int_equal(facts_of(all, 1).alive, UNKNOWN);
}

/* What was found last in one table is not what another one has by that handle. */
TEST(tables_have_their_own)
{
    struct command_buffers *one = some_command_buffers(), *other = some_command_buffers();
    struct command_buffer *of_one = command_buffers_find(one, handle(1));
    struct command_buffer *of_other = command_buffers_find(other, handle(1));
    assert_ptr_not_equal(of_one, of_other);
    assert_ptr_equal(command_buffers_find(one, handle(1)), of_one);
    command_buffers_destroy(other);
    other = some_command_buffers();
    assert_ptr_equal(command_buffers_find(one, handle(1)), of_one);
    take_away(one, 1);
    assert_null(command_buffers_find(one, handle(1)));
    assert_non_null(command_buffers_find(other, handle(1)));
    command_buffers_destroy(one);
    command_buffers_destroy(other);
}

/* ---- recording */

COMMAND_BUFFERS_TEST(an_incomplete_secondary_makes_its_primary_incomplete)
{
    struct command_buffer *first = begin(all, 1), *secondary = begin(all, 3);
    unknown_set(&secondary->journal->unknown, UNKNOWN_COMMANDS);
    command_buffer_execute(first, secondary);
    assert_true(unknown_is_set(&first->journal->unknown));
}

/* One secondary in every frame: what it remembers doesn't grow with them. */
COMMAND_BUFFERS_TEST(a_secondary_remembers_only_those_that_still_execute_it)
{
    struct command_buffer *secondary = begin(all, 3);
    for (int frame = 0; frame < 100; frame++) {
        struct command_buffer *primary = begin(all, 1);
        for (int i = 0; i < 3; i++)
            command_buffer_execute(primary, secondary);
        assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_RECORDING);
    }
    assert_true(secondary->dependents.capacity <= 8);
    command_buffer_execute(begin(all, 2), secondary);
    begin(all, 3);
    assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_INVALID);
    assert_int_equal(facts_of(all, 2).state, COMMAND_BUFFER_INVALID);
    assert_int_equal(secondary->dependents.count, 0);
}

/* They outlive the queue's: this program fails if memory is left. */
TEST(submissions_have_the_labels_of_their_queue)
{
    struct queue_labels *labels;
    assert_int_equal(queue_labels_create(&labels), VK_SUCCESS);
    queue_labels_push(labels, (VkQueue)1, &(VkDebugUtilsLabelEXT){.pLabelName = "frame"});
    const struct submission_origin origin = queue_labels_submit(labels, (VkQueue)1);
    assert_int_equal(origin.number, 1);
    queue_labels_destroy(labels);
    assert_string_equal(origin.labels->stack.labels[0].pLabelName, "frame");
    shared_labels_release(origin.labels);
    queue_labels_destroy(NULL);
}

static void nothing(struct journal_walk *walk, const struct journal_entry *entry)
{
    (void)walk;
    (void)entry;
}

/* What the lists of kinds in journal.h must have follows from journal_entries.def. */
TEST(readers_of_writes_and_uses_get_all_kinds_of_them)
{
    static const struct journal_events writes = {ON_WRITES(nothing)}, uses = {ON_USES(nothing)};
    for (int kind = 0; kind < JOURNAL_KINDS; kind++) {
        const struct journal_entry entry = {.kind = (unsigned char)kind};
        assert_int_equal(writes.of_kind[kind] != NULL, journal_entry_writes(&entry));
        assert_int_equal(uses.of_kind[kind] != NULL, journal_entry_use(&entry) != NO_USE);
    }
}

TEST(each_stage_and_each_set_belongs_to_one_bind_point)
{
    static const VkShaderStageFlags of[SHADER_POINTS] = {
        [SHADERS_OF_COMPUTE] = VK_SHADER_STAGE_COMPUTE_BIT,
        [SHADERS_OF_RAYS] = VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_ANY_HIT_BIT_KHR |
                            VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR | VK_SHADER_STAGE_MISS_BIT_KHR |
                            VK_SHADER_STAGE_INTERSECTION_BIT_KHR | VK_SHADER_STAGE_CALLABLE_BIT_KHR,
        [SHADERS_OF_GRAPHICS] = VK_SHADER_STAGE_ALL_GRAPHICS | VK_SHADER_STAGE_TASK_BIT_EXT |
                                VK_SHADER_STAGE_MESH_BIT_EXT,
    };
    for (int point = 0; point < SHADER_POINTS; point++)
        for (uint32_t bit = 0; bit < 31; bit++)
            assert_int_equal(shader_point_has((enum shader_point)point, 1u << bit),
                             of[point] >> bit & 1);
    assert_int_equal(shader_stages_of(VK_PIPELINE_BIND_POINT_COMPUTE), of[SHADERS_OF_COMPUTE]);
    assert_int_equal(shader_stages_of(VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR), of[SHADERS_OF_RAYS]);
    assert_int_equal(shader_stages_of(VK_PIPELINE_BIND_POINT_GRAPHICS), of[SHADERS_OF_GRAPHICS]);
    assert_int_equal(shader_stages_of(VK_PIPELINE_BIND_POINT_MAX_ENUM), 0);
    struct bound_shaders bound = {.sets = {{0}}};
    bound_shaders_bind_set(&bound, SHADERS_OF_COMPUTE, BOUND_SETS, 1); /* more than are tracked */
    assert_int_equal(bound.sets[SHADERS_OF_RAYS][0], 0);
}
