/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of sparse buffers: what is bound where, against a map of their pages. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#include "../report/scarce_memory.h"
#include "random.h"
#include "things.h"

enum { PAGE = 0x100, PAGES = 48, MEMORIES = 4 };

/* Pieces as they are visited. */
struct pieces {
    struct memory_span spans[64];
    unsigned count;
};

static void note_piece(void *user, const struct memory_span *piece)
{
    struct pieces *pieces = user;
    assert_true(pieces->count < 64);
    pieces->spans[pieces->count++] = *piece;
}

static struct pieces pieces_of(struct resources *resources, unsigned n, VkDeviceSize begin,
                               VkDeviceSize end)
{
    struct pieces pieces = {.count = 0};
    resources_find_pieces(resources, buffer(n), begin, end, note_piece, &pieces);
    return pieces;
}

/* A sparse buffer 1 with structure 1 over its pages 1 to 6, and memories. */
static struct resources *a_structure_in_pages(void)
{
    struct resources *resources = no_resources();
    for (unsigned n = 1; n <= MEMORIES; n++)
        have_memory(resources, n);
    have_sparse_buffer(resources, 1, PAGES * PAGE);
    have_accel(resources, 1, 1, PAGE, 6 * PAGE);
    return resources;
}

static enum tristate backed(struct resources *resources)
{
    struct accel_facts facts = accel_facts(resources, 1);
    assert_no_span(&facts.span);
    assert_true(facts.in_pieces ==
                (resources_find_id(resources, RESOURCE_ACCEL, (uint64_t)(uintptr_t)accel(1)) &&
                 facts.backed != NO));
    return facts.backed;
}

static void test_a_range_bound_in_one_piece(void **state)
{
    (void)state;
    struct resources *resources = a_structure_in_pages();
    assert_int_equal(backed(resources), UNKNOWN);
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0x4000);
    assert_int_equal(backed(resources), YES);
    struct pieces pieces = pieces_of(resources, 1, PAGE, 7 * PAGE);
    assert_int_equal(pieces.count, 1);
    assert_span(&pieces.spans[0], 1, 0x4100, 0x4700);
    resources_destroy(resources);
}

static void test_a_range_bound_in_two_pieces(void **state)
{
    (void)state;
    struct resources *resources = a_structure_in_pages();
    bind_sparse(resources, 1, 0, 4 * PAGE, 1, 0x4000);
    assert_int_equal(backed(resources), UNKNOWN);
    bind_sparse(resources, 1, 4 * PAGE, 4 * PAGE, 2, 0x8000);
    assert_int_equal(backed(resources), YES);
    struct pieces pieces = pieces_of(resources, 1, PAGE, 7 * PAGE);
    assert_int_equal(pieces.count, 2);
    assert_span(&pieces.spans[0], 1, 0x4100, 0x4400);
    assert_span(&pieces.spans[1], 2, 0x8000, 0x8300);
    resources_destroy(resources);
}

static void test_a_range_cut_out_of_the_middle(void **state)
{
    (void)state;
    struct resources *resources = a_structure_in_pages();
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    bind_sparse(resources, 1, 3 * PAGE, PAGE, 2, 0x700);
    struct pieces pieces = pieces_of(resources, 1, 0, 8 * PAGE);
    assert_int_equal(pieces.count, 3);
    assert_span(&pieces.spans[0], 1, 0, 3 * PAGE);
    assert_span(&pieces.spans[1], 2, 0x700, 0x800);
    assert_span(&pieces.spans[2], 1, 4 * PAGE, 8 * PAGE);
    bind_sparse(resources, 1, 3 * PAGE, PAGE, 0, 0); /* unbinds */
    assert_int_equal(backed(resources), UNKNOWN);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 2);
    bind_sparse(resources, 1, 0, 8 * PAGE, 0, 0);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
    resources_destroy(resources);
}

