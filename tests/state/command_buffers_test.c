/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the table of command pools and command buffers. */
#include "random.h"
#include "tests/fixture/make.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/command_fixture.h"

COMMAND_BUFFERS_TEST(test_a_pool_resets_its_command_buffers)
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

COMMAND_BUFFERS_TEST(test_a_pool_takes_its_command_buffers_along)
{
    unsigned seen = 0;
    command_buffers_add_pool(all, pool(2), 0, VK_QUEUE_COMPUTE_BIT, false);
    add(all, 2, 4);
    take_away(all, 2);
    command_buffers_remove_pool(all, pool(1), note_gone, &seen);
    assert_int_equal(seen, 1u << 1 | 1u << 3);
    for (unsigned n = 1; n <= 3; n++) {
        assert_null(command_buffers_find(all, handle(n)));
        assert_int_equal(facts_of(all, n).alive, NO);
        assert_null(command_buffers_labels(all, handle(n)));
    }
    assert_int_equal(facts_of(all, 4).alive, YES);
    command_buffers_remove_pool(all, pool(1), note_gone, &seen);
    command_buffers_remove_pool(all, VK_NULL_HANDLE, note_gone, &seen);
}

COMMAND_BUFFERS_TEST(test_freed_handles_come_again)
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

COMMAND_BUFFERS_TEST(test_what_is_not_known_changes_nothing)
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

/* Pools and command buffers come and go at random; which are there is known from an array. */
TEST(test_random_lives)
{
    enum { POOLS = 5, BUFFERS = 60 };
    struct random random = random_of("command_buffers");
    struct command_buffers *all;
    unsigned pool_of[BUFFERS + 1] = {0}, seen;
    bool has_pool[POOLS + 1] = {false};
    assert_int_equal(command_buffers_create(&all), VK_SUCCESS);
    for (int step = 0; step < 5000; step++) {
        unsigned p = 1 + random_below(&random, POOLS), n = 1 + random_below(&random, BUFFERS);
        uint32_t what = random_below(&random, 40);
        if (what == 0) {
            command_buffers_remove_pool(all, pool(p), note_gone, &seen);
            for (unsigned i = 1; i <= BUFFERS; i++)
                pool_of[i] = pool_of[i] == p ? 0 : pool_of[i];
            has_pool[p] = false;
        } else if (what < 3 && !has_pool[p]) {
            command_buffers_add_pool(all, pool(p), 0, p, false);
            has_pool[p] = true;
        } else if (what < 15) {
            take_away(all, n);
            pool_of[n] = 0;
        } else if (has_pool[p]) {
            add(all, p, n);
            begin(all, n);
            pool_of[n] = p;
        }
        n = 1 + random_below(&random, BUFFERS);
        assert_int_equal(facts_of(all, n).alive, pool_of[n] ? YES : NO);
        assert_int_equal(facts_of(all, n).queue_flags, pool_of[n]);
    }
    command_buffers_destroy(all);
}

COMMAND_BUFFERS_TEST(test_what_was_lost_is_unknown)
{
    WITHOUT_MEMORY(add(all, 1, 4));
    assert_int_equal(facts_of(all, 4).alive, UNKNOWN);
    assert_int_equal(facts_of(all, 9).alive, UNKNOWN);
    assert_int_equal(facts_of(all, 4).state, COMMAND_BUFFER_UNKNOWN);
    assert_int_equal(facts_of(all, 4).queue_flags, 0);
    assert_int_equal(facts_of(all, 1).alive, YES);
}

COMMAND_BUFFERS_TEST(test_the_command_buffers_of_a_lost_pool_are_unknown)
{
    WITHOUT_MEMORY(command_buffers_add_pool(all, pool(2), 0, VK_QUEUE_TRANSFER_BIT, false));
    add(all, 2, 4);
    assert_int_equal(facts_of(all, 4).alive, UNKNOWN);
    /* A successor. */
    WITHOUT_MEMORY(command_buffers_add_pool(all, pool(1), 0, VK_QUEUE_TRANSFER_BIT, false));
    assert_int_equal(facts_of(all, 1).alive, UNKNOWN);
}

/* A secondary whose record was lost is no reason to call its primary invalid. */
COMMAND_BUFFERS_TEST(test_a_lost_secondary_invalidates_nothing)
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

TEST(test_a_table_needs_memory)
{
    struct command_buffers *all;
    WITHOUT_MEMORY(assert_int_equal(command_buffers_create(&all), VK_ERROR_OUT_OF_HOST_MEMORY));
    assert_null(all);
}

/* What was found last in one table is not what another one has by that handle. */
TEST(test_tables_have_their_own)
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
