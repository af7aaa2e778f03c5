/* SPDX-License-Identifier: Apache-2.0 */
/* Sparse buffers: what is bound where, against a map of their pages; for whom; and what many pages
 * cost. */
#include <inttypes.h>

#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"
#include "tests/unit/property.h"
#include "tests/unit/steps.h"

/* ---- pages of buffer 1 */

struct pages {
    struct resources *resources;
    bool is_lost; /* a binding, for lack of memory: nothing is known of any page */
    struct {
        unsigned memory; /* 0: not bound */
        uint32_t page;
        unsigned life; /* of the memory, when bound */
    } pages[PAGES];
    unsigned lives[MEMORIES + 1];
};

static void pages_begin(void *state)
{
    ((struct pages *)state)->resources = a_structure_in_pages();
}

static void pages_end(void *state)
{
    resources_destroy(((struct pages *)state)->resources);
}

/* Memory 0 unbinds. */
static void pages_bind(void *state, const uint32_t *operands)
{
    struct pages *pages = state;
    const uint32_t first = operands[0], n = operands[2];
    const uint32_t count = operands[1] < PAGES - first ? operands[1] : PAGES - first;
    pages->is_lost |= PROPERTY_CALL(bind_sparse(pages->resources, 1, first * PAGE, count * PAGE, n,
                                                n ? operands[3] * PAGE : 0));
    for (uint32_t i = first; i < first + count; i++) {
        pages->pages[i].memory = n;
        pages->pages[i].page = operands[3] + i - first;
        pages->pages[i].life = pages->lives[n];
    }
}

/* The driver reuses the handle of freed memory. */
static void pages_free(void *state, const uint32_t *operands)
{
    struct pages *pages = state;
    const unsigned n = operands[0] + 1;
    resources_remove_memory(pages->resources, memory(n));
    have_memory(pages->resources, n);
    pages->lives[n]++;
}

static bool is_bound(const struct pages *pages, VkDeviceSize at)
{
    const unsigned n = pages->pages[at / PAGE].memory;
    return n && pages->pages[at / PAGE].life == pages->lives[n];
}

/* Every byte of the pieces is where the model has it, in order, and no bound byte is missing. */
static void pages_look(void *state, const uint32_t *operands)
{
    const struct pages *pages = state;
    const VkDeviceSize begin = operands[0],
                       end = begin + operands[1] % (PAGES * PAGE - operands[0]);
    const struct pieces found = pieces_of(pages->resources, 1, begin, end);
    VkDeviceSize at = begin;
    for (unsigned i = 0; i < found.count; i++) {
        const struct memory_span *span = &found.spans[i];
        while (at < end && !is_bound(pages, at))
            at = (at / PAGE + 1) * PAGE;
        for (VkDeviceSize byte = span->begin; byte < span->end; byte++, at++) {
            EXPECT(!pages->is_lost && at < end && is_bound(pages, at));
            EXPECT_SAME(span->memory, memory(pages->pages[at / PAGE].memory));
            EXPECT_EQUAL(byte, pages->pages[at / PAGE].page * PAGE + at % PAGE);
        }
    }
    for (; at < end && !pages->is_lost; at++)
        EXPECT(!is_bound(pages, at));
}

static void pages_check(void *state)
{
    struct pages *pages = state;
    bool all = true;
    for (uint32_t i = 1; i < 7; i++)
        all &= is_bound(pages, i * PAGE);
    EXPECT_EQUAL(backed(pages->resources), pages->is_lost ? UNKNOWN : all ? YES : NO);
}

PROPERTY_TEST(
    sparse_pages, .size = sizeof(struct pages), .begin = pages_begin, .check = pages_check,
    .end = pages_end,
    .operations = {{"bind", pages_bind, {PAGES, 20, MEMORIES + 1, 64}, 20, .scarce = 300},
                   {"free", pages_free, {MEMORIES}, 1},
                   {"look", pages_look, {PAGES * PAGE, PAGES *PAGE}, 20}},
    .sequences = 60, .steps = 120, .check_steps = 1,
    .cases = (const char *const[]){
        "bind 0 8 1 0; bind 3 1 2 7; bind 5 1 2 2; look 0 2048; bind 3 1 0 0; look 0 2048",
        "bind 0 8 1 0 !0; bind 0 8 1 0; look 0 2048", /* nothing is said of any page */
        NULL})

