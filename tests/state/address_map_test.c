/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the ordered set of address ranges. */
#include <stdlib.h>

#include "random.h"
#include "src/state/resources/address_map.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/unit_test.h"

enum { ENTRIES = 12000, QUERIES = 1200 };

/* The naive map: the id of a place says which range it is of. */
struct range {
    uint64_t begin, size;
    bool present;
    unsigned found; /* by the query under way */
};

struct fixture {
    struct address_map map;
    struct range *ranges;
    uint32_t count;
};

static void setup(struct fixture *fixture, uint32_t count)
{
    *fixture = (struct fixture){.count = count, .ranges = calloc(count, sizeof(struct range))};
    assert_non_null(fixture->ranges);
}

static void teardown(struct fixture *fixture)
{
    address_map_release(&fixture->map);
    assert_int_equal(fixture->map.chunk_count, 0);
    free(fixture->ranges);
}

static struct address_facts place_of(const struct range *range, uint64_t id)
{
    return (struct address_facts){
        .address = range->begin, .bytes_left = range->size, .buffer_id = id};
}

static struct address_facts place_in(const struct fixture *fixture, const struct range *range)
{
    return place_of(range, (uint64_t)(range - fixture->ranges));
}

static void note(const struct address_facts *place, void *context)
{
    struct range *ranges = context;
    ranges[place->buffer_id].found++;
}

static bool has_references(const struct range *range, uint64_t address)
{
    return range->present && range->begin <= address && address - range->begin < range->size;
}

/* Before a search a guess may be old. What it shows at a glance is true all the same. */
static void assert_a_glance_is_right(const struct fixture *fixture, uint64_t address)
{
    const struct address_guesses guesses = address_map_guesses(&fixture->map);
    const struct address_facts *place = address_guesses_find(&guesses, address);
    if (!buffer_range_contains(place, address) || place->is_shared)
        return;
    for (uint32_t i = 0; i < fixture->count; i++)
        assert_int_equal(has_references(&fixture->ranges[i], address), i == place->buffer_id);
}

static bool overlap(const struct range *a, const struct range *b)
{
    return a != b && a->present && b->present && a->begin < b->begin + b->size &&
           b->begin < a->begin + a->size;
}

/* After it the guess is good, and the place knows whether others overlap it. */
static void assert_a_search_is_remembered(const struct fixture *fixture, uint64_t address)
{
    const struct address_guesses guesses = address_map_guesses(&fixture->map);
    const struct address_facts *place = address_guesses_find(&guesses, address);
    assert_true(buffer_range_contains(place, address));
    const struct range *range = &fixture->ranges[place->buffer_id];
    bool is_shared = false;
    for (uint32_t i = 0; i < fixture->count; i++)
        is_shared = is_shared || overlap(range, &fixture->ranges[i]);
    assert_int_equal(place->is_shared, is_shared);
}

static void assert_finds_what_is_there(struct fixture *fixture, uint64_t address)
{
    uint32_t holders = 0;
    assert_a_glance_is_right(fixture, address);
    address_map_find(&fixture->map, address, note, fixture->ranges);
    for (uint32_t i = 0; i < fixture->count; i++) {
        struct range *range = &fixture->ranges[i];
        if (range->found != has_references(range, address))
            fail_msg("address %#lx: [%#lx, +%#lx) visited %u times", (unsigned long)address,
                     (unsigned long)range->begin, (unsigned long)range->size, range->found);
        holders += range->found;
        range->found = 0;
    }
    if (holders)
        assert_a_search_is_remembered(fixture, address);
}

static void add(struct fixture *fixture, struct range *range)
{
    const struct address_facts place = place_in(fixture, range);
    assert_true(address_map_add(&fixture->map, &place));
    assert_true(fixture->map.range_count <= fixture->map.slot_count / 2);
    range->present = true;
}

static void take_out(struct fixture *fixture, struct range *range)
{
    const struct address_facts place = place_in(fixture, range);
    address_map_remove(&fixture->map, &place);
    range->present = false;
}

/* Next to each other, as buffers of one heap. */
static void lie_apart(struct random *random, struct range *range, uint32_t i)
{
    range->begin = 0x100000000u + (uint64_t)i * 0x1000;
    range->size = 1 + random_below(random, 0x1000);
}

/* Anywhere, most of them short. */
static void lie_anywhere(struct random *random, struct range *range, uint32_t i)
{
    range->begin = random_below(random, 1 << 20);
    range->size = 1 + (random_next(random) >> (40 + random_below(random, 24)));
}

/* Few beginnings, so that equal ones fill several chunks, and few sizes, so that ranges are equal.
 */
static void lie_together(struct random *random, struct range *range, uint32_t i)
{
    range->begin = 0x1000u * (1 + random_below(random, 7));
    range->size = 0x800u << random_below(random, 5);
}

