/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the table of command pools and command buffers. */
#include "tests/fixture/make.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"
#include "tests/unit/property.h"

COMMAND_BUFFERS_TEST(a_pool_resets_its_command_buffers)
{
    command_buffers_add_pool(all, pool(2), 0, VK_QUEUE_TRANSFER_BIT, true);
    add(all, 2, 4);
    for (unsigned n = 1; n <= 4; n++)
        begin(all, n);
    command_buffers_reset_pool(all, pool(1), false);
    for (unsigned n = 1; n <= 3; n++)
        assert_int_equal(facts_of(all, n).state, COMMAND_BUFFER_INITIAL);
    assert_int_equal(facts_of(all, 4).state, COMMAND_BUFFER_RECORDING);
    assert_int_equal(facts_of(all, 4).is_protected, YES);
    assert_int_equal(facts_of(all, 4).queue_flags, VK_QUEUE_TRANSFER_BIT);
    command_buffers_reset_pool(all, pool(2), true);
    assert_int_equal(facts_of(all, 4).state, COMMAND_BUFFER_INITIAL);
    command_buffers_reset_pool(all, pool(9), true);
}

static void note_gone(void *user, VkCommandBuffer gone)
{
    unsigned *seen = user;
    for (unsigned n = 1; n <= 4; n++)
        if (gone == handle(n))
            *seen |= 1u << n;
}

COMMAND_BUFFERS_TEST(freed_handles_come_again)
{
    begin(all, 1);
    const VkCommandBuffer freed[] = {handle(1), VK_NULL_HANDLE, handle(9)};
    command_buffers_remove(all, 3, freed);
    assert_int_equal(facts_of(all, 1).alive, NO);
    command_buffers_add_pool(all, pool(2), 0, VK_QUEUE_TRANSFER_BIT, false);
    add(all, 2, 1);
    assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_INITIAL);
    assert_int_equal(facts_of(all, 1).queue_flags, VK_QUEUE_TRANSFER_BIT);
    add(all, 1, 1); /* again, without having been freed: in another pool */
    assert_int_equal(facts_of(all, 1).queue_flags, VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT);
    command_buffers_add_pool(all, pool(1), 0, VK_QUEUE_COMPUTE_BIT, false); /* and a pool */
    assert_int_equal(facts_of(all, 1).alive, NO);
}

COMMAND_BUFFERS_TEST(what_is_not_known_changes_nothing)
{
    command_buffer_begin(NULL, &MAKE(VkCommandBufferBeginInfo), 0, VK_SUCCESS);
    command_buffer_end(NULL, VK_SUCCESS);
    command_buffer_reset(NULL, true, VK_SUCCESS);
    command_buffer_begin_rendering(NULL, 0);
    command_buffer_end_rendering(NULL);
    command_buffer_set_video_coding(NULL, true);
    command_buffer_execute(NULL, begin(all, 1));
    assert_int_equal(facts_of(all, 8).alive, NO);
    assert_int_equal(facts_of(all, 8).state, COMMAND_BUFFER_UNKNOWN);
}

/* ---- pools and command buffers that come and go; which are there is known from an array */

enum { POOLS = 5, BUFFERS = 60 };

struct pool_lives {
    struct command_buffers *all;
    unsigned pool_of[BUFFERS + 1];
    bool has_pool[POOLS + 1];
};

static void lives_begin(void *state)
{
    EXPECT(command_buffers_create(&((struct pool_lives *)state)->all) == VK_SUCCESS);
}

static void lives_end(void *state)
{
    command_buffers_destroy(((struct pool_lives *)state)->all);
    command_buffers_destroy(NULL);
}

static void pool_add(void *state, const uint32_t *operands)
{
    struct pool_lives *lives = state;
    const unsigned p = operands[0] + 1;
    if (!lives->has_pool[p])
        command_buffers_add_pool(lives->all, pool(p), 0, p, false);
    lives->has_pool[p] = true;
}

static void pool_remove(void *state, const uint32_t *operands)
{
    struct pool_lives *lives = state;
    const unsigned p = operands[0] + 1;
    unsigned seen = 0;
    command_buffers_remove_pool(lives->all, pool(p), note_gone, &seen);
    for (unsigned i = 1; i <= BUFFERS; i++) {
        EXPECT(i > 4 || (seen >> i & 1) == (lives->pool_of[i] == p));
        lives->pool_of[i] = lives->pool_of[i] == p ? 0 : lives->pool_of[i];
    }
    lives->has_pool[p] = false;
}

static void buffer_add(void *state, const uint32_t *operands)
{
    struct pool_lives *lives = state;
    const unsigned p = operands[0] + 1, n = operands[1] + 1;
    if (!lives->has_pool[p])
        return;
    add(lives->all, p, n);
    begin(lives->all, n);
    lives->pool_of[n] = p;
}

static void buffer_remove(void *state, const uint32_t *operands)
{
    struct pool_lives *lives = state;
    take_away(lives->all, operands[0] + 1);
    lives->pool_of[operands[0] + 1] = 0;
}

static void lives_check(void *state)
{
    const struct pool_lives *lives = state;
    for (unsigned n = 1; n <= BUFFERS; n++) {
        EXPECT_EQUAL(facts_of(lives->all, n).alive, lives->pool_of[n] ? YES : NO);
        EXPECT_EQUAL(facts_of(lives->all, n).queue_flags, lives->pool_of[n]);
    }
}

PROPERTY_TEST(command_buffers, .size = sizeof(struct pool_lives), .begin = lives_begin,
              .check = lives_check, .end = lives_end,
              .operations = {{"pool_add", pool_add, {POOLS}, 2},
                             {"pool_remove", pool_remove, {POOLS}, 1},
                             {"add", buffer_add, {POOLS, BUFFERS}, 25},
                             {"remove", buffer_remove, {BUFFERS}, 12}},
              .sequences = 10, .steps = 500, .check_steps = 3)

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

/* A secondary whose record was lost is no reason to call its primary invalid. */
COMMAND_BUFFERS_TEST(a_lost_secondary_invalidates_nothing)
{
    WITHOUT_MEMORY(add(all, 1, 4));
    command_buffer_execute(begin(all, 1), command_buffers_find(all, handle(4)));
    take_away(all, 4);
    assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_RECORDING);

    struct command_buffer *primary = begin(all, 1), *secondary = begin(all, 3);
    /* No memory for what the secondary would tell its primary by. */
    WITHOUT_MEMORY(command_buffer_execute(primary, secondary));
    take_away(all, 3);
    assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_RECORDING);
}

TEST(a_table_needs_memory)
{
    struct command_buffers *all;
    WITHOUT_MEMORY(assert_int_equal(command_buffers_create(&all), VK_ERROR_OUT_OF_HOST_MEMORY));
    assert_null(all);
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
