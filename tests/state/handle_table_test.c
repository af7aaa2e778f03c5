/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the hash table from handles to records. */
#include "random.h"
#include "src/base/handle_table.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/unit_test.h"

enum { KEYS = 300 };

/* The naive table: the record of keys[i] is records[i]. */
struct model {
    uint64_t keys[KEYS];
    void *records[KEYS];
    size_t count;
};

static char bytes[KEYS * 4]; /* records are pointers into it */

static void count_record(void *record, void *context)
{
    struct model *seen = context;
    assert_non_null(record);
    seen->count++;
}

static void assert_equals(const struct handle_table *table, const struct model *model)
{
    struct model seen = {0};
    size_t occupied = 0;
    assert_int_equal(table->count, model->count);
    for (int i = 0; i < KEYS; i++)
        assert_ptr_equal(handle_table_find(table, model->keys[i]), model->records[i]);
    handle_table_each(table, count_record, &seen);
    assert_int_equal(seen.count, model->count);
    for (size_t i = 0; table->slots && i <= table->mask; i++)
        occupied += table->slots[i].handle != 0;
    assert_int_equal(occupied, model->count);
    if (table->slots)
        assert_true(table->count * 3 <= (table->mask + 1) * 2);
}

static void set(struct handle_table *table, struct model *model, int key, void *record)
{
    assert_true(handle_table_set(table, model->keys[key], record));
    model->count += !model->records[key];
    model->records[key] = record;
}

static void remove_key(struct handle_table *table, struct model *model, int key)
{
    assert_ptr_equal(handle_table_remove(table, model->keys[key]), model->records[key]);
    model->count -= model->records[key] != NULL;
    model->records[key] = NULL;
}

/* Counters, pointers, handles with their index in the high bits, and any number. */
static uint64_t some_key(struct random *random, int i)
{
    switch (i % 4) {
    case 0:
        return (uint64_t)i + 1;
    case 1:
        return 0x7f0000000000u + (uint64_t)i * 64;
    case 2:
        return (uint64_t)i << 32;
    default:
        return random_next(random) | 1;
    }
}

TEST(test_it_agrees_with_an_array)
{
    struct random random = random_of("handle_table");
    struct handle_table table = {0};
    struct model model = {0};
    for (int i = 0; i < KEYS; i++)
        model.keys[i] = some_key(&random, i);
    assert_equals(&table, &model);
    for (int step = 0; step < 60000; step++) {
        int key = (int)random_below(&random, KEYS);
        /* The share of removals changes, so that the table fills and empties. */
        if (random_below(&random, 100) < (uint32_t)(30 + step / 10000 * 8))
            remove_key(&table, &model, key);
        else
            set(&table, &model, key, &bytes[random_below(&random, sizeof(bytes))]);
        if (step % 100 == 0)
            assert_equals(&table, &model);
    }
    for (int i = 0; i < KEYS; i++)
        remove_key(&table, &model, i);
    assert_equals(&table, &model);
    handle_table_release(&table);
    assert_null(table.slots);
}

/* The slot that a key takes in an empty table. */
static size_t home_of(uint64_t key)
{
    struct handle_table table = {0};
    size_t home = 0;
    assert_true(handle_table_set(&table, key, bytes));
    while (!table.slots[home].handle)
        home++;
    handle_table_release(&table);
    return home;
}

/* Keys whose homes are the last two slots and the first two of the smallest table. */
static void fill_with_wrapping_keys(struct model *model, int count)
{
    uint64_t key = 1;
    for (int i = 0; i < count; key++) {
        size_t home = home_of(key);
        if (home <= 1 || home >= 62)
            model->keys[i++] = key;
    }
}

TEST(test_runs_that_wrap_around_stay_whole)
{
    enum { RUN = 30 }; /* of the keys; the others stay 0, which is in no table */
    struct random random = random_of("handle_table wrap");
    struct model model = {0};
    fill_with_wrapping_keys(&model, RUN);
    for (int round = 0; round < 200; round++) {
        struct handle_table table = {0};
        for (int i = 0; i < RUN; i++)
            set(&table, &model, i, &bytes[i]);
        assert_int_equal(table.mask, 63);
        for (int step = 0; step < 60; step++) {
            remove_key(&table, &model, (int)random_below(&random, RUN));
            if (random_one_in(&random, 3))
                set(&table, &model, (int)random_below(&random, RUN), &bytes[round]);
            assert_equals(&table, &model);
        }
        for (int i = 0; i < RUN; i++)
            remove_key(&table, &model, i);
        handle_table_release(&table);
    }
}

