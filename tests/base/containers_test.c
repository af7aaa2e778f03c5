/* SPDX-License-Identifier: Apache-2.0 */
/* Handle tables and lists of chunks against naive models. */
#include "src/base/array.h"
#include "src/base/handle_table.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/property.h"

/* ---- handle tables */

enum { WRAPPING_KEYS = 30, KEYS = 330, FIRST_SLOTS = 64 };

static char records[1200]; /* records are pointers into it */

struct handles {
    struct handle_table table;
    void *records[KEYS];
    size_t count;
    bool has_room, was_scarce; /* a key was removed last; memory has run out */
};

/* Key 0 is no key. The next ones have their homes in the last two slots and the first two of the
 * smallest table. The others are counters, pointers, indices in the high bits, and any number. */
static uint64_t key_of(uint32_t i)
{
    static uint64_t wrapping[WRAPPING_KEYS];
    const struct handle_table smallest = {.shift = 64 - 6};
    for (uint64_t key = 1, at = 1; !wrapping[WRAPPING_KEYS - 1]; key++)
        if ((handle_table_home(&smallest, key) + 2) % FIRST_SLOTS < 4)
            wrapping[at++] = key;
    const uint64_t kinds[] = {i + 1000, 0x7f0000000000u + i * 64, (uint64_t)i << 32,
                              property_hash(i) | 1};
    return i < WRAPPING_KEYS ? wrapping[i] : kinds[i % 4];
}

static void handle_set(void *state, const uint32_t *operands)
{
    struct handles *handles = state;
    void **expected = &handles->records[operands[0]], *record = &records[operands[1]];
    bool is_set;
    const bool failed =
        PROPERTY_CALL(is_set = handle_table_set(&handles->table, key_of(operands[0]), record));
    EXPECT(!failed || (!*expected && !handles->has_room));
    EXPECT_EQUAL(is_set, operands[0] && !failed);
    handles->was_scarce |= failed;
    handles->has_room &= !is_set;
    handles->count += is_set && !*expected;
    *expected = is_set ? record : *expected;
}

static void handle_remove(void *state, const uint32_t *operands)
{
    struct handles *handles = state;
    void *removed = NULL, *expected = handles->records[operands[0]];
    handles->was_scarce |=
        PROPERTY_CALL(removed = handle_table_remove(&handles->table, key_of(operands[0])));
    EXPECT_SAME(removed, expected);
    handles->has_room |= expected != NULL;
    handles->count -= expected != NULL;
    handles->records[operands[0]] = NULL;
}

static void handle_remove_many(void *state, const uint32_t *operands)
{
    for (uint32_t i = operands[0]; i < operands[0] + operands[1] && i < KEYS; i++)
        handle_remove(state, &i);
}

static void count_record(void *record, void *context)
{
    EXPECT(record != NULL);
    ++*(size_t *)context;
}

static void handles_check(void *state)
{
    const struct handles *handles = state;
    const struct handle_table *table = &handles->table;
    size_t visited = 0, occupied = 0;
    for (uint32_t i = 0; i < KEYS; i++)
        EXPECT_SAME(handle_table_find(table, key_of(i)), handles->records[i]);
    handle_table_each(table, count_record, &visited);
    for (size_t i = 0; table->slots && i <= table->mask; i++)
        occupied += table->slots[i].handle != 0;
    EXPECT_EQUAL(table->count, handles->count);
    EXPECT_EQUAL(visited, handles->count);
    EXPECT_EQUAL(occupied, handles->count);
    if (!table->slots)
        return;
    EXPECT(table->count * 3 <= (table->mask + 1) * 2);
    EXPECT(table->mask + 1 == FIRST_SLOTS || handles->was_scarce ||
           table->count >= (table->mask + 1) / 16);
}

static uint32_t released;

static void count_released(void *record)
{
    EXPECT(record != NULL);
    released++;
}

static void handles_end(void *state)
{
    struct handles *handles = state;
    released = 0;
    handle_table_drop(&handles->table, count_released);
    EXPECT_EQUAL(released, handles->count);
    EXPECT_SAME(handles->table.slots, NULL);
}

#define HANDLES(keys, count_)                                                                      \
    .size = sizeof(struct handles), .check = handles_check, .end = handles_end,                    \
    .operations = {{"set", handle_set, {keys, sizeof(records)}, 7, 3, 4},                          \
                   {"remove", handle_remove, {keys}, 3, 7, 4},                                     \
                   {"remove_many", handle_remove_many, {keys, keys / 2}, 0, 1, 4}},                \
    .sequences = count_, .check_steps = 5

PROPERTY_TEST(handle_table, HANDLES(KEYS, 30), .steps = 2000)
PROPERTY_TEST(handle_table_that_wraps, HANDLES(WRAPPING_KEYS, 200), .steps = 120)

static size_t longest_run(const struct handle_table *table)
{
    size_t longest = 0, run = 0;
    for (size_t i = 0; i < 2 * (table->mask + 1); i++) {
        run = table->slots[i & table->mask].handle ? run + 1 : 0;
        longest = run > longest ? run : longest;
    }
    return longest;
}

/* Drivers make handles of pointers, and of indices shifted to any place: all have to spread. */
TEST(regular_handles_spread)
{
    for (unsigned shift = 0; shift <= 48; shift++) {
        struct handle_table table = {0};
        for (uint64_t i = 1; i <= 5000; i++)
            assert_true(handle_table_set(&table, i << shift, records));
        if (longest_run(&table) > 200)
            fail_msg("handles of a multiple of 2^%u make runs of %zu", shift, longest_run(&table));
        handle_table_release(&table);
    }
}

