/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the ordered set of address ranges. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../report/scarce_memory.h"
#include "random.h"
#include "state/address_map.h"

enum { ENTRIES = 12000, QUERIES = 1200 };

/* The naive map: a range is its own record. */
struct range {
    uint64_t begin, size;
    bool present;
    unsigned found; /* by the query under way */
    bool is_only;   /* as that says */
};

struct world {
    struct address_map map;
    struct range *ranges;
    uint32_t count;
};

static void setup(struct world *world, uint32_t count)
{
    *world = (struct world){.count = count, .ranges = calloc(count, sizeof(struct range))};
    assert_non_null(world->ranges);
}

static void teardown(struct world *world)
{
    address_map_release(&world->map);
    assert_int_equal(world->map.chunk_count, 0);
    free(world->ranges);
}

static void note(void *record, void *context)
{
    struct range *range = record;
    (void)context;
    range->found++;
}

/* The shorter ways lead to the same. */
static void assert_ways_agree(const struct address_map *map, uint64_t address)
{
    const uint64_t others[] = {0, UINT64_MAX, address - 1, address + 1, address / 2, address};
    enum { OTHERS = sizeof(others) / sizeof(others[0]) };
    struct address_position found[OTHERS];
    struct address_position position = address_map_find_chunk(map, address);
    for (unsigned i = 0; i < OTHERS; i++) {
        assert_int_equal(address_map_find_chunk_near(map, address, found, i).chunk, position.chunk);
        found[i] = address_map_find_chunk(map, others[i]);
    }
    address_map_find_entry(map, address, &position);
    struct range *only = address_map_only(map, position, address);
    if (only)
        only->is_only = true;
}

static void assert_finds_what_is_there(struct world *world, uint64_t address)
{
    assert_ways_agree(&world->map, address);
    address_map_find(&world->map, address, note, NULL);
    uint32_t holders = 0, only = 0;
    for (uint32_t i = 0; i < world->count; i++) {
        struct range *range = &world->ranges[i];
        bool holds =
            range->present && range->begin <= address && address - range->begin < range->size;
        if (range->found != holds)
            fail_msg("address %#lx: [%#lx, +%#lx) visited %u times", (unsigned long)address,
                     (unsigned long)range->begin, (unsigned long)range->size, range->found);
        holders += holds;
        only += range->is_only;
        assert_true(!range->is_only || holds);
        range->found = 0;
        range->is_only = false;
    }
    assert_true(only == 0 || holders == 1);
}

static void add(struct world *world, struct range *range)
{
    assert_true(address_map_add(&world->map, range->begin, range->size, range));
    range->present = true;
}

static void take_out(struct world *world, struct range *range)
{
    address_map_remove(&world->map, range->begin, range);
    range->present = false;
}

/* ---- how ranges may lie */

/* Next to each other, as buffers of one heap. */
static void lie_apart(struct random *random, struct range *range, uint32_t i)
{
    range->begin = 0x100000000u + (uint64_t)i * 0x1000;
    range->size = 1 + random_below(random, 0x1000);
}

/* Anywhere, most of them short. */
static void lie_anywhere(struct random *random, struct range *range, uint32_t i)
{
    (void)i;
    range->begin = random_below(random, 1 << 20);
    range->size = 1 + (random_next(random) >> (40 + random_below(random, 24)));
}

/* Few beginnings, so that equal ones fill several chunks, and few sizes, so that ranges are equal.
 */
static void lie_together(struct random *random, struct range *range, uint32_t i)
{
    (void)i;
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
    (void)i;
    uint64_t before_end = 2 + random_below(random, 1 << 16);
    range->begin = 0 - before_end;
    range->size = 1 + random_below(random, (uint32_t)before_end - 1);
}

typedef void (*layout)(struct random *random, struct range *range, uint32_t i);

/* An address at which something may go wrong: by the ends of a range, or in it. */
static uint64_t some_address(struct random *random, const struct world *world)
{
    const struct range *range = &world->ranges[random_below(random, world->count)];
    uint64_t edges[] = {range->begin, range->begin - 1, range->begin + range->size,
                        range->begin + range->size - 1,
                        range->begin + random_next(random) % range->size};
    return edges[random_below(random, sizeof(edges) / sizeof(edges[0]))];
}

static void query(struct random *random, struct world *world, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        assert_finds_what_is_there(world, some_address(random, world));
}

/* Fills, changes and empties a map. */
static void live_through(struct random *random, layout lie, uint32_t count, uint32_t queries)
{
    struct world world;
    setup(&world, count);
    for (uint32_t i = 0; i < count; i++) {
        lie(random, &world.ranges[i], i);
        add(&world, &world.ranges[i]);
    }
    query(random, &world, queries / 3);
    for (uint32_t i = 0; i < count; i++) {
        struct range *range = &world.ranges[random_below(random, count)];
        if (range->present) {
            take_out(&world, range);
            lie(random, range, (uint32_t)(range - world.ranges));
        } else {
            add(&world, range);
        }
        if (i % (3 * count / queries) == 0)
            query(random, &world, 1);
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t at = (uint32_t)((uint64_t)i * 7919 % count); /* 7919 is a prime: each once */
        if (world.ranges[at].present)
            take_out(&world, &world.ranges[at]);
        if (i % (3 * count / queries) == 0)
            query(random, &world, 1);
    }
    assert_int_equal(world.map.chunk_count, 0);
    teardown(&world);
}

