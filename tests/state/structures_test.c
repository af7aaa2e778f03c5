/* SPDX-License-Identifier: Apache-2.0 */
/* What no program shows of structures: flags at past execution points, inputs of structures that
 * are copied or destroyed, and records that one thread uses while another one adds them. */
#include <pthread.h>

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

/* ---- a thread that delivers reads and changes what is known of structures, while the writer adds,
 * removes and changes records. The thread sanitizer sees whether that is synchronized. */

enum { STRUCTURES = 2000 };

static struct structures *shared;
static atomic_uint written; /* ids up to this one have records */

static void *write_structures(void *unused)
{
    const struct built built = {.state = BUILT_BEFORE};
    (void)unused;
    for (uint32_t id = 1; id <= STRUCTURES; id++) {
        assert_true(structures_set(shared, id, &built, (struct timestamp){QUEUE, id}));
        assert_true(structures_add_writer(shared, id));
        uses_note_build(shared, id, id, 0, 0);
        structures_note_first_build(shared, id, id);
        uses_copy_box(shared, id, id / 2);
        structures_remove_writer(shared, id);
        atomic_store(&written, id);
        if (id % 16 == 0) {
            structures_note_destroyed(shared, id, 1);
            structures_forget_destroyed(shared);
        }
    }
    return NULL;
}

static void deliver(uint32_t id)
{
    const struct execution_point point = {.now = {QUEUE, id}};
    const struct structure_contents contents = {.primitives = 1, .has_box = true};
    struct structure_uses uses;
    struct figure_box box;
    uint64_t serial;
    assert_true(uses_note(shared, id, USE_REFERRED_TO));
    uses_note_tiny(shared, id, true);
    uses_begin_read(shared, id);
    uses_note_input(shared, id, NULL);
    uses_note_shared(shared, id);
    uses_note_contents(shared, id, &contents);
    uses_find_box(shared, id, &box);
    uses_note_advised(shared, id, 1);
    uses_find(shared, id, &uses);
    structures_first_build(shared, id);
    structures_find_serial(shared, &serial);
    structures_allow_disabling(shared, id, &point);
    structures_were_written(shared, id, &point);
}

TEST(records_are_used_while_they_are_added)
{
    pthread_t writer;
    uint32_t id = 0;
    shared = structures_create(KEEPS_FLAGS, NULL);
    assert_non_null(shared);
    assert_int_equal(pthread_create(&writer, NULL, write_structures, NULL), 0);
    while (id < STRUCTURES) {
        id = atomic_load(&written);
        deliver(id + 1);
        deliver(id / 2 + 1);
    }
    assert_int_equal(pthread_join(writer, NULL), 0);
    structures_destroy(shared);
}