/* ---- lists of chunks */

enum { ITEM = 24, CHUNK_ITEMS = 64, AT_ONCE = 5, MOST_ITEMS = 1200 };
static const struct chunk_sizes sizes = {CHUNK_ITEMS * ITEM, AT_ONCE *ITEM};

/* A position: of the list, and the number of items before it. */
struct item_place {
    struct chunk_place place;
    uint32_t before;
};

struct items {
    struct chunk_list list;
    uint32_t count, numbers[MOST_ITEMS], next_number;
    int blocks, most_chunks; /* that were allocated; that the list had at one time */
    struct item_place mark, walk;
};

/* The next item up to `end`, or NULL. */
static const uint32_t *item_next(const struct items *items, struct chunk_place *place,
                                 const struct chunk_place *end)
{
    const uint32_t *item = chunk_list_at(&items->list, place, end);
    if (item)
        place->next += ITEM;
    return item;
}

/* The items from `from` up to `to`. */
static void expect_items(const struct items *items, struct item_place *from,
                         const struct item_place *to)
{
    for (const uint32_t *item; (item = item_next(items, &from->place, &to->place));)
        EXPECT(from->before < to->before && *item == items->numbers[from->before++]);
    EXPECT_EQUAL(from->before, to->before);
}

static struct item_place items_end(const struct items *items)
{
    return (struct item_place){chunk_list_end(&items->list), items->count};
}

static int count_chunks(const struct chunk_list *list)
{
    int count = 0;
    for (const struct chunk *chunk = list->first; chunk; chunk = chunk->next)
        count++;
    return count;
}

/* A chunk is added if the last one lacks room, and allocated if none is spare. */
static void item_add(void *state, const uint32_t *operands)
{
    struct items *items = state;
    struct chunk_list *list = &items->list;
    bool has_room;
    if (items->count + AT_ONCE > MOST_ITEMS)
        return;
    const bool is_full =
        !list->last || list->next - (char *)(list->last + 1) > (CHUNK_ITEMS - AT_ONCE) * ITEM;
    const int chunks = count_chunks(list), blocks = allocations_now();
    const bool failed = PROPERTY_CALL(has_room = chunk_list_make_room(list, sizes));
    EXPECT_EQUAL(has_room, !failed);
    EXPECT_EQUAL(count_chunks(list), chunks + (is_full && has_room));
    items->blocks += allocations_now() - blocks;
    if (count_chunks(list) > items->most_chunks)
        items->most_chunks = count_chunks(list);
    if (ALLOCATIONS_ARE_COUNTED)
        EXPECT_EQUAL(items->blocks, items->most_chunks);
    for (uint32_t i = 0; has_room && i < operands[0]; i++) {
        *(uint32_t *)list->next = items->next_number;
        list->next += ITEM;
        items->numbers[items->count++] = items->next_number++;
    }
}

static void item_mark(void *state, const uint32_t *operands)
{
    struct items *items = state;
    items->mark = items_end(items);
}

static void item_cut_to(struct items *items, struct item_place place)
{
    items->count = place.before;
    if (items->walk.before >= items->count)
        items->walk = place;
}

static void item_cut(void *state, const uint32_t *operands)
{
    struct items *items = state;
    chunk_list_cut(&items->list, items->mark.place);
    item_cut_to(items, items->mark);
}

static void item_clear(void *state, const uint32_t *operands)
{
    struct items *items = state;
    chunk_list_clear(&items->list);
    items->mark = items->walk = (struct item_place){{NULL, NULL}, 0};
    item_cut_to(items, items->mark);
}

/* A walk goes on where it was, and ends at the mark if that comes first. */
static void item_walk(void *state, const uint32_t *operands)
{
    struct items *items = state;
    const struct item_place end = items_end(items);
    expect_items(items, &items->walk,
                 operands[0] && items->mark.before > items->walk.before ? &items->mark : &end);
}

static void items_check(void *state)
{
    const struct items *items = state;
    const struct item_place end = items_end(items);
    struct item_place begin = {{NULL, NULL}, 0};
    expect_items(items, &begin, &end);
    EXPECT_EQUAL(chunk_list_is_empty(&items->list), items->count == 0);
}

static void items_end_all(void *state)
{
    chunk_list_free(&((struct items *)state)->list);
}

PROPERTY_TEST(chunk_list, .size = sizeof(struct items), .check = items_check, .end = items_end_all,
              .operations = {{"add", item_add, {AT_ONCE + 1}, 40, .scarce = 20},
                             {"mark", item_mark, {0}, 3},
                             {"cut", item_cut, {0}, 2},
                             {"clear", item_clear, {0}, 1, 0},
                             {"walk", item_walk, {2}, 4}},
              .sequences = 60, .steps = 600, .check_steps = 7)

/* ---- arrays */

/* One more doubling would wrap: that is out of memory, too. */
TEST(a_capacity_never_wraps)
{
    uint32_t capacity = UINT32_MAX / 2 + 1;
    char *bytes = NULL;
    assert_false(ARRAY_HAS_ROOM(bytes, capacity, capacity));
    assert_null(bytes);
    assert_int_equal(capacity, UINT32_MAX / 2 + 1);
}
