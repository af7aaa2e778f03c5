/* SPDX-License-Identifier: Apache-2.0 */
/* What is known of structures: flags at past execution points, first builds, inputs, and what is
 * undone. */
#include "src/advice/uses.h"
#include "tests/unit/unit_test.h"

enum { QUEUE = 1, OTHER_QUEUE = 2, ID = 7, COPY_ID, OTHER_ID };

static struct structures *with_flags(void)
{
    return structures_create(KEEPS_FLAGS, NULL);
}

static void write_flag(struct structures *structures, bool allows, struct timestamp timestamp)
{
    const struct built built = {
        .state = BUILT_BEFORE,
        .flags =
            allows ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR : 0};
    assert_true(structures_set(structures, ID, &built, timestamp));
}

static struct timestamp batch(uint64_t count)
{
    return (struct timestamp){QUEUE, count};
}

/* The point of a build whose batch follows all earlier batches of its queue. */
static struct execution_point turn_in(const struct structures *structures, struct timestamp now)
{
    struct execution_point point = {.now = now};
    assert_true(structures_find_serial(structures, &point.serial));
    execution_clock_add(&point.follows, (struct timestamp){now.queue, now.count - 1});
    return point;
}

static enum tristate ask(const struct structures *structures, struct execution_point point)
{
    return structures_allow_disabling(structures, ID, &point);
}

#define FLAGS_TEST(name)                                                                           \
    TEST_WITH(name, struct structures *structures, with_flags, structures_destroy)

FLAGS_TEST(test_latest)
{
    assert_int_equal(ask(structures, turn_in(structures, batch(1))), UNKNOWN);
    write_flag(structures, true, batch(1));
    assert_int_equal(ask(structures, turn_in(structures, batch(1))), YES);
    assert_int_equal(ask(structures, turn_in(structures, batch(2))), YES);
    write_flag(structures, false, batch(2));
    assert_int_equal(ask(structures, turn_in(structures, batch(2))), NO);
    assert_true(structures_add_writer(structures, ID));
    assert_int_equal(ask(structures, turn_in(structures, batch(3))), UNKNOWN);
}

/* Written again with the same flag, it is still known; with another, no more. */
FLAGS_TEST(test_turns_that_have_passed)
{
    write_flag(structures, false, batch(1));
    const struct execution_point serial = turn_in(structures, batch(2));
    write_flag(structures, false, batch(3));
    assert_int_equal(ask(structures, serial), NO);
    write_flag(structures, true, batch(4));
    assert_int_equal(ask(structures, serial), UNKNOWN);
    write_flag(structures, false, batch(5));
    assert_int_equal(ask(structures, serial), UNKNOWN);
}

FLAGS_TEST(test_without_order)
{
    write_flag(structures, false, (struct timestamp){OTHER_QUEUE, 1});
    struct execution_point serial = turn_in(structures, batch(9));
    assert_int_equal(ask(structures, serial), UNKNOWN);
    execution_clock_add(&serial.follows, (struct timestamp){OTHER_QUEUE, 1});
    assert_int_equal(ask(structures, serial), NO);
    write_flag(structures, true, timestamp_never());
    assert_int_equal(ask(structures, turn_in(structures, batch(9))), UNKNOWN);
}

FLAGS_TEST(test_within_a_batch)
{
    struct execution_point before = turn_in(structures, batch(1));
    write_flag(structures, false, batch(1));
    struct execution_point after = turn_in(structures, batch(1));
    assert_int_equal(ask(structures, before), UNKNOWN);
    assert_int_equal(ask(structures, after), NO);
    after.is_unordered = true;
    assert_int_equal(ask(structures, after), UNKNOWN);
}

FLAGS_TEST(test_states_that_tell_nothing)
{
    const struct built filled = {.state = BUILT_FILLED};
    uint64_t serial;
    write_flag(structures, true, batch(1));
    assert_true(structures_set(structures, ID, &filled, batch(2)));
    assert_int_equal(ask(structures, turn_in(structures, batch(3))), UNKNOWN);
    write_flag(structures, true, batch(3));
    assert_int_equal(structures_allow_disabling(structures, ID, NULL), UNKNOWN);
    structures_release(structures);
    assert_int_equal(ask(structures, turn_in(structures, batch(4))), UNKNOWN);
    assert_false(structures_find_serial(NULL, &serial));
}

