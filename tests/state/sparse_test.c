/* SPDX-License-Identifier: Apache-2.0 */
/* Sparse buffers: what is bound where, against a map of their pages, and what many pages cost. For
 * whom it is bound: tests/programs/execution/sparse.cases. */
#include <inttypes.h>

#include "tests/state/fixture.h"
#include "tests/unit/property.h"
#include "tests/unit/steps.h"

enum { PAGE = 0x100, PAGES = 48, MEMORIES = 4 };

static void have_sparse_buffer(struct resources *resources, unsigned n, VkDeviceSize size)
{
    const STRUCT(VkBufferCreateInfo, create_info, .flags = VK_BUFFER_CREATE_SPARSE_BINDING_BIT,
                 .size = size, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    resources_add_buffer(resources, buffer(n), &create_info);
}

static void bind_sparse(struct resources *resources, unsigned n, VkDeviceSize begin,
                        VkDeviceSize size, unsigned memory_n, VkDeviceSize offset)
{
    const VkSparseMemoryBind bind = {
        .resourceOffset = begin, .size = size, .memory = memory(memory_n), .memoryOffset = offset};
    struct sparse_binding binding = resources_announce_sparse(resources, buffer(n), &bind);
    resources_bind_sparse(resources, &binding, (struct timestamp){1, 1}, &all_of_queue_1);
    resources_settle_sparse(resources, &binding);
}

/* The pieces of memory that bytes of buffer n lie in. */
static struct pieces pieces_of(struct resources *resources, unsigned n, VkDeviceSize begin,
                               VkDeviceSize end)
{
    struct pieces pieces = {.count = 0};
    const uint64_t id =
        resources_find_id(resources, RESOURCE_BUFFER, (uint64_t)(uintptr_t)buffer(n));
    const struct sparse_bytes bytes = {buffer(n), id, begin, end};
    resources_find_pieces(resources, &bytes, &all_of_queue_1, note_piece, &pieces);
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

#define PAGES_TEST(name)                                                                           \
    TEST_WITH(name, struct resources *resources, a_structure_in_pages, resources_destroy)

/* Whether structure 1 lies in memory for work that follows all earlier work. */
static enum tristate backed(struct resources *resources)
{
    struct accel_facts facts;
    const struct resource_queries queries = {.accel_count = 1, .accels = {{accel(1), &facts}}};
    resources_find_all(resources, &queries);
    assert_true(facts.is_sparse && !facts.memory);
    const struct sparse_bytes bytes = {facts.buffer, facts.buffer_id, facts.begin,
                                       facts.begin + facts.size};
    struct sparse_bytes missing;
    enum tristate answer = resources_sparse_backing(resources, &bytes, &all_of_queue_1, &missing);
    if (answer == NO)
        assert_true(missing.begin < missing.end && missing.begin >= bytes.begin &&
                    missing.end <= bytes.end);
    return answer;
}

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

/* All that a command reads is bound, or nothing can be read. */
PAGES_TEST(pages_that_are_bound_are_readable)
{
    const struct execution_clock nothing = {0};
    resources_set_address(resources, buffer(1), 0x100000);
    bind_sparse(resources, 1, 0, 0x800, 1, 0);
    assert_int_equal(resources_find_readable(resources, 0x100000, 0x800, &all_of_queue_1), 0x800);
    assert_int_equal(resources_find_readable(resources, 0x100000, 0x801, &all_of_queue_1), 0);
    assert_int_equal(resources_find_readable(resources, 0x100000, 0x800, &nothing), 0);
}

/* It is freed between the call and the execution of the binding. */
PAGES_TEST(memory_of_a_recycled_handle_is_not_what_was_bound)
{
    const VkSparseMemoryBind bind = {.size = 8 * PAGE, .memory = memory(1)};
    struct sparse_binding binding = resources_announce_sparse(resources, buffer(1), &bind);
    resources_remove_memory(resources, memory(1));
    have_memory(resources, 1);
    resources_bind_sparse(resources, &binding, (struct timestamp){1, 1}, &all_of_queue_1);
    resources_settle_sparse(resources, &binding);
    assert_int_equal(backed(resources), UNKNOWN);
}

/* Binds page by page, as streaming does, looks at the last page each time, and unbinds all at once.
 */
static uint64_t steps_of_pages(uint32_t count)
{
    struct resources *resources = no_resources();
    uint64_t start = steps_so_far;
    have_memory(resources, 1);
    have_sparse_buffer(resources, 1, (VkDeviceSize)count * PAGE);
    for (uint32_t i = 0; i < count; i++) {
        bind_sparse(resources, 1, (VkDeviceSize)i * PAGE, PAGE, 1, (VkDeviceSize)(i ^ 1) * PAGE);
        VkDeviceSize begin = (VkDeviceSize)i * PAGE;
        assert_int_equal(pieces_of(resources, 1, begin, begin + PAGE).count, 1);
    }
    bind_sparse(resources, 1, 0, (VkDeviceSize)count * PAGE, 0, 0);
    resources_destroy(resources);
    return steps_so_far - start;
}

TEST(many_pages_cost_no_square)
{
    uint64_t one = steps_of_pages(4000), ten = steps_of_pages(40000);
    print_message("4,000 pages take %" PRIu64 " steps, 40,000 %" PRIu64 "\n", one, ten);
    assert_true(one >= 4000);
    assert_true(ten <= 15 * one);
}
