/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of keeping builds that were found valid, as a table: see known_builds_random_test.c for
 * what is said of them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../report/scarce_memory.h"
#include "src/state/builds/known_builds.h"
#include "tests/state/fixture.h"

/* Builds a structure, and says whether it is kept now. */
static bool keep(struct known_builds *known, unsigned n)
{
    struct known_build *build = known_builds_room(known, accel(n));
    if (build)
        build->changes = n;
    return build;
}

static void assert_found(struct known_builds *known, unsigned n)
{
    const struct known_build *build = known_builds_find(known, accel(n));
    assert_non_null(build);
    assert_ptr_equal(build->dst, accel(n));
    assert_int_equal(build->changes, n);
}

static void test_what_is_built_again_is_kept(void **state)
{
    (void)state;
    struct known_builds known = {0};
    assert_null(known_builds_find(&known, accel(1)));
    assert_false(keep(&known, 1));
    assert_null(known_builds_find(&known, accel(1)));
    assert_true(keep(&known, 1));
    assert_found(&known, 1);
    assert_null(known_builds_find(&known, accel(2)));
    known_builds_release(&known);
    assert_null(known_builds_find(&known, accel(1)));
}

static void test_builds_are_found_in_any_order(void **state)
{
    (void)state;
    struct known_builds known = {0};
    enum { BUILDS = 100 };
    for (unsigned round = 0; round < 3; round++)
        for (unsigned n = 1; n <= BUILDS; n++)
            assert_int_equal(keep(&known, n), round > 0);
    assert_int_equal(known.count, BUILDS);
    for (unsigned n = 1; n <= BUILDS; n++)
        assert_found(&known, n);
    for (unsigned n = BUILDS; n; n--)
        assert_found(&known, n);
    for (unsigned n = 1; n <= BUILDS; n++)
        assert_found(&known, n * 37 % (BUILDS + 1));
    known_builds_release(&known);
}

/* The n-th of an order of its own for each round. */
static unsigned in_order_of(unsigned round, unsigned n, unsigned builds)
{
    static const unsigned steps[] = {1, 37, 61, 89};
    return 1 + n * steps[round % 4] % builds;
}

/* Builds that come out of date all the time, as a new scene has the handles of the one before, are
 * soon kept in the order in which they come now, as what comes next is guessed by that. */
static void test_what_is_kept_anew_is_in_its_new_order(void **state)
{
    (void)state;
    struct known_builds known = {0};
    enum { BUILDS = 1000, ROUNDS = 20, FEW = BUILDS / 50 };
    for (unsigned n = 0; n < BUILDS; n++)
        keep(&known, 1 + n);
    for (unsigned round = 0; round < ROUNDS; round++) {
        for (unsigned n = 0; n < BUILDS; n++)
            assert_true(keep(&known, in_order_of(round, n, BUILDS)));
        assert_in_range(known.capacity, BUILDS, 4 * BUILDS);
        unsigned guessed = 0;
        for (unsigned n = 0; n < BUILDS; n++) {
            const uint32_t next = known.next;
            assert_found(&known, in_order_of(round, n, BUILDS));
            guessed += known.next == next + 1;
        }
        assert_in_range(guessed, BUILDS - FEW, BUILDS);
    }
    known_builds_release(&known);
}

/* Where the order stays, or a few come out of it, all stay in their places. */
static void test_what_is_kept_again_stays_where_it_is(void **state)
{
    (void)state;
    struct known_builds known = {0};
    enum { BUILDS = 100, ROUNDS = 50 };
    for (unsigned round = 0; round < ROUNDS; round++) {
        for (unsigned n = 1; n <= BUILDS; n++)
            keep(&known, n);
        keep(&known, 1 + round);
    }
    assert_int_equal(known.count, BUILDS);
    known_builds_release(&known);
}

static void test_no_structure_is_not_found(void **state)
{
    (void)state;
    struct known_builds known = {0};
    enum { BUILDS = 100 };
    for (unsigned round = 0; round < 4; round++)
        for (unsigned n = 0; n < BUILDS; n++)
            keep(&known, in_order_of(round, n, BUILDS));
    for (unsigned n = 1; n <= BUILDS; n++) {
        assert_found(&known, n);
        const struct known_build *none = known_builds_find(&known, VK_NULL_HANDLE);
        assert_true(!none || none->changes == UINT64_MAX); /* which none is asked for with */
        assert_null(known_builds_room(&known, VK_NULL_HANDLE));
    }
    known_builds_release(&known);
}

static bool rests(struct known_builds *known, uint32_t found, uint32_t in_vain)
{
    if (known_builds_rest(known, found + in_vain))
        return true;
    known_builds_note(known, found, in_vain);
    return false;
}

/* Of builds of which so many of a hundred are found, and the others were kept in vain: how many of
 * a hundred are looked for. */
static unsigned looked_for(struct known_builds *known, unsigned found)
{
    enum { BUILDS = 400000 };
    unsigned looked = 0;
    for (unsigned i = 0; i < BUILDS; i++) {
        bool is_found = i % 100 < found;
        if (rests(known, is_found, !is_found))
            continue;
        looked++;
    }
    return looked / (BUILDS / 100);
}