static void test_memory_freed_leaves_a_hole(void **state)
{
    (void)state;
    struct resources *resources = a_structure_in_pages();
    bind_sparse(resources, 1, 0, 4 * PAGE, 1, 0);
    bind_sparse(resources, 1, 4 * PAGE, 4 * PAGE, 2, 0);
    resources_remove_memory(resources, memory(1));
    assert_int_equal(backed(resources), UNKNOWN);
    struct pieces pieces = pieces_of(resources, 1, 0, 8 * PAGE);
    assert_int_equal(pieces.count, 1);
    assert_span(&pieces.spans[0], 2, 0, 4 * PAGE);
    have_memory(resources, 1); /* another one */
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 1);
    resources_destroy(resources);
}

static void test_an_address_in_a_sparse_buffer_needs_no_memory(void **state)
{
    (void)state;
    struct resources *resources = a_structure_in_pages();
    resources_set_address(resources, buffer(1), 0x100000);
    struct address_facts facts = address_facts(resources, 0x100010);
    assert_int_equal(facts.status, ADDRESS_IN_BUFFER);
    assert_int_equal(facts.bytes_left, PAGES * PAGE - 0x10);
    assert_int_equal(facts.buffer_offset, 0x10);
    assert_true(facts.in_pieces);
    assert_no_span(&facts.span);
    resources_destroy(resources);
}

static void test_a_dead_buffer_backs_nothing(void **state)
{
    (void)state;
    struct resources *resources = a_structure_in_pages();
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    resources_remove_buffer(resources, buffer(1));
    assert_int_equal(backed(resources), NO);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    bind_sparse(resources, 9, 0, 8 * PAGE, 1, 0);
    resources_destroy(resources);
}

static void test_bindings_without_bytes_do_nothing(void **state)
{
    (void)state;
    struct resources *resources = a_structure_in_pages();
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    bind_sparse(resources, 1, PAGE, 0, 2, 0);
    bind_sparse(resources, 1, PAGE, UINT64_MAX, 2, 0); /* wraps */
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 1);
    assert_int_equal(pieces_of(resources, 1, PAGE, PAGE).count, 0);
    resources_destroy(resources);
}

/* What was bound is not known, so nothing is said of any of it. */
static void test_a_lost_binding_makes_all_unknown(void **state)
{
    (void)state;
    struct resources *resources = a_structure_in_pages();
    memory_fail_after(0);
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    assert_true(memory_fail_no_more());
    bind_sparse(resources, 1, 0, 8 * PAGE, 1, 0);
    assert_int_equal(backed(resources), UNKNOWN);
    assert_int_equal(pieces_of(resources, 1, 0, 8 * PAGE).count, 0);
    resources_destroy(resources);
}

/* ---- against a map of pages */

struct model {
    struct {
        unsigned memory; /* 0: not bound */
        uint32_t page;
        unsigned life; /* of the memory, when bound */
    } pages[PAGES];
    unsigned lives[MEMORIES + 1];
};

static void bind_randomly(struct random *random, struct resources *resources, struct model *model)
{
    uint32_t first = random_below(random, PAGES);
    uint32_t count = 1 + random_below(random, random_one_in(random, 4) ? PAGES - first : 1);
    unsigned n = random_below(random, MEMORIES + 1);
    uint32_t at = random_one_in(random, 2) ? first : random_below(random, 64);
    bind_sparse(resources, 1, first * PAGE, count * PAGE, n, n ? at * PAGE : 0);
    for (uint32_t i = 0; i < count; i++) {
        model->pages[first + i].memory = n;
        model->pages[first + i].page = at + i;
        model->pages[first + i].life = model->lives[n];
    }
}

static bool is_bound(const struct model *model, uint32_t page)
{
    unsigned n = model->pages[page].memory;
    return n && model->pages[page].life == model->lives[n];
}