static void test_ranges_apart(void **state)
{
    (void)state;
    struct random random = random_of("address_map apart");
    live_through(&random, lie_apart, ENTRIES, QUERIES);
}

static void test_ranges_anywhere(void **state)
{
    (void)state;
    struct random random = random_of("address_map anywhere");
    live_through(&random, lie_anywhere, ENTRIES, QUERIES);
    for (uint32_t count = 8; count < 600; count += 37) /* about one chunk and two */
        live_through(&random, lie_anywhere, count, count);
}

static void test_equal_beginnings_and_equal_ranges(void **state)
{
    (void)state;
    struct random random = random_of("address_map together");
    live_through(&random, lie_together, 3000, 300);
}

static void test_nested_ranges(void **state)
{
    (void)state;
    struct random random = random_of("address_map nested");
    live_through(&random, lie_nested, ENTRIES, 300);
}

static void test_ranges_at_the_top_of_the_address_space(void **state)
{
    (void)state;
    struct random random = random_of("address_map top");
    live_through(&random, lie_at_the_top, 2000, 600);
}

/* ---- edges */

static void test_what_has_no_end_is_refused(void **state)
{
    (void)state;
    struct address_map map = {0};
    struct range range = {0};
    assert_false(address_map_add(&map, 0x1000, 0, &range));
    assert_false(address_map_add(&map, UINT64_MAX - 15, 16, &range)); /* its end is 2^64 */
    assert_false(address_map_add(&map, UINT64_MAX - 15, 17, &range));
    assert_false(address_map_add(&map, UINT64_MAX, UINT64_MAX, &range));
    assert_false(address_map_add(&map, 1, UINT64_MAX, &range));
    assert_int_equal(map.chunk_count, 0);
    assert_true(address_map_add(&map, UINT64_MAX - 16, 16, &range));
    address_map_find(&map, UINT64_MAX, note, NULL);
    assert_int_equal(range.found, 0);
    address_map_find(&map, UINT64_MAX - 1, note, NULL);
    assert_int_equal(range.found, 1);
    assert_true(address_map_add(&map, 0, UINT64_MAX, &range));
    address_map_find(&map, UINT64_MAX - 1, note, NULL);
    assert_int_equal(range.found, 3);
    address_map_release(&map);
}

static void test_removing_what_is_not_there_does_nothing(void **state)
{
    (void)state;
    struct range ranges[3] = {{0}};
    struct world world = {.ranges = ranges, .count = 3};
    address_map_remove(&world.map, 0x1000, &world.ranges[0]);
    for (uint32_t i = 0; i < 2; i++) {
        world.ranges[i] = (struct range){.begin = 0x1000, .size = 16};
        add(&world, &world.ranges[i]);
    }
    address_map_remove(&world.map, 0x1000, &world.ranges[2]);
    address_map_remove(&world.map, 0x1001, &world.ranges[0]);
    address_map_remove(&world.map, 0, &world.ranges[0]);
    assert_finds_what_is_there(&world, 0x1000);
    take_out(&world, &world.ranges[0]);
    address_map_remove(&world.map, 0x1000, &world.ranges[0]);
    assert_finds_what_is_there(&world, 0x1000);
    address_map_release(&world.map);
}

static void test_without_memory_it_stays_as_it_was(void **state)
{
    (void)state;
    struct random random = random_of("address_map memory");
    struct world world;
    unsigned failures = 0;
    setup(&world, 4000);
    for (uint32_t i = 0; i < world.count; i++)
        lie_anywhere(&random, &world.ranges[i], i);
    for (uint32_t i = 0; i < world.count; i++) {
        struct range *range = &world.ranges[i];
        memory_fail_after((int)random_below(&random, 2));
        range->present = address_map_add(&world.map, range->begin, range->size, range);
        bool failed = memory_fail_no_more();
        assert_int_equal(range->present, !failed);
        if (failed) {
            failures++;
            query(&random, &world, 1);
            add(&world, range);
        }
    }
    query(&random, &world, 200);
    assert_true(failures > 4);
    teardown(&world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ranges_apart),
        cmocka_unit_test(test_ranges_anywhere),
        cmocka_unit_test(test_equal_beginnings_and_equal_ranges),
        cmocka_unit_test(test_nested_ranges),
        cmocka_unit_test(test_ranges_at_the_top_of_the_address_space),
        cmocka_unit_test(test_what_has_no_end_is_refused),
        cmocka_unit_test(test_removing_what_is_not_there_does_nothing),
        cmocka_unit_test(test_without_memory_it_stays_as_it_was),
    };
    return cmocka_run_group_tests_name("address map", tests, NULL, NULL);
}
