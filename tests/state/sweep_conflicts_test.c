/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the sweep over ranges that are all in conflict: it stays linear. */
#include "src/check/overlap/sweep.h"
#include "tests/state/sweep_fixture.h"
#include "tests/state/unit_test.h"

/* Builds of one call that all have one structure as dst, update it, use it as an instance and a
 * micromap, and have one scratch; or the same with structures of their own, on the same memory. */
static uint32_t pairs_of_conflicts(uint32_t builds, bool one_structure)
{
    struct sweep sweep;
    sweep_init(&sweep);
    for (uint32_t i = 0; i < builds; i++) {
        uintptr_t handle = one_structure ? 7 : 7 + i;
        struct used_range src = range_of(ROLE_SRC, i, handle, 1, 0, 100);
        add_range(&sweep, range_of(ROLE_DST, i, handle, 1, 0, 100));
        add_range(&sweep, range_of(ROLE_SCRATCH, i, 0, 1, 50, 150));
        sweep_add(&sweep, &src);
        src.is_micromap = true;
        sweep_add(&sweep, &src);
        src.is_micromap = false;
        src.is_instance = true;
        sweep_add(&sweep, &src);
    }
    const uint32_t pairs = count_pairs(&sweep);
    sweep_release(&sweep);
    return pairs;
}

/* However many builds there are: as many pairs a build, also if all pairs are wanted. */
TEST(test_conflicts_cost_no_square)
{
    enum { MANY = 20000, KINDS = 5 };
    for (int one_structure = 0; one_structure < 2; one_structure++) {
        uint32_t pairs = pairs_of_conflicts(MANY, one_structure);
        assert_true(pairs > MANY);
        assert_true(pairs <= (uint32_t)MANY * SWEEP_PARTNERS * KINDS * 2);
        uint32_t twice = pairs_of_conflicts(2 * MANY, one_structure);
        assert_true(twice < 2 * pairs + MANY);
    }
}

/* What conflicts with a range that begins last of all is found behind any number of others. */
TEST(test_conflicts_hide_no_other)
{
    enum { MANY = 1000 };
    struct sweep sweep;
    uint32_t pairs = 0;
    sweep_init(&sweep);
    for (uint32_t i = 0; i < MANY; i++) /* of one structure, so no pairs of shared memory */
        add_range(&sweep, range_of(ROLE_DST, i, 7, 1, 0, 100));
    add_range(&sweep, range_of(ROLE_DST, MANY, 8, 1, 10, 200));
    sweep_shared_memory(&sweep, count_pair, &pairs);
    assert_int_equal(pairs, SWEEP_PARTNERS);
    add_range(&sweep, range_of(ROLE_SCRATCH, MANY, 0, 1, 150, 160));
    sweep_shared_memory(&sweep, count_pair, &pairs);
    assert_int_equal(pairs, 2 * SWEEP_PARTNERS + 1);
    sweep_release(&sweep);
}