/* ---- commands that fail */

FLAGS_TEST(test_undo)
{
    const struct built built = {.state = BUILT_BEFORE, .position = 5}, later = {.position = 6};
    write_flag(structures, true, batch(1));
    struct structure *structure = structures_find(structures, ID);
    assert_true(structures_note_undo(structures, OTHER_ID, NULL));
    assert_true(structures_set(structures, OTHER_ID, &built, batch(2)));
    for (int i = 0; i < 2; i++) {
        assert_true(structures_note_undo(structures, ID, structure));
        assert_true(structures_set(structures, ID, &later, batch(2)));
    }
    structures_undo(structures);
    assert_null(structures_find(structures, OTHER_ID));
    assert_int_equal(structure->built.state, BUILT_BEFORE);
    assert_int_equal(structure->written.count, 1);
    assert_int_equal(ask(structures, turn_in(structures, batch(3))), UNKNOWN);
    assert_true(structures_note_undo(structures, ID, structure));
    assert_true(structures_set(structures, ID, &later, batch(3)));
    structures_keep(structures);
    structures_undo(structures);
    assert_int_equal(structure->built.position, 6);
}

/* ---- first builds */

FLAGS_TEST(test_first_build)
{
    assert_int_equal(structures_first_build(structures, ID), STRUCTURE_NEVER_BUILT);
    write_flag(structures, true, batch(1));
    assert_int_equal(structures_first_build(structures, ID), STRUCTURE_NEVER_BUILT);
    assert_true(structures_note_first_build(structures, ID, 3));
    assert_false(structures_note_first_build(structures, ID, 4));
    assert_int_equal(structures_first_build(structures, ID), 3);
    structures_release(structures);
    assert_int_equal(structures_first_build(structures, ID), 0);
    assert_true(structures_note_first_build(structures, ID, 5));
}

/* ---- structures without contents */

static enum structure_written written_at(const struct structures *structures,
                                         struct execution_point point)
{
    return structures_were_written(structures, ID, &point);
}

FLAGS_TEST(test_first_write)
{
    struct execution_point before = turn_in(structures, batch(3)), other = before;
    other.now.queue = OTHER_QUEUE;
    assert_int_equal(written_at(structures, before), WRITTEN_NEVER);
    assert_int_equal(structures_were_written(structures, ID, NULL), WRITTEN_PERHAPS);
    assert_int_equal(structures_were_written(structures, 0, &before), WRITTEN_PERHAPS);
    assert_int_equal(structures_were_written(NULL, ID, &before), WRITTEN_PERHAPS);
    write_flag(structures, true, batch(3));
    const struct execution_point between = turn_in(structures, batch(3));
    write_flag(structures, true, (struct timestamp){OTHER_QUEUE, 1});
    assert_int_equal(written_at(structures, before), WRITTEN_LATER);
    assert_int_equal(written_at(structures, between), WRITTEN_PERHAPS);
    assert_int_equal(written_at(structures, other), WRITTEN_PERHAPS);
    before.is_unordered = true;
    assert_int_equal(written_at(structures, before), WRITTEN_PERHAPS);
    structures_release(structures);
    assert_int_equal(written_at(structures, between), WRITTEN_PERHAPS);
}

/* A host command that has begun writes at an unknown time. */
FLAGS_TEST(test_first_write_by_the_host)
{
    const struct execution_point before = turn_in(structures, batch(1));
    assert_true(structures_add_writer(structures, ID));
    assert_int_equal(written_at(structures, before), WRITTEN_PERHAPS);
    write_flag(structures, true, batch(1));
    assert_int_equal(written_at(structures, before), WRITTEN_PERHAPS);
}

/* ---- inputs, which are numbers of references here */

static void *share_number(void *input)
{
    ++*(int *)input;
    return input;
}

static void release_number(void *input)
{
    --*(int *)input;
}

static struct structures *with_inputs(void)
{
    static const struct structure_inputs inputs = {share_number, release_number};
    return structures_create(KEEPS_NOTHING, &inputs);
}

#define INPUTS_TEST(name)                                                                          \
    TEST_WITH(name, struct structures *structures, with_inputs, structures_destroy)