/* Every byte of the pieces is where the model has it, in order, and no bound byte is missing. */
static void assert_pieces(struct resources *resources, const struct model *model,
                          VkDeviceSize begin, VkDeviceSize end)
{
    struct pieces pieces = pieces_of(resources, 1, begin, end);
    VkDeviceSize at = begin;
    for (unsigned i = 0; i < pieces.count; i++) {
        const struct memory_span *span = &pieces.spans[i];
        while (at < end && !is_bound(model, (uint32_t)(at / PAGE)))
            at = (at / PAGE + 1) * PAGE;
        for (VkDeviceSize byte = span->begin; byte < span->end; byte++, at++) {
            uint32_t page = (uint32_t)(at / PAGE);
            assert_true(at < end && is_bound(model, page));
            assert_ptr_equal(span->memory, memory(model->pages[page].memory));
            assert_int_equal(byte, model->pages[page].page * PAGE + at % PAGE);
        }
    }
    for (; at < end; at++)
        assert_false(is_bound(model, (uint32_t)(at / PAGE)));
}

static void assert_backed(struct resources *resources, const struct model *model, uint32_t first,
                          uint32_t count)
{
    bool all = true;
    for (uint32_t i = first; i < first + count; i++)
        all &= is_bound(model, i);
    have_accel(resources, 1, 1, first * PAGE + 1, count * PAGE - 2);
    assert_int_equal(backed(resources), all ? YES : UNKNOWN);
}

static void test_random_bindings(void **state)
{
    (void)state;
    struct random random = random_of("sparse");
    struct resources *resources = a_structure_in_pages();
    struct model model = {0};
    for (int step = 0; step < 1500; step++) {
        bind_randomly(&random, resources, &model);
        if (random_one_in(&random, 20)) {
            unsigned n = 1 + random_below(&random, MEMORIES);
            resources_remove_memory(resources, memory(n));
            have_memory(resources, n);
            model.lives[n]++;
        }
        VkDeviceSize begin = random_below(&random, PAGES * PAGE);
        VkDeviceSize end = begin + random_below(&random, PAGES * PAGE - (uint32_t)begin);
        assert_pieces(resources, &model, begin, end);
        uint32_t first = random_below(&random, PAGES);
        assert_backed(resources, &model, first, 1 + random_below(&random, PAGES - first) % 5);
    }
    resources_destroy(resources);
}

/* ---- cost */

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

/* Binds page by page, as streaming does, looks at the last page each time, and unbinds all at once.
 */
static double time_of_pages(uint32_t count)
{
    struct resources *resources = no_resources();
    double start = seconds();
    have_memory(resources, 1);
    have_sparse_buffer(resources, 1, (VkDeviceSize)count * PAGE);
    for (uint32_t i = 0; i < count; i++) {
        bind_sparse(resources, 1, (VkDeviceSize)i * PAGE, PAGE, 1, (VkDeviceSize)(i ^ 1) * PAGE);
        VkDeviceSize begin = (VkDeviceSize)i * PAGE;
        assert_int_equal(pieces_of(resources, 1, begin, begin + PAGE).count, 1);
    }
    bind_sparse(resources, 1, 0, (VkDeviceSize)count * PAGE, 0, 0);
    resources_destroy(resources);
    return seconds() - start;
}

static void test_many_pages_cost_no_square(void **state)
{
    (void)state;
    time_of_pages(4000);
    double one = time_of_pages(4000), ten = time_of_pages(40000);
    if (ten > 30 * one)
        fail_msg("4,000 pages take %g s, 40,000 %g s", one, ten);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_range_bound_in_one_piece),
        cmocka_unit_test(test_a_range_bound_in_two_pieces),
        cmocka_unit_test(test_a_range_cut_out_of_the_middle),
        cmocka_unit_test(test_memory_freed_leaves_a_hole),
        cmocka_unit_test(test_an_address_in_a_sparse_buffer_needs_no_memory),
        cmocka_unit_test(test_a_dead_buffer_backs_nothing),
        cmocka_unit_test(test_bindings_without_bytes_do_nothing),
        cmocka_unit_test(test_a_lost_binding_makes_all_unknown),
        cmocka_unit_test(test_random_bindings),
        cmocka_unit_test(test_many_pages_cost_no_square),
    };
    return cmocka_run_group_tests_name("sparse", tests, NULL, NULL);
}