/* Each inside the one before it, and small ones among them. */
static void lie_nested(struct random *random, struct range *range, uint32_t i)
{
    uint32_t depth = i % 4 ? random_below(random, ENTRIES) : i;
    range->begin = depth;
    range->size = i % 4 ? 1 + random_below(random, 3) : 2u * (ENTRIES - depth) + 1;
}

/* Up to the end of the address space. */
static void lie_at_the_top(struct random *random, struct range *range, uint32_t i)
{
    uint64_t before_end = 2 + random_below(random, 1 << 16);
    range->begin = 0 - before_end;
    range->size = 1 + random_below(random, (uint32_t)before_end - 1);
}

/* Further apart than a chunk reaches, with some near each other. */
static void lie_far_apart(struct random *random, struct range *range, uint32_t i)
{
    const uint64_t middle = (uint64_t)random_below(random, 64) << 32;
    range->begin = middle - 2 + random_below(random, 5); /* the first: at the top, too */
    range->size = 1 + random_below(random, 2);
    if (range->begin + range->size <= range->begin)
        range->begin = middle;
}

typedef void (*layout)(struct random *random, struct range *range, uint32_t i);

/* An address at which something may go wrong: by the ends of a range, or in it. */
static uint64_t some_address(struct random *random, const struct fixture *fixture)
{
    const struct range *range = &fixture->ranges[random_below(random, fixture->count)];
    uint64_t edges[] = {range->begin, range->begin - 1, range->begin + range->size,
                        range->begin + range->size - 1,
                        range->begin + random_next(random) % range->size};
    return edges[random_below(random, sizeof(edges) / sizeof(edges[0]))];
}

static void query(struct random *random, struct fixture *fixture, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        assert_finds_what_is_there(fixture, some_address(random, fixture));
}

/* Fills, changes and empties a map. */
static void live_through(struct random *random, layout lie, uint32_t count, uint32_t queries)
{
    struct fixture fixture;
    setup(&fixture, count);
    for (uint32_t i = 0; i < count; i++) {
        lie(random, &fixture.ranges[i], i);
        add(&fixture, &fixture.ranges[i]);
    }
    query(random, &fixture, queries / 3);
    for (uint32_t i = 0; i < count; i++) {
        struct range *range = &fixture.ranges[random_below(random, count)];
        if (range->present) {
            take_out(&fixture, range);
            lie(random, range, (uint32_t)(range - fixture.ranges));
        } else {
            add(&fixture, range);
        }
        if (i % (3 * count / queries) == 0)
            query(random, &fixture, 1);
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t at = (uint32_t)((uint64_t)i * 7919 % count); /* 7919 is a prime: each once */
        if (fixture.ranges[at].present)
            take_out(&fixture, &fixture.ranges[at]);
        if (i % (3 * count / queries) == 0)
            query(random, &fixture, 1);
    }
    assert_int_equal(fixture.map.chunk_count, 0);
    teardown(&fixture);
}

#define LAYOUT_TEST(name, seed, lie, count, queries)                                               \
    TEST(name)                                                                                     \
    {                                                                                              \
        struct random random = random_of("address_map " seed);                                     \
        live_through(&random, lie, count, queries);                                                \
    }

LAYOUT_TEST(test_ranges_apart, "apart", lie_apart, ENTRIES, QUERIES)

TEST(test_ranges_anywhere)
{
    struct random random = random_of("address_map anywhere");
    live_through(&random, lie_anywhere, ENTRIES, QUERIES);
    for (uint32_t count = 8; count < 600; count += 37) /* about one chunk and two */
        live_through(&random, lie_anywhere, count, count);
}

LAYOUT_TEST(test_equal_beginnings_and_equal_ranges, "together", lie_together, 3000, 300)
LAYOUT_TEST(test_nested_ranges, "nested", lie_nested, ENTRIES, 300)
LAYOUT_TEST(test_ranges_at_the_top_of_the_address_space, "top", lie_at_the_top, 2000, 600)
LAYOUT_TEST(test_ranges_far_apart, "far", lie_far_apart, 2000, 600)

static void note_usage(const struct address_facts *place, void *context)
{
    *(uint64_t *)context += place->usage;
}

TEST(test_what_is_said_of_one_of_equal_ranges_changes)
{
    struct address_map map = {0};
    enum { EQUAL = 100, CHANGED = 7 };
    struct address_facts place = {.address = 0x1000, .bytes_left = 16, .usage = 1};
    for (place.buffer_id = 0; place.buffer_id < EQUAL; place.buffer_id++)
        assert_true(address_map_add(&map, &place));
    place.buffer_id = CHANGED;
    place.usage = 1000;
    address_map_update(&map, &place);
    place.buffer_id = EQUAL;
    address_map_update(&map, &place); /* isn't there */
    uint64_t usages = 0;
    address_map_find(&map, 0x100f, note_usage, &usages);
    assert_int_equal(usages, EQUAL - 1 + 1000);
    address_map_release(&map);
}