static bool has_input(const struct structures *structures, uint64_t id, int *input)
{
    int *found = structures_find_input(structures, id);
    if (found)
        release_number(found);
    return found == input;
}

/* A copy has the input of its source, also one that becomes known later, until it is written. */
INPUTS_TEST(test_inputs_of_copies)
{
    const struct built built = {.state = BUILT_BEFORE};
    static int first = 1, second = 1;
    assert_true(structures_set(structures, ID, &built, batch(1)));
    assert_true(structures_set(structures, COPY_ID, &built, batch(1)));
    structures_copy_input(structures, COPY_ID, ID);
    structures_copy_input(structures, OTHER_ID, ID);
    assert_true(has_input(structures, COPY_ID, NULL));
    structures_set_input(structures, ID, &first);
    assert_true(has_input(structures, COPY_ID, &first));
    structures_copy_input(structures, COPY_ID, ID);
    structures_set_input(structures, ID, &second);
    assert_true(has_input(structures, COPY_ID, &first));
    assert_true(structures_set(structures, COPY_ID, &built, batch(2)));
    structures_set_input(structures, COPY_ID, NULL);
    assert_true(has_input(structures, COPY_ID, NULL));
    assert_int_equal(first, 0);
    structures_release(structures);
    assert_int_equal(second, 0);
}

/* Executions that were not read yet may have used a destroyed structure. */
INPUTS_TEST(test_inputs_of_destroyed_structures)
{
    const struct built built = {.state = BUILT_BEFORE};
    static int first = 1, late = 1;
    for (uint64_t id = ID; id <= OTHER_ID; id++)
        assert_true(structures_set(structures, id, &built, batch(1)));
    structures_copy_input(structures, OTHER_ID, COPY_ID);
    structures_set_input(structures, ID, &first);
    structures_note_destroyed(structures, ID, 2);
    structures_note_destroyed(structures, 0, 1);
    structures_forget_destroyed(structures);
    assert_null(structures_find(structures, ID));
    assert_non_null(structures_find(structures, OTHER_ID));
    structures_set_input(structures, COPY_ID, &late);
    assert_true(has_input(structures, ID, &first));
    assert_true(has_input(structures, OTHER_ID, &late));
    structures_release_other_inputs(structures);
    assert_int_equal(first + late, 0);
    assert_true(has_input(structures, ID, NULL));
}

/* ---- contents, for setting advice */

/* Data that a ray can hit is judged at the powers of eight alone. */
FLAGS_TEST(test_builds_that_are_judged)
{
    const struct structure_contents solid = {.primitives = 2, .inactive = 1};
    assert_false(uses_begin_read(structures, ID).is_judged); /* no record */
    write_flag(structures, false, batch(1));
    assert_true(uses_note_build(structures, ID, 0, 0, 0));
    for (unsigned i = 1; i <= 70; i++) {
        const bool is_power = i == 1 || i == 8 || i == 64;
        assert_int_equal(uses_begin_read(structures, ID).is_judged, is_power);
        uses_note_contents(structures, ID, &solid);
    }
}

/* Until something can be hit, or a build is not judged, each one is. */
FLAGS_TEST(test_hollow_builds)
{
    const struct structure_contents hollow = {.primitives = 3, .inactive = 1, .invisible = 2},
                                    nothing = {0};
    struct structure_uses uses;
    write_flag(structures, false, batch(1));
    assert_true(uses_note_build(structures, ID, 0, 0, 0));
    for (unsigned i = 0; i < 5; i++) {
        assert_true(uses_begin_read(structures, ID).is_judged);
        uses_note_contents(structures, ID, i == 4 ? &hollow : &nothing);
    }
    assert_true(uses_find(structures, ID, &uses));
    assert_int_equal(uses.hollow_builds, 5);
    assert_int_equal(uses.contents.primitives, 3);
    assert_true(uses_begin_read(structures, ID).is_judged); /* whose contents stay unknown */
    assert_false(uses_begin_read(structures, ID).is_judged);
    assert_true(uses_begin_read(structures, ID).is_judged); /* the eighth */
}

static struct structure_uses note_input(struct structures *structures,
                                        const struct input_digest *digest)
{
    struct structure_uses uses = {0};
    uses_note_input(structures, ID, digest);
    uses_find(structures, ID, &uses);
    return uses;
}

