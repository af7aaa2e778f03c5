/* SPDX-License-Identifier: Apache-2.0 */
/* Events of a device: they are freed with it, whether they were removed or not. */
#include "src/state/commands/events.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

TEST(events_are_freed)
{
    struct events *events;
    const int before = allocations_now();
    assert_int_equal(events_create(&events), VK_SUCCESS);
    for (uintptr_t n = 1; n < 100; n++) {
        events_add(events, (VkEvent)n, n % 2);
        events_set(events, (VkEvent)n);
        if (n % 3 == 0)
            events_remove(events, (VkEvent)n);
    }
    events_destroy(events);
    assert_int_equal(allocations_now(), before);
    events_destroy(NULL);
}
