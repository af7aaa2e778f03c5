/* SPDX-License-Identifier: Apache-2.0 */
/* What structures were built with, asked for turns that have passed. */
#include "src/state/builds/built_flags.h"
#include "tests/state/unit_test.h"

enum { QUEUE = 1, OTHER_QUEUE = 2, ID = 7 };

static void write_flag(struct built_flags *flags, bool allows, struct timestamp timestamp)
{
    const struct built built = {
        .state = BUILT_BEFORE,
        .flags =
            allows ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR : 0};
    built_flags_write(flags, ID, &built, timestamp);
}

static struct timestamp batch(uint64_t count)
{
    return (struct timestamp){QUEUE, count};
}

/* Of a build in a batch that follows all of its queue. */
static struct execution_point turn_in(struct built_flags *flags, struct timestamp now)
{
    struct execution_point serial = {.serial = built_flags_now(flags), .now = now};
    execution_clock_add(&serial.follows, (struct timestamp){now.queue, now.count - 1});
    return serial;
}

static enum tristate ask(struct built_flags *flags, struct execution_point serial)
{
    return built_flags_allow_disabling(flags, ID, &serial);
}

#define FLAGS_TEST(name)                                                                           \
    TEST_WITH(name, struct built_flags *flags, built_flags_create, built_flags_destroy)

FLAGS_TEST(test_latest)
{
    assert_int_equal(ask(flags, turn_in(flags, batch(1))), UNKNOWN);
    write_flag(flags, true, batch(1));
    assert_int_equal(ask(flags, turn_in(flags, batch(1))), YES);
    assert_int_equal(ask(flags, turn_in(flags, batch(2))), YES);
    write_flag(flags, false, batch(2));
    assert_int_equal(ask(flags, turn_in(flags, batch(2))), NO);
    built_flags_forget(flags, ID);
    assert_int_equal(ask(flags, turn_in(flags, batch(3))), UNKNOWN);
}

/* Written again with the same flag, it is still known; with another, no more. */
FLAGS_TEST(test_turns_that_have_passed)
{
    write_flag(flags, false, batch(1));
    const struct execution_point serial = turn_in(flags, batch(2));
    write_flag(flags, false, batch(3));
    assert_int_equal(ask(flags, serial), NO);
    write_flag(flags, true, batch(4));
    assert_int_equal(ask(flags, serial), UNKNOWN);
    write_flag(flags, false, batch(5));
    assert_int_equal(ask(flags, serial), UNKNOWN);
}

FLAGS_TEST(test_without_order)
{
    write_flag(flags, false, (struct timestamp){OTHER_QUEUE, 1});
    struct execution_point serial = turn_in(flags, batch(9));
    assert_int_equal(ask(flags, serial), UNKNOWN);
    execution_clock_add(&serial.follows, (struct timestamp){OTHER_QUEUE, 1});
    assert_int_equal(ask(flags, serial), NO);
    write_flag(flags, true, timestamp_never());
    assert_int_equal(ask(flags, turn_in(flags, batch(9))), UNKNOWN);
}

FLAGS_TEST(test_within_a_batch)
{
    struct execution_point before = turn_in(flags, batch(1));
    write_flag(flags, false, batch(1));
    struct execution_point after = turn_in(flags, batch(1));
    assert_int_equal(ask(flags, before), UNKNOWN);
    assert_int_equal(ask(flags, after), NO);
    after.is_unordered = true;
    assert_int_equal(ask(flags, after), UNKNOWN);
}

FLAGS_TEST(test_states_that_tell_nothing)
{
    write_flag(flags, true, batch(1));
    const struct built filled = {.state = BUILT_FILLED};
    built_flags_write(flags, ID, &filled, batch(2));
    assert_int_equal(ask(flags, turn_in(flags, batch(3))), UNKNOWN);
    write_flag(flags, true, batch(3));
    built_flags_forget_all(flags);
    assert_int_equal(ask(flags, turn_in(flags, batch(4))), UNKNOWN);
    assert_int_equal(built_flags_allow_disabling(flags, ID, NULL), UNKNOWN);
    built_flags_write(NULL, ID, &filled, batch(1));
    built_flags_forget(NULL, ID);
}
