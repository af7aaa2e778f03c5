/* SPDX-License-Identifier: Apache-2.0 */
/* Lists of chunks: against an array, with places to come back to, and no memory. */
#include "random.h"
#include "src/base/chunk_list.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/unit_test.h"

enum { ITEM = 24, CHUNK_ITEMS = 64, AT_ONCE = 5, MOST = 5000, STEPS = 4000 };
static const struct chunk_sizes sizes = {CHUNK_ITEMS * ITEM, AT_ONCE *ITEM};

/* A list, and what is in it. */
struct pair {
    struct chunk_list list;
    uint32_t count, numbers[MOST], next_number;
};

/* As many as asked for, AT_ONCE at most. */
static void add(struct pair *pair, uint32_t count)
{
    assert_true(chunk_list_make_room(&pair->list, sizes));
    for (uint32_t i = 0; i < count; i++) {
        *(uint32_t *)pair->list.next = pair->next_number;
        pair->list.next += ITEM;
        pair->numbers[pair->count++] = pair->next_number++;
    }
}

/* Returns the next item. */
static const uint32_t *next(const struct pair *pair, struct chunk_place *place)
{
    const struct chunk_place end = chunk_list_end(&pair->list);
    const uint32_t *item = chunk_list_at(&pair->list, place, &end);
    if (item)
        place->next += ITEM;
    return item;
}

/* The items from a place on are those from `first` on. */
static void expect_from(const struct pair *pair, struct chunk_place place, uint32_t first)
{
    for (uint32_t i = first; i < pair->count; i++) {
        const uint32_t *item = next(pair, &place);
        assert_non_null(item);
        assert_int_equal(*item, pair->numbers[i]);
    }
    assert_null(next(pair, &place));
    assert_null(next(pair, &place));
}

static void expect_all(const struct pair *pair)
{
    expect_from(pair, (struct chunk_place){NULL, NULL}, 0);
    assert_int_equal(chunk_list_is_empty(&pair->list), pair->count == 0);
}

TEST(a_list_is_like_an_array)
{
    struct random random = random_of("chunk_list");
    struct pair pair = {.count = 0};
    struct chunk_place place = {NULL, NULL};
    uint32_t placed = 0;
    expect_all(&pair);
    for (int step = 0; step < STEPS; step++) {
        if (pair.count + AT_ONCE > MOST || random_one_in(&random, 500)) {
            chunk_list_clear(&pair.list);
            pair.count = 0;
            place = chunk_list_end(&pair.list);
            placed = 0;
            expect_all(&pair);
        } else if (random_one_in(&random, 20)) {
            expect_from(&pair, place, placed);
            chunk_list_cut(&pair.list, place);
            pair.count = placed;
            expect_all(&pair);
        } else if (random_one_in(&random, 10)) {
            place = chunk_list_end(&pair.list);
            placed = pair.count;
        } else {
            add(&pair, random_below(&random, AT_ONCE + 1));
        }
    }
    expect_all(&pair);
    chunk_list_free(&pair.list);
}

/* What was walked to the end goes on with what comes later. */
TEST(a_walk_goes_on_where_it_was)
{
    struct pair pair = {.count = 0};
    struct chunk_place place = {NULL, NULL};
    for (uint32_t i = 0; i < 3 * CHUNK_ITEMS; i++) {
        assert_null(next(&pair, &place));
        add(&pair, 1);
        const uint32_t *item = next(&pair, &place);
        assert_non_null(item);
        assert_int_equal(*item, i);
    }
    chunk_list_free(&pair.list);
}

/* What comes behind its end is not read. */
TEST(a_walk_has_an_end)
{
    struct pair pair = {.count = 0};
    for (uint32_t length = 0; length < 3 * CHUNK_ITEMS; length++) {
        struct chunk_place place = {NULL, NULL};
        const struct chunk_place end = chunk_list_end(&pair.list);
        uint32_t count = 0;
        add(&pair, 1);
        for (; chunk_list_at(&pair.list, &place, &end); count++)
            place.next += ITEM;
        assert_int_equal(count, length);
    }
    chunk_list_free(&pair.list);
}

TEST(emptied_chunks_are_used_again)
{
    struct pair pair = {.count = 0};
    for (int i = 0; i < 4 * CHUNK_ITEMS; i++)
        add(&pair, 1);
    chunk_list_clear(&pair.list);
    pair.count = 0;
    memory_fail_after(0);
    for (int i = 0; i < 4 * CHUNK_ITEMS; i++)
        add(&pair, 1);
    assert_false(memory_fail_no_more());
    expect_all(&pair);
    chunk_list_free(&pair.list);
}

TEST(without_memory_a_list_stays_as_it_is)
{
    struct pair pair = {.count = 0};
    WITHOUT_MEMORY(assert_false(chunk_list_make_room(&pair.list, sizes)));
    expect_all(&pair);
    while (pair.list.next < pair.list.limit || !pair.list.first)
        add(&pair, 1);
    assert_int_equal(pair.count, CHUNK_ITEMS - AT_ONCE + 1);
    WITHOUT_MEMORY(assert_false(chunk_list_make_room(&pair.list, sizes)));
    expect_all(&pair);
    add(&pair, 1);
    expect_all(&pair);
    chunk_list_free(&pair.list);
}
