/* SPDX-License-Identifier: Apache-2.0 */
/* Address maps and their guesses against a naive model. */
#include "src/state/resources/address_map.h"
#include "tests/unit/property.h"

/* ---- address maps: buffer_id is the number of a range in the model */

enum { RANGES = 3000, NO_RANGE = 2 /* a buffer_id that no range has: RANGES + this */ };

struct range {
    uint64_t begin, size;
    bool present;
    uint32_t usage, found; /* by the search under way */
};

struct map {
    struct address_map map;
    uint32_t layout;
    struct range ranges[RANGES];
    uint64_t last_begin; /* of the ranges that are visited in order */
};

/* How ranges lie: n is the number of the range, and x is any number. */
static struct range lie_apart(uint32_t n, uint64_t x)
{
    return (struct range){0x100000000u + (uint64_t)n * 0x1000, 1 + x % 0x1000};
}

static struct range lie_anywhere(uint32_t n, uint64_t x)
{
    return (struct range){x % (1 << 20), 1 + (x >> (40 + x % 24))};
}

/* Equal beginnings fill several chunks, and ranges are equal. */
static struct range lie_together(uint32_t n, uint64_t x)
{
    return (struct range){0x1000u * (1 + x % 7), 0x800u << (x / 7 % 5)};
}

/* Each inside the one before it, and small ones among them. */
static struct range lie_nested(uint32_t n, uint64_t x)
{
    return n % 4 ? (struct range){x % RANGES, 1 + x % 3} : (struct range){n, 2u * (RANGES - n) + 1};
}

/* Up to the end of the address space. */
static struct range lie_at_the_top(uint32_t n, uint64_t x)
{
    const uint64_t before_end = 2 + x % (1 << 16);
    return (struct range){0 - before_end, 1 + (x >> 20) % (before_end - 1)};
}

/* Further apart than a chunk reaches, with some near each other. */
static struct range lie_far_apart(uint32_t n, uint64_t x)
{
    const uint64_t middle = (x >> 8) % 64 << 32;
    const struct range range = {middle - 2 + x % 5, 1 + (x >> 4) % 2};
    return range.begin + range.size > range.begin ? range : (struct range){middle, range.size};
}

/* A large one among many small ones. */
static struct range lie_around_a_large_one(uint32_t n, uint64_t x)
{
    return n ? (struct range){0x10000u + 0x100u * n, 0x100} : (struct range){0x100000000u, 1 << 24};
}

static struct range (*const layouts[])(uint32_t n, uint64_t x) = {
    lie_apart,      lie_anywhere,  lie_together,           lie_nested,
    lie_at_the_top, lie_far_apart, lie_around_a_large_one,
};
enum { LAYOUTS = sizeof(layouts) / sizeof(layouts[0]) };

static struct address_facts facts_of(const struct range *range, uint64_t id)
{
    return (struct address_facts){
        .address = range->begin, .bytes_left = range->size, .usage = range->usage, .buffer_id = id};
}

static bool has_address(const struct range *range, uint64_t address)
{
    return range->present && address - range->begin < range->size;
}

static void map_lay_out(void *state, const uint32_t *operands)
{
    struct map *map = state;
    if (map->map.range_count == 0)
        map->layout = operands[0];
}

static void map_add(void *state, const uint32_t *operands)
{
    struct map *map = state;
    struct range *range = &map->ranges[operands[0]];
    bool is_added;
    if (range->present)
        return;
    *range = layouts[map->layout](operands[0], property_hash(operands[1]));
    range->usage = operands[1];
    const struct address_facts facts = facts_of(range, operands[0]);
    const bool failed = PROPERTY_CALL(is_added = address_map_add(&map->map, &facts));
    EXPECT(is_added || failed); /* it may also fail to choose better slots for what is there */
    EXPECT(map->map.range_count <= map->map.slot_count / 2);
    range->present = is_added;
}

static void map_add_many(void *state, const uint32_t *operands)
{
    for (uint32_t i = operands[0]; i < operands[0] + operands[1] && i < RANGES; i++)
        map_add(state, (const uint32_t[]){i, operands[2] + i});
}

/* What is not there is not removed: a range of another buffer, or at another address. */
static void map_remove(void *state, const uint32_t *operands)
{
    struct map *map = state;
    struct range *range = &map->ranges[operands[0]];
    struct address_facts facts = facts_of(range, operands[0]), other = facts;
    other.buffer_id = RANGES + NO_RANGE;
    address_map_remove(&map->map, &other);
    other.buffer_id = operands[0];
    other.address++;
    address_map_remove(&map->map, &other);
    PROPERTY_CALL(address_map_remove(&map->map, &facts));
    range->present = false;
}