/* As if the builds between were not compared. */
static void skip_builds(struct structures *structures, unsigned count)
{
    while (count--)
        uses_begin_read(structures, ID);
}

static void next_input(struct structures *structures, const struct input_digest *digest,
                       uint32_t since, uint32_t equal_ones)
{
    skip_builds(structures, 1);
    const struct structure_uses uses = note_input(structures, digest);
    assert_int_equal(uses.repeats.since, since);
    assert_int_equal(uses.repeats.equal_ones, equal_ones);
}

FLAGS_TEST(test_repeated_input)
{
    const struct input_digest one = {.words = {1, 2}}, two = {.words = {1, 3}},
                              three = {.words = {2, 3}};
    assert_false(uses_note_input(structures, ID, &one)); /* no record */
    write_flag(structures, false, batch(1));
    assert_true(uses_note_build(structures, ID, 0, 0, 0));
    next_input(structures, &one, 1, 0);
    next_input(structures, &one, 1, 1);
    skip_builds(structures, 2);
    next_input(structures, &one, 1, 1); /* not just before */
    next_input(structures, &one, 1, 2);
    next_input(structures, &two, 7, 0);
    next_input(structures, &three, 8, 0);
    next_input(structures, &three, 8, 1);
    next_input(structures, NULL, 10, 0);
    next_input(structures, &three, 11, 0);
    next_input(structures, &three, 11, 1);
}

FLAGS_TEST(test_memory_that_is_shared)
{
    const struct input_digest digest = {.words = {1, 2}};
    unsigned asked = 0;
    write_flag(structures, false, batch(1));
    assert_true(uses_note_build(structures, ID, 0, 0, 0));
    for (int i = 0; i < 10; i++) {
        skip_builds(structures, 1);
        asked += uses_note_input(structures, ID, &digest);
    }
    assert_int_equal(asked, 4); /* when 1, 2, 4 and 8 were equal */
    uses_note_shared(structures, OTHER_ID);
    assert_false(note_input(structures, &digest).repeats.is_shared);
    uses_note_shared(structures, ID);
    assert_true(note_input(structures, &digest).repeats.is_shared);
}

/* Only between two writes that follow each other do the structures that it refers to stay. */
FLAGS_TEST(test_repeated_input_of_a_top_level)
{
    struct input_digest digest = {.words = {1, 2}, .serial = 7, .is_top = true};
    write_flag(structures, false, batch(1));
    assert_true(uses_note_build(structures, ID, 0, 0, 0));
    next_input(structures, &digest, 1, 0);
    digest.serial = 8;
    next_input(structures, &digest, 1, 1);
    digest.serial = 10;
    next_input(structures, &digest, 3, 0);
    digest.serial = 13;
    skip_builds(structures, 2);
    next_input(structures, &digest, 3, 0);
    digest.serial = 14;
    next_input(structures, &digest, 3, 1);
    digest.serial = 17;
    skip_builds(structures, 1);
    next_input(structures, &digest, 9, 0);
    digest.is_top = false;
    next_input(structures, &digest, 10, 0);
}

FLAGS_TEST(test_builds_that_are_compared)
{
    static const unsigned numbers[] = {1, 2, 3, 4, 5, 8, 9, 16, 17, 32, 33, 64, 65, 127, 128, 129};
    const size_t count = sizeof(numbers) / sizeof(numbers[0]);
    size_t compared = 0;
    write_flag(structures, false, batch(1));
    assert_true(uses_note_build(structures, ID, 0, 0, 0));
    for (unsigned i = 1; i < 200; i++)
        if (uses_begin_read(structures, ID).is_compared)
            assert_int_equal(numbers[compared++ % count], i);
    assert_int_equal(compared, count);
}

FLAGS_TEST(test_advice_is_given_once)
{
    assert_false(uses_note_advised(structures, ID, 1));
    write_flag(structures, false, batch(1));
    assert_true(uses_note_build(structures, ID, 0, 0, 0));
    assert_true(uses_note_advised(structures, ID, 1));
    assert_false(uses_note_advised(structures, ID, 1));
    assert_true(uses_note_advised(structures, ID, 40));
    assert_false(uses_note_advised(structures, OTHER_ID, 1));
}