TEST(test_what_has_no_end_is_refused)
{
    struct address_map map = {0};
    struct range range = {0};
    const struct range endless[] = {{.begin = 0x1000, .size = 0},
                                    {.begin = UINT64_MAX - 15, .size = 16}, /* its end is 2^64 */
                                    {.begin = UINT64_MAX - 15, .size = 17},
                                    {.begin = UINT64_MAX, .size = UINT64_MAX},
                                    {.begin = 1, .size = UINT64_MAX}};
    for (size_t i = 0; i < sizeof(endless) / sizeof(endless[0]); i++) {
        const struct address_facts place = place_of(&endless[i], 0);
        assert_false(address_map_add(&map, &place));
    }
    assert_int_equal(map.chunk_count, 0);

    const struct address_facts top = {.address = UINT64_MAX - 16, .bytes_left = 16},
                               all = {.address = 0, .bytes_left = UINT64_MAX};
    assert_true(address_map_add(&map, &top));
    address_map_find(&map, UINT64_MAX, note, &range);
    assert_int_equal(range.found, 0);
    address_map_find(&map, UINT64_MAX - 1, note, &range);
    assert_int_equal(range.found, 1);
    assert_true(address_map_add(&map, &all));
    address_map_find(&map, UINT64_MAX - 1, note, &range);
    assert_int_equal(range.found, 3);
    address_map_release(&map);
}

TEST(test_removing_what_is_not_there_does_nothing)
{
    struct range ranges[3] = {{0}};
    struct fixture fixture = {.ranges = ranges, .count = 3};
    const struct address_facts first = {.address = 0x1000, .buffer_id = 0};
    const struct address_facts others[] = {{.address = 0x1000, .buffer_id = 2},
                                           {.address = 0x1001, .buffer_id = 0},
                                           {.address = 0, .buffer_id = 0}};
    address_map_remove(&fixture.map, &first);
    for (uint32_t i = 0; i < 2; i++) {
        fixture.ranges[i] = (struct range){.begin = 0x1000, .size = 16};
        add(&fixture, &fixture.ranges[i]);
    }
    for (size_t i = 0; i < sizeof(others) / sizeof(others[0]); i++)
        address_map_remove(&fixture.map, &others[i]);
    assert_finds_what_is_there(&fixture, 0x1000);
    take_out(&fixture, &fixture.ranges[0]);
    address_map_remove(&fixture.map, &first);
    assert_finds_what_is_there(&fixture, 0x1000);
    address_map_release(&fixture.map);
}

/* Many small ranges leave no trace in how a large one is found that stays: any of its addresses at
 * a glance, after one search, as if they had never been; and their memory is given back. */
TEST(test_what_few_are_left_is_found_as_few_are)
{
    struct fixture fixture;
    setup(&fixture, ENTRIES);
    fixture.ranges[0] = (struct range){.begin = 0x100000000u, .size = 1 << 24};
    add(&fixture, &fixture.ranges[0]);
    for (uint32_t i = 1; i < ENTRIES; i++) {
        fixture.ranges[i] = (struct range){.begin = 0x10000u + 0x100u * i, .size = 0x100};
        add(&fixture, &fixture.ranges[i]);
    }
    assert_true(fixture.map.slot_count >= ENTRIES);
    for (uint32_t i = 1; i < ENTRIES; i++) {
        /* What can't be given back stays for now. */
        memory_fail_after(i % 3 && i < ENTRIES - 10 ? 0 : 100);
        take_out(&fixture, &fixture.ranges[i]);
        memory_fail_no_more();
        if (i % 500 == 0)
            assert_finds_what_is_there(&fixture, fixture.ranges[ENTRIES - i].begin);
    }
    assert_in_range(fixture.map.slot_count, 1, 1024);
    assert_finds_what_is_there(&fixture, 0x100000000u);
    const struct address_guesses guesses = address_map_guesses(&fixture.map);
    for (uint64_t offset = 0; offset < 1 << 24; offset += 0x5000)
        assert_true(buffer_range_contains(address_guesses_find(&guesses, 0x100000000u + offset),
                                          0x100000000u + offset));
    teardown(&fixture);
}

TEST(test_without_memory_it_stays_as_it_was)
{
    struct random random = random_of("address_map memory");
    struct fixture fixture;
    unsigned failures = 0;
    setup(&fixture, 4000);
    for (uint32_t i = 0; i < fixture.count; i++)
        lie_anywhere(&random, &fixture.ranges[i], i);
    for (uint32_t i = 0; i < fixture.count; i++) {
        struct range *range = &fixture.ranges[i];
        memory_fail_after((int)random_below(&random, 2));
        const struct address_facts place = place_in(&fixture, range);
        range->present = address_map_add(&fixture.map, &place);
        bool failed = memory_fail_no_more();
        /* It may also fail to choose better slots for what is there. */
        assert_true(range->present || failed);
        if (!range->present) {
            failures++;
            query(&random, &fixture, 1);
            add(&fixture, range);
        }
    }
    query(&random, &fixture, 200);
    assert_true(failures > 4);
    teardown(&fixture);
}