static void map_remove_many(void *state, const uint32_t *operands)
{
    for (uint32_t i = operands[0]; i < operands[0] + operands[1] && i < RANGES; i++)
        map_remove(state, &i);
}

static void map_update(void *state, const uint32_t *operands)
{
    struct map *map = state;
    struct range *range = &map->ranges[operands[0]];
    range->usage = operands[1];
    const struct address_facts facts = facts_of(range, operands[0]);
    address_map_update(&map->map, &facts); /* does nothing if it is not there */
}

static void note_range(const struct address_facts *facts, void *context)
{
    struct map *map = context;
    EXPECT(facts->buffer_id < RANGES);
    struct range *range = &map->ranges[facts->buffer_id];
    EXPECT(facts->address == range->begin && facts->bytes_left == range->size &&
           facts->usage == range->usage);
    range->found++;
}

/* Before a search a guess may be old. What it shows at a glance is true all the same. */
static void expect_true_glance(const struct map *map, uint64_t address)
{
    const struct address_guesses guesses = address_map_guesses(&map->map);
    const struct address_facts *facts = address_guesses_find(&guesses, address);
    if (buffer_range_contains(facts, address) && !facts->is_shared)
        for (uint32_t i = 0; i < RANGES; i++)
            EXPECT_EQUAL(has_address(&map->ranges[i], address), i == facts->buffer_id);
}

/* After a search the guess is good, and the range knows whether others overlap it. */
static void expect_good_guess(const struct map *map, uint64_t address)
{
    const struct address_guesses guesses = address_map_guesses(&map->map);
    const struct address_facts *facts = address_guesses_find(&guesses, address);
    EXPECT(buffer_range_contains(facts, address));
    const struct range *range = &map->ranges[facts->buffer_id];
    bool is_shared = false;
    for (uint32_t i = 0; i < RANGES; i++) {
        const struct range *other = &map->ranges[i];
        is_shared |= other != range && other->present &&
                     other->begin < range->begin + range->size &&
                     range->begin < other->begin + other->size;
    }
    EXPECT_EQUAL(facts->is_shared, is_shared);
}

static void search(struct map *map, uint64_t address)
{
    uint32_t holders = 0;
    expect_true_glance(map, address);
    address_map_find(&map->map, address, note_range, map);
    for (uint32_t i = 0; i < RANGES; i++) {
        EXPECT_EQUAL(map->ranges[i].found, has_address(&map->ranges[i], address));
        holders += map->ranges[i].found;
        map->ranges[i].found = 0;
    }
    if (holders)
        expect_good_guess(map, address);
}

/* By the ends of a range, or in it: where something may go wrong. */
static void map_search(void *state, const uint32_t *operands)
{
    struct map *map = state;
    const struct range *range = &map->ranges[operands[0]];
    const uint64_t in = range->size ? property_hash(operands[0]) % range->size : 0;
    const uint64_t edges[] = {0, -1, range->size, range->size - 1, in};
    search(map, range->begin + edges[operands[1]]);
}

static void expect_order(const struct address_facts *facts, void *context)
{
    struct map *map = context;
    EXPECT(facts->address >= map->last_begin);
    map->last_begin = facts->address;
    note_range(facts, map);
}

static void map_check(void *state)
{
    struct map *map = state;
    uint32_t count = 0;
    map->last_begin = 0;
    address_map_each(&map->map, expect_order, map);
    for (uint32_t i = 0; i < RANGES; i++) {
        EXPECT_EQUAL(map->ranges[i].found, map->ranges[i].present);
        count += map->ranges[i].present;
        map->ranges[i].found = 0;
    }
    EXPECT_EQUAL(map->map.range_count, count);
}

/* Few ranges are found as if there had never been more, once memory is there again: any address of
 * the large one at a glance, after one search. */
static void map_end(void *state)
{
    struct map *map = state;
    map_remove_many(map, (const uint32_t[]){1, RANGES});
    if (map->ranges[0].present && map->layout + 1 == LAYOUTS) {
        EXPECT(map->map.slot_count <= 1024);
        search(map, map->ranges[0].begin);
        const struct address_guesses guesses = address_map_guesses(&map->map);
        for (uint64_t at = map->ranges[0].begin; at - map->ranges[0].begin < 1 << 24; at += 0x5000)
            EXPECT(buffer_range_contains(address_guesses_find(&guesses, at), at));
    }
    map_remove(map, (const uint32_t[]){0});
    EXPECT_EQUAL(map->map.chunk_count, 0);
    address_map_release(&map->map);
}

