/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of sparse buffers: what is bound where, and for whom. */
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"

PAGES_TEST(test_a_range_bound_in_one_piece)
{
    assert_int_equal(backed(resources), NO);
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0x4000);
    assert_int_equal(backed(resources), YES);
    EXPECT_PIECES(pieces_of(resources, 1, PAGE, 7 * PAGE), {memory(1), 0x4100, 0x4700});
}

PAGES_TEST(test_a_range_bound_in_two_pieces)
{
    bind_sparse(resources, 1, 0, 4 * PAGE, 1, 0x4000);
    assert_int_equal(backed(resources), NO);
    bind_sparse(resources, 1, 4 * PAGE, 4 * PAGE, 2, 0x8000);
    assert_int_equal(backed(resources), YES);
    EXPECT_PIECES(pieces_of(resources, 1, PAGE, 7 * PAGE), {memory(1), 0x4100, 0x4400},
                  {memory(2), 0x8000, 0x8300});
}

PAGES_TEST(test_a_range_cut_out_of_the_middle)
{
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    bind_sparse(resources, 1, 3 * PAGE, PAGE, 2, 0x700);
    bind_sparse(resources, 1, 5 * PAGE, PAGE, 2, 0x200);
    EXPECT_PIECES(pieces_of(resources, 1, 0, 8 * PAGE), {memory(1), 0, 3 * PAGE},
                  {memory(2), 0x700, 0x800}, {memory(1), 4 * PAGE, 5 * PAGE},
                  {memory(2), 0x200, 0x300}, {memory(1), 6 * PAGE, 8 * PAGE});
    bind_sparse(resources, 1, 3 * PAGE, PAGE, 0, 0); /* unbinds */
    assert_int_equal(backed(resources), NO);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 4);
    bind_sparse(resources, 1, 0, 8 * PAGE, 0, 0);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
}

PAGES_TEST(test_memory_freed_leaves_a_hole)
{
    bind_sparse(resources, 1, 0, 4 * PAGE, 1, 0);
    bind_sparse(resources, 1, 4 * PAGE, 4 * PAGE, 2, 0);
    resources_remove_memory(resources, memory(1));
    assert_int_equal(backed(resources), NO);
    EXPECT_PIECES(pieces_of(resources, 1, 0, 8 * PAGE), {memory(2), 0, 4 * PAGE});
    have_memory(resources, 1); /* another one */
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 1);
}

PAGES_TEST(test_an_address_in_a_sparse_buffer_needs_no_memory)
{
    resources_set_address(resources, buffer(1), 0x100000);
    struct address_facts facts = address_facts(resources, 0x100010);
    assert_int_equal(facts.status, ADDRESS_IN_BUFFER);
    assert_int_equal(facts.bytes_left, PAGES * PAGE - 0x10);
    assert_int_equal(facts.begin, 0x10);
    assert_true(facts.is_sparse);
    assert_null(facts.memory);
}

PAGES_TEST(test_a_dead_buffer_backs_nothing)
{
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    resources_remove_buffer(resources, buffer(1));
    assert_int_equal(backed(resources), NO);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    bind_sparse(resources, 9, 0, 8 * PAGE, 1, 0);
}

PAGES_TEST(test_bindings_without_bytes_do_nothing)
{
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    bind_sparse(resources, 1, PAGE, 0, 2, 0);
    bind_sparse(resources, 1, PAGE, UINT64_MAX, 2, 0); /* wraps */
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 1);
    assert_int_equal(pieces_of(resources, 1, PAGE, PAGE).count, 0);
}

/* What was bound is not known, so nothing is said of any of it. */
PAGES_TEST(test_a_lost_binding_makes_all_unknown)
{
    WITHOUT_MEMORY(bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0));
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    assert_int_equal(backed(resources), UNKNOWN);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
}

/* ---- in the order of execution */

static struct sparse_binding announce(struct resources *resources, VkDeviceSize begin,
                                      VkDeviceSize size, unsigned memory_n)
{
    const VkSparseMemoryBind bind = {
        .resourceOffset = begin, .size = size, .memory = memory(memory_n)};
    return resources_announce_sparse(resources, buffer(1), &bind);
}

/* Executes a binding of pages 0 to 7 as the count-th batch of a queue, after some of queue 1. */
static void bind_after(struct resources *resources, unsigned memory_n, struct timestamp when,
                       uint64_t seen)
{
    struct sparse_binding binding = announce(resources, 0, 8 * PAGE, memory_n);
    const struct execution_clock follows = {.queues = 2, .counts = {0, seen}};
    resources_bind_sparse(resources, &binding, when, &follows);
    resources_settle_sparse(resources, &binding);
}

PAGES_TEST(test_who_does_not_follow_a_binding_does_not_know_it)
{
    const struct execution_clock before = {.queues = 2, .counts = {0, 1}};
    bind_after(resources, 1, (struct timestamp){1, 2}, 0);
    assert_int_equal(backed(resources), YES);
    assert_int_equal(backed_for(resources, &before), UNKNOWN);
    bind_after(resources, 0, (struct timestamp){1, 3}, 2);
    assert_int_equal(backed(resources), NO);
    assert_int_equal(backed_for(resources, &before), UNKNOWN);
}

PAGES_TEST(test_bindings_without_order_leave_open_which_came_last)
{
    bind_after(resources, 1, (struct timestamp){1, 1}, 0);
    bind_after(resources, 0, (struct timestamp){2, 1}, 0);
    const struct execution_clock all = {.queues = 3, .counts = {0, 1, 1}};
    assert_int_equal(backed_for(resources, &all), UNKNOWN);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
    bind_after(resources, 1, (struct timestamp){1, 2}, 1); /* nor does this one follow both */
    assert_int_equal(backed(resources), UNKNOWN);
}

PAGES_TEST(test_an_announced_binding_leaves_all_open)
{
    assert_int_equal(backed(resources), NO);
    struct sparse_binding binding = announce(resources, 20 * PAGE, PAGE, 1);
    assert_int_equal(backed(resources), UNKNOWN);
    resources_settle_sparse(resources, &binding); /* its call has failed */
    assert_int_equal(backed(resources), NO);
    binding = announce(resources, 0, PAGE, 1);
    resources_remove_buffer(resources, buffer(1));
    have_sparse_buffer(resources, 1, PAGES * PAGE); /* of the same handle */
    resources_bind_sparse(resources, &binding, (struct timestamp){1, 1}, &all_of_queue_1);
    resources_settle_sparse(resources, &binding);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
}

PAGES_TEST(test_memory_of_a_recycled_handle_is_not_what_was_bound)
{
    struct sparse_binding binding = announce(resources, 0, 8 * PAGE, 1);
    resources_remove_memory(resources, memory(1));
    have_memory(resources, 1);
    resources_bind_sparse(resources, &binding, (struct timestamp){1, 1}, &all_of_queue_1);
    resources_settle_sparse(resources, &binding);
    assert_int_equal(backed(resources), UNKNOWN);
}
