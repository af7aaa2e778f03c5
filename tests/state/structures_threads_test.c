/* SPDX-License-Identifier: Apache-2.0 */
/* A thread that delivers reads and changes what is known of structures, while the writer adds,
 * removes and changes records. The thread sanitizer sees whether that is synchronized. */
#include <pthread.h>

#include "src/advice/uses.h"
#include "tests/unit/unit_test.h"

enum { STRUCTURES = 2000, QUEUE = 1 };

static struct structures *structures;
static atomic_uint written; /* ids up to this one have records */

static void *write_structures(void *unused)
{
    const struct built built = {.state = BUILT_BEFORE};
    (void)unused;
    for (uint32_t id = 1; id <= STRUCTURES; id++) {
        assert_true(structures_set(structures, id, &built, (struct timestamp){QUEUE, id}));
        assert_true(structures_add_writer(structures, id));
        uses_note_build(structures, id, id, 0, 0);
        structures_note_first_build(structures, id, id);
        uses_copy_box(structures, id, id / 2);
        structures_remove_writer(structures, id);
        atomic_store(&written, id);
        if (id % 16 == 0) {
            structures_note_destroyed(structures, id, 1);
            structures_forget_destroyed(structures);
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
    assert_true(uses_note(structures, id, USE_REFERRED_TO));
    uses_note_tiny(structures, id, true);
    uses_begin_read(structures, id);
    uses_note_input(structures, id, NULL);
    uses_note_shared(structures, id);
    uses_note_contents(structures, id, &contents);
    uses_find_box(structures, id, &box);
    uses_note_advised(structures, id, 1);
    uses_find(structures, id, &uses);
    structures_first_build(structures, id);
    structures_find_serial(structures, &serial);
    structures_allow_disabling(structures, id, &point);
    structures_were_written(structures, id, &point);
}

TEST(records_are_used_while_they_are_added)
{
    pthread_t writer;
    uint32_t id = 0;
    structures = structures_create(KEEPS_FLAGS, NULL);
    assert_non_null(structures);
    assert_int_equal(pthread_create(&writer, NULL, write_structures, NULL), 0);
    while (id < STRUCTURES) {
        id = atomic_load(&written);
        deliver(id + 1);
        deliver(id / 2 + 1);
    }
    assert_int_equal(pthread_join(writer, NULL), 0);
    structures_destroy(structures);
}