PROPERTY_TEST(address_map, .size = sizeof(struct map), .check = map_check, .end = map_end,
              .operations = {{"lay_out", map_lay_out, {LAYOUTS}},
                             {"add", map_add, {RANGES, 1 << 20}, 200, 100, 6},
                             {"add_many", map_add_many, {RANGES, RANGES, 1 << 20}, 3, 1, 4},
                             {"remove", map_remove, {RANGES}, 60, 200, 6},
                             {"remove_many", map_remove_many, {RANGES, RANGES}, 1, 3, 4},
                             {"update", map_update, {RANGES, 100}, 20},
                             {"search", map_search, {RANGES, 5}, 100}},
              .sequences = 40, .steps = 1200, .check_steps = 100)

TEST(ranges_without_an_end_are_refused)
{
    struct address_map map = {0};
    const struct address_facts endless[] = {{.address = 0x1000, .bytes_left = 0},
                                            {.address = UINT64_MAX - 15, .bytes_left = 16},
                                            {.address = UINT64_MAX - 15, .bytes_left = 17},
                                            {.address = UINT64_MAX, .bytes_left = UINT64_MAX},
                                            {.address = 1, .bytes_left = UINT64_MAX}},
                               top = {.address = UINT64_MAX - 16, .bytes_left = 16},
                               all = {.address = 0, .bytes_left = UINT64_MAX};
    for (size_t i = 0; i < sizeof(endless) / sizeof(endless[0]); i++)
        assert_false(address_map_add(&map, &endless[i]));
    assert_int_equal(map.chunk_count, 0);
    assert_true(address_map_add(&map, &top) && address_map_add(&map, &all));
    address_map_release(&map);
}

/* ---- how good guesses are, before any search */

static struct address_facts one_heap(uint32_t i)
{
    return (struct address_facts){.address = 0x100000000u + i * 0x3000ull, .bytes_left = 0x2100};
}

/* In turn, of buffers of three sizes. */
static struct address_facts three_heaps(uint32_t i)
{
    const uint64_t heaps[] = {0x7f0012340000u, 0x7f0123400000u, 0x7f0155550100u};
    const uint64_t sizes[] = {0x1000, 0x100, 0x500};
    return (struct address_facts){.address = heaps[i % 3] + i / 3 * sizes[i % 3],
                                  .bytes_left = sizes[i % 3]};
}

static struct address_facts few_large(uint32_t i)
{
    return (struct address_facts){.address = 0x100000000u * (1ull + i), .bytes_left = 0x100000000u};
}

/* Large ones first, so that their grains are too coarse for what comes later. */
static struct address_facts large_then_small(uint32_t i)
{
    const uint64_t small = 0x100000000000u + i * 0x100ull;
    return i < 7 ? few_large(i) : (struct address_facts){.address = small, .bytes_left = 0x80};
}

TEST(guesses_are_good)
{
    static const struct {
        struct address_facts (*lie)(uint32_t i);
        uint32_t count, least; /* percent */
        bool anywhere;         /* else of first addresses */
    } cases[] = {{one_heap, 12000, 95, false},
                 {three_heaps, 12000, 85, false},
                 {few_large, 7, 100, true},
                 {large_then_small, 60, 90, false},
                 {large_then_small, 12000, 90, false}};
    for (size_t c = 0; c < sizeof(cases) / sizeof(cases[0]); c++) {
        struct address_map map = {0};
        uint32_t right = 0;
        for (uint32_t i = 0; i < cases[c].count; i++) {
            const struct address_facts range = cases[c].lie(i);
            assert_true(address_map_add(&map, &range));
        }
        const struct address_guesses guesses = address_map_guesses(&map);
        for (uint32_t i = 0; i < cases[c].count; i++) {
            const struct address_facts range = cases[c].lie(i);
            const uint64_t at =
                range.address + (cases[c].anywhere ? property_hash(i) % range.bytes_left : 0);
            right += buffer_range_contains(address_guesses_find(&guesses, at), at);
        }
        address_map_release(&map);
        assert_in_range(right * 100 / cases[c].count, cases[c].least, 100);
    }
}
