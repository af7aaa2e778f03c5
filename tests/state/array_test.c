/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays that grow by one element: what they hold stays, also without memory. */
#include <stdlib.h>

#include "src/base/array.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/unit_test.h"

enum { MOST = 1000 };

TEST(growing_keeps_what_is_there)
{
    uint64_t *numbers = NULL;
    uint32_t capacity = 0;
    for (uint32_t count = 0; count < MOST; count++) {
        assert_true(ARRAY_HAS_ROOM(numbers, count, capacity));
        assert_true(count < capacity);
        numbers[count] = count;
    }
    for (uint32_t i = 0; i < MOST; i++)
        assert_int_equal(numbers[i], i);
    free(numbers);
}

TEST(an_array_with_room_stays_where_it_is)
{
    uint32_t capacity = 0;
    char *bytes = NULL;
    assert_true(ARRAY_HAS_ROOM(bytes, 0, capacity));
    const char *before = bytes;
    for (uint32_t count = 0; count < capacity; count++) {
        assert_true(ARRAY_HAS_ROOM(bytes, count, capacity));
        assert_ptr_equal(bytes, before);
    }
    free(bytes);
}

TEST(without_memory_nothing_changes)
{
    uint32_t capacity = 0;
    char *bytes = NULL;
    assert_true(ARRAY_HAS_ROOM(bytes, 0, capacity));
    char *const there = bytes;
    const uint32_t before = capacity;
    bytes[0] = 'a';
    WITHOUT_MEMORY(assert_false(ARRAY_HAS_ROOM(bytes, before, capacity)));
    assert_int_equal(capacity, before);
    assert_ptr_equal(bytes, there);
    assert_int_equal(bytes[0], 'a');
    free(bytes);
}

/* One more doubling would wrap: that is out of memory, too. */
TEST(a_capacity_never_wraps)
{
    uint32_t capacity = UINT32_MAX / 2 + 1;
    char *bytes = NULL;
    assert_false(ARRAY_HAS_ROOM(bytes, capacity, capacity));
    assert_null(bytes);
    assert_int_equal(capacity, UINT32_MAX / 2 + 1);
}