TEST(test_null_is_never_in_it)
{
    struct handle_table table = {0};
    assert_false(handle_table_set(&table, 0, bytes));
    assert_null(handle_table_find(&table, 0));
    assert_null(handle_table_remove(&table, 0));
    assert_true(handle_table_set(&table, 5, bytes));
    assert_false(handle_table_set(&table, 0, bytes));
    assert_null(handle_table_find(&table, 0));
    assert_null(handle_table_remove(&table, 0));
    assert_int_equal(table.count, 1);
    handle_table_release(&table);
}

TEST(test_without_memory_it_stays_as_it_was)
{
    struct handle_table table = {0};
    struct model model = {0};
    unsigned failures = 0;
    for (int i = 0; i < KEYS; i++)
        model.keys[i] = (uint64_t)i * 16 + 8;
    for (int i = 0; i < KEYS; i++) {
        memory_fail_after(0);
        bool kept = handle_table_set(&table, model.keys[i], &bytes[i]);
        if (memory_fail_no_more()) {
            assert_false(kept);
            assert_equals(&table, &model);
            failures++;
            set(&table, &model, i, &bytes[i]);
            continue;
        }
        assert_true(kept);
        model.records[i] = &bytes[i];
        model.count++;
    }
    assert_equals(&table, &model);
    assert_true(failures >= 3);
    handle_table_release(&table);
}

/* Removing needs no memory, and makes room for as many again. */
TEST(test_what_was_removed_can_be_set_without_memory)
{
    struct handle_table table = {0};
    for (uint64_t key = 1; key <= 42; key++)
        assert_true(handle_table_set(&table, key, bytes));
    WITHOUT_MEMORY(assert_false(handle_table_set(&table, 43, bytes)));
    for (uint64_t key = 1; key <= 42; key++) {
        memory_fail_after(0);
        assert_ptr_equal(handle_table_remove(&table, key), bytes);
        assert_true(handle_table_set(&table, key + 100, bytes));
        assert_false(memory_fail_no_more());
    }
    handle_table_release(&table);
}

/* As full as it gets before it grows. */
TEST(test_a_record_is_replaced_without_memory)
{
    struct handle_table table = {0};
    for (uint64_t key = 1; key <= 42; key++)
        assert_true(handle_table_set(&table, key, bytes));
    for (uint64_t key = 1; key <= 42; key++) {
        ALLOCATES_NOTHING(assert_true(handle_table_set(&table, key, &bytes[key])));
        assert_ptr_equal(handle_table_find(&table, key), &bytes[key]);
    }
    assert_int_equal(table.count, 42);
    handle_table_release(&table);
}

TEST(test_few_are_not_spread_over_many_slots)
{
    enum { MANY = 5000, FEW = 100 };
    for (int is_scarce = 0; is_scarce < 2; is_scarce++) {
        struct handle_table table = {0};
        for (uint64_t key = 1; key <= MANY; key++)
            assert_true(handle_table_set(&table, key, &bytes[key % sizeof(bytes)]));
        for (uint64_t key = FEW + 1; key <= MANY; key++) {
            if (is_scarce)
                memory_fail_after(0);
            assert_ptr_equal(handle_table_remove(&table, key), &bytes[key % sizeof(bytes)]);
            memory_fail_no_more();
        }
        for (uint64_t key = 1; key <= MANY; key++)
            assert_ptr_equal(handle_table_find(&table, key), key <= FEW ? &bytes[key] : NULL);
        assert_int_equal(table.count, FEW);
        if (is_scarce)
            assert_true(table.mask >= MANY);
        else
            assert_in_range(table.mask, FEW, 8 * FEW);
        handle_table_release(&table);
    }
}

static size_t longest_run(const struct handle_table *table)
{
    size_t longest = 0, run = 0;
    for (size_t i = 0; i < 2 * (table->mask + 1); i++) {
        run = table->slots[i & table->mask].handle ? run + 1 : 0;
        if (run > longest)
            longest = run;
    }
    return longest;
}

/* Drivers make handles of pointers, and of indices shifted to any place: all have to spread. */
TEST(test_regular_handles_spread)
{
    for (unsigned shift = 0; shift <= 48; shift++) {
        struct handle_table table = {0};
        for (uint64_t i = 1; i <= 5000; i++)
            assert_true(handle_table_set(&table, i << shift, bytes));
        size_t longest = longest_run(&table);
        handle_table_release(&table);
        if (longest > 200)
            fail_msg("handles of a multiple of 2^%u make runs of %zu slots", shift, longest);
    }
}
