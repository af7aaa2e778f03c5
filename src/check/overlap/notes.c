/* SPDX-License-Identifier: Apache-2.0 */
/* Ranges of a call that the journal keeps, to be compared when the call executes. */
#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/check/overlap/sweep.h"

void sweep_note(struct sweep *sweep, const struct noted_range *noted)
{
    if (!ARRAY_HAS_ROOM(sweep->noted, sweep->noted_count, sweep->noted_capacity)) {
        unknown_set(&sweep->unknown, UNKNOWN_RANGES);
        return;
    }
    sweep->has_memory = true;
    sweep->noted[sweep->noted_count++] = *noted;
}

struct noted_ranges *sweep_all_ranges(const struct sweep *sweep)
{
    size_t max_count = sweep->noted_count;
    for (int role = 0; role < ROLE_COUNT; role++)
        max_count += sweep->roles[role].count;
    struct noted_ranges *all = unknown_is_set(&sweep->unknown)
                                   ? NULL
                                   : malloc(sizeof(*all) + max_count * sizeof(all->items[0]));
    if (!all)
        return NULL;
    *all = (struct noted_ranges){.count = sweep->noted_count};
    memcpy(all->items, sweep->noted, sweep->noted_count * sizeof(all->items[0]));
    for (int role = 0; role < ROLE_COUNT; role++)
        for (uint32_t i = 0; i < sweep->roles[role].count; i++)
            if (sweep->roles[role].items[i].span.memory)
                all->items[all->count++] =
                    (struct noted_range){.range = sweep->roles[role].items[i]};
    return all;
}