static void test_what_is_mostly_kept_in_vain_is_seldom_looked_for(void **state)
{
    (void)state;
    struct known_builds known = {0};
    assert_in_range(looked_for(&known, 0), 0, 5);
    assert_in_range(looked_for(&known, 10), 0, 8);
    assert_in_range(looked_for(&known, 50), 95, 100); /* as soon as it pays */
    assert_in_range(looked_for(&known, 100), 100, 100);
    assert_in_range(looked_for(&known, 0), 0, 5);
}

static void test_what_is_kept_is_in_vain_until_it_is_found(void **state)
{
    (void)state;
    struct known_builds known = {0};
    keep(&known, 1);
    assert_true(keep(&known, 1));
    assert_true(known_builds_find(&known, accel(1))->in_vain);
    known_builds_find(&known, accel(1))->in_vain = false; /* as who recalls it does */
    assert_false(known_builds_find(&known, accel(1))->in_vain);
    assert_true(keep(&known, 1));
    assert_true(known_builds_find(&known, accel(1))->in_vain);
    known_builds_release(&known);
}

static void test_one_at_a_time_takes_them(void **state)
{
    (void)state;
    struct known_builds known = {0};
    assert_ptr_equal(known_builds_take(&known), &known);
    assert_null(known_builds_take(&known));
    known_builds_give_back(NULL);
    assert_null(known_builds_take(&known));
    known_builds_give_back(&known);
    assert_ptr_equal(known_builds_take(&known), &known);
}

/* Structures come and go, and their handles don't come again. */
static void test_no_more_is_kept_than_a_few_times_what_is_alive(void **state)
{
    (void)state;
    struct known_builds known = {0};
    enum { ALIVE = 500, ALL = 20000 };
    for (unsigned n = 1; n <= ALL; n++) {
        if (known_builds_wants_trim(&known))
            known_builds_trim(&known, ALIVE);
        keep(&known, n);
        assert_true(keep(&known, n));
        assert_in_range(known.by_dst.count, 1, 4 * ALIVE + KNOWN_KEEPS_BEFORE_TRIM);
        assert_in_range(known.count, 1, 4 * ALIVE + KNOWN_KEEPS_BEFORE_TRIM);
    }
    assert_found(&known, ALL);
    known_builds_release(&known);
}

/* Those that are alive are all kept. */
static void test_what_is_alive_is_kept(void **state)
{
    (void)state;
    struct known_builds known = {0};
    enum { ALIVE = 5000 };
    for (unsigned round = 0; round < 2; round++) {
        for (unsigned n = 1; n <= ALIVE; n++) {
            if (known_builds_wants_trim(&known))
                known_builds_trim(&known, ALIVE);
            keep(&known, n);
        }
    }
    assert_int_equal(known.count, ALIVE);
    known_builds_release(&known);
}

static void test_without_memory_less_is_kept(void **state)
{
    (void)state;
    enum { BUILDS = 40 };
    for (int after = 0; after < 40; after++) {
        struct known_builds known = {0};
        unsigned kept = 0;
        memory_fail_after(after);
        for (unsigned round = 0; round < 2; round++)
            for (unsigned n = 1; n <= BUILDS; n++)
                kept += keep(&known, n);
        if (!memory_fail_no_more())
            assert_int_equal(kept, BUILDS);
        assert_in_range(kept, BUILDS - 1, BUILDS);
        for (unsigned n = 1; n <= BUILDS; n++)
            if (known_builds_find(&known, accel(n)))
                assert_found(&known, n);
        known_builds_release(&known);
    }
}

static void test_without_memory_what_is_kept_stays_found(void **state)
{
    (void)state;
    enum { BUILDS = 42, ROUNDS = 12 }; /* as many as fill a table */
    for (int after = 0; after < 10; after++) {
        struct known_builds known = {0};
        for (unsigned round = 0; round < 2; round++)
            for (unsigned n = 1; n <= BUILDS; n++)
                keep(&known, n);
        memory_fail_after(after);
        for (unsigned round = 0; round < ROUNDS; round++)
            for (unsigned n = 0; n < BUILDS; n++)
                assert_true(keep(&known, in_order_of(round, n, BUILDS)));
        memory_fail_no_more();
        for (unsigned n = 1; n <= BUILDS; n++)
            assert_found(&known, n);
        known_builds_release(&known);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_is_built_again_is_kept),
        cmocka_unit_test(test_builds_are_found_in_any_order),
        cmocka_unit_test(test_what_is_kept_anew_is_in_its_new_order),
        cmocka_unit_test(test_what_is_kept_again_stays_where_it_is),
        cmocka_unit_test(test_no_structure_is_not_found),
        cmocka_unit_test(test_what_is_mostly_kept_in_vain_is_seldom_looked_for),
        cmocka_unit_test(test_what_is_kept_is_in_vain_until_it_is_found),
        cmocka_unit_test(test_one_at_a_time_takes_them),
        cmocka_unit_test(test_no_more_is_kept_than_a_few_times_what_is_alive),
        cmocka_unit_test(test_what_is_alive_is_kept),
        cmocka_unit_test(test_without_memory_less_is_kept),
        cmocka_unit_test(test_without_memory_what_is_kept_stays_found),
    };
    return cmocka_run_group_tests_name("known builds", tests, NULL, NULL);
}
