/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of sparse buffers against a map of their pages, and of what many pages cost. */
#include <inttypes.h>

#include "random.h"
#include "tests/state/fixture.h"
#include "tests/state/steps.h"

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
    assert_int_equal(backed(resources), all ? YES : NO);
}

PAGES_TEST(test_random_bindings)
{
    struct random random = random_of("sparse");
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

TEST(test_many_pages_cost_no_square)
{
    uint64_t one = steps_of_pages(4000), ten = steps_of_pages(40000);
    print_message("4,000 pages take %" PRIu64 " steps, 40,000 %" PRIu64 "\n", one, ten);
    assert_true(one >= 4000);
    assert_true(ten <= 15 * one);
}