PAGES_TEST(bindings_without_bytes_do_nothing)
{
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    bind_sparse(resources, 1, PAGE, 0, 2, 0);
    bind_sparse(resources, 1, PAGE, UINT64_MAX, 2, 0); /* wraps */
    EXPECT_PIECES(pieces_of(resources, 1, 0, 8 * PAGE), {memory(1), 0, 8 * PAGE});
    assert_int_equal(pieces_of(resources, 1, PAGE, PAGE).count, 0);
}

PAGES_TEST(a_dead_buffer_backs_nothing)
{
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    resources_remove_buffer(resources, buffer(1));
    assert_int_equal(backed(resources), NO);
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
}

PAGES_TEST(an_address_in_a_sparse_buffer_needs_no_memory)
{
    const struct execution_clock nothing = {0};
    resources_set_address(resources, buffer(1), 0x100000);
    const struct address_facts facts = address_facts(resources, 0x100010);
    assert_int_equal(facts.status, ADDRESS_IN_BUFFER);
    assert_int_equal(facts.bytes_left, PAGES * PAGE - 0x10);
    assert_int_equal(facts.begin, 0x10);
    assert_true(facts.is_sparse);
    assert_null(facts.memory);

    /* All that a command reads is bound, or nothing can be read. */
    static const struct {
        uint64_t size, readable;
    } reads[] = {{0x800, 0x800}, {0x801, 0}};
    bind_sparse(resources, 1, 0, 0x800, 1, 0);
    for (int i = 0; i < 2; i++)
        assert_int_equal(
            resources_find_readable(resources, 0x100000, reads[i].size, &all_of_queue_1),
            reads[i].readable);
    assert_int_equal(resources_find_readable(resources, 0x100000, 0x800, &nothing), 0);
}

/* Binds page by page, as streaming does, looks at the last page each time, and unbinds all at once.
 */
static uint64_t steps_of_pages(uint32_t count)
{
    struct resources *resources = no_resources();
    uint64_t start = steps_so_far();
    have_memory(resources, 1);
    have_sparse_buffer(resources, 1, (VkDeviceSize)count * PAGE);
    for (uint32_t i = 0; i < count; i++) {
        bind_sparse(resources, 1, (VkDeviceSize)i * PAGE, PAGE, 1, (VkDeviceSize)(i ^ 1) * PAGE);
        VkDeviceSize begin = (VkDeviceSize)i * PAGE;
        assert_int_equal(pieces_of(resources, 1, begin, begin + PAGE).count, 1);
    }
    bind_sparse(resources, 1, 0, (VkDeviceSize)count * PAGE, 0, 0);
    resources_destroy(resources);
    return steps_so_far() - start;
}

TEST(many_pages_cost_no_square)
{
    uint64_t one = steps_of_pages(4000), ten = steps_of_pages(40000);
    print_message("4,000 pages take %" PRIu64 " steps, 40,000 %" PRIu64 "\n", one, ten);
    assert_true(one >= 4000);
    assert_true(ten <= 15 * one);
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

PAGES_TEST(who_does_not_follow_a_binding_does_not_know_it)
{
    const struct execution_clock before = {.queues = 2, .counts = {0, 1}};
    bind_after(resources, 1, (struct timestamp){1, 2}, 0);
    assert_int_equal(backed(resources), YES);
    assert_int_equal(backed_for(resources, &before), UNKNOWN);
    bind_after(resources, 0, (struct timestamp){1, 3}, 2);
    assert_int_equal(backed(resources), NO);
    assert_int_equal(backed_for(resources, &before), UNKNOWN);
}

PAGES_TEST(bindings_without_order_leave_open_which_came_last)
{
    bind_after(resources, 1, (struct timestamp){1, 1}, 0);
    bind_after(resources, 0, (struct timestamp){2, 1}, 0);
    const struct execution_clock all = {.queues = 3, .counts = {0, 1, 1}};
    assert_int_equal(backed_for(resources, &all), UNKNOWN);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
    bind_after(resources, 1, (struct timestamp){1, 2}, 1); /* nor does this one follow both */
    assert_int_equal(backed(resources), UNKNOWN);
}

PAGES_TEST(an_announced_binding_leaves_all_open)
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

PAGES_TEST(memory_of_a_recycled_handle_is_not_what_was_bound)
{
    struct sparse_binding binding = announce(resources, 0, 8 * PAGE, 1);
    resources_remove_memory(resources, memory(1));
    have_memory(resources, 1);
    resources_bind_sparse(resources, &binding, (struct timestamp){1, 1}, &all_of_queue_1);
    resources_settle_sparse(resources, &binding);
    assert_int_equal(backed(resources), UNKNOWN);
}
