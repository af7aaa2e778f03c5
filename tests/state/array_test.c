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
        numbers = array_make_room(numbers, count, &capacity, sizeof(*numbers));
        assert_non_null(numbers);
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
    char *bytes = array_make_room(NULL, 0, &capacity, 1);
    assert_non_null(bytes);
    for (uint32_t count = 0; count < capacity; count++)
        assert_ptr_equal(array_make_room(bytes, count, &capacity, 1), bytes);
    free(bytes);
}

TEST(without_memory_nothing_changes)
{
    uint32_t capacity = 0;
    char *bytes = array_make_room(NULL, 0, &capacity, 1);
    assert_non_null(bytes);
    const uint32_t before = capacity;
    bytes[0] = 'a';
    WITHOUT_MEMORY(assert_null(array_make_room(bytes, before, &capacity, 1)));
    assert_int_equal(capacity, before);
    assert_int_equal(bytes[0], 'a');
    free(bytes);
}

/* One more doubling would wrap: that is out of memory, too. */
TEST(a_capacity_never_wraps)
{
    uint32_t capacity = UINT32_MAX / 2 + 1;
    char byte;
    assert_null(array_make_room(&byte, capacity, &capacity, 1));
    assert_int_equal(capacity, UINT32_MAX / 2 + 1);
}
