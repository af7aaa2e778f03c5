/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of calls of which it is plain, before any search, that there is nothing to find. */
#include "random.h"
#include "tests/state/sweep_fixture.h"
#include "tests/state/unit_test.h"

enum { PLACE = 64, PLACES = 40 };

/* A build of a structure that has a place of its own. Handles aren't in the order of places. */
static void add_build(struct random *random, struct sweep *sweep, uint32_t build, uint32_t place,
                      bool is_unknown)
{
    const uint32_t begin = place * PLACE;
    const uint32_t end = begin + PLACE + (random_one_in(random, 60) ? 8 : 0);
    const uint32_t handle = 1 + place * 7 % (PLACES + 1);
    if (is_unknown)
        add_range(sweep, range_of(ROLE_DST, build, handle, 0, 0, 0));
    else
        add_range(sweep, range_of(ROLE_DST, build, handle, 1, begin, end));
    if (!random_one_in(random, 4))
        add_range(sweep, range_of(ROLE_SCRATCH, build, 0, 2, begin, end));
    if (random_one_in(random, 60))
        add_range(sweep, range_of(ROLE_SRC, build, 1 + random_below(random, PLACES), 0, 0, 0));
}

/* Some builds meet. */
static void make_random(struct random *random, struct sweep *sweep)
{
    const bool in_order = random_one_in(random, 2), has_unknown = random_one_in(random, 4);
    const uint32_t builds = 1 + random_below(random, 12);
    sweep_init(sweep);
    for (uint32_t build = 0; build < builds; build++) {
        const bool is_next = in_order && !random_one_in(random, 30);
        add_build(random, sweep, build, is_next ? build : random_below(random, PLACES),
                  has_unknown && random_one_in(random, 4));
    }
}

TEST(test_plain_calls_have_no_pairs)
{
    struct random random = random_of("sweep_plain");
    uint32_t plain = 0, without_pairs = 0;
    for (int round = 0; round < 4000; round++) {
        struct sweep sweep;
        make_random(&random, &sweep);
        const bool is_plain = sweep_finds_nothing(&sweep);
        const uint32_t pairs = count_pairs(&sweep);
        if (is_plain)
            assert_int_equal(pairs, 0);
        plain += is_plain;
        without_pairs += pairs == 0;
        sweep_release(&sweep);
    }
    assert_in_range(plain, without_pairs / 2, without_pairs);
    assert_in_range(without_pairs, 1000, 3500);
}
