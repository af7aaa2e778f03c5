/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/figures/layouts.h"

#include <stddef.h>

enum { VERTICES_MIN = 16 }; /* fewer prove nothing */

static uint64_t end_of(const struct vertex_layout *layout)
{
    return layout->begin + layout->count * layout->stride;
}

/* At least nine tenths of the bytes of each. */
static bool share_bytes(const struct vertex_layout *one, const struct vertex_layout *other)
{
    const uint64_t begin = one->begin > other->begin ? one->begin : other->begin,
                   end = end_of(one) < end_of(other) ? end_of(one) : end_of(other),
                   shared = end > begin ? end - begin : 0;
    return shared / 9 * 10 >= one->count * one->stride &&
           shared / 9 * 10 >= other->count * other->stride;
}

static bool is_multiple(uint64_t one, uint64_t other)
{
    return one % other == 0 || other % one == 0;
}

/* The same place in each vertex holds numbers of one kind. */
static bool read_other_numbers(const struct vertex_layout *one, const struct vertex_layout *other)
{
    const uint64_t distance =
        one->begin > other->begin ? one->begin - other->begin : other->begin - one->begin;
    return distance % one->stride == 0 &&
           (one->component != other->component || one->is_float != other->is_float);
}

static bool contradict(const struct vertex_layout *one, const struct vertex_layout *other)
{
    return one->stride == other->stride ? read_other_numbers(one, other)
                                        : !is_multiple(one->stride, other->stride);
}

static bool proves_something(const struct vertex_layout *layout)
{
    return layout->stride && layout->count >= VERTICES_MIN;
}

const struct vertex_layout *vertex_layouts_find_other(const struct vertex_layouts *layouts,
                                                      const struct vertex_layout *layout)
{
    for (uint32_t i = 0; proves_something(layout) && i < layouts->count; i++)
        if (share_bytes(&layouts->items[i], layout) && contradict(&layouts->items[i], layout))
            return &layouts->items[i];
    return NULL;
}

void vertex_layouts_add(struct vertex_layouts *layouts, const struct vertex_layout *layout)
{
    const uint32_t room = sizeof(layouts->items) / sizeof(layouts->items[0]);
    if (proves_something(layout) && layouts->count < room)
        layouts->items[layouts->count++] = *layout;
}
