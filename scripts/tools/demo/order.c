/* SPDX-License-Identifier: Apache-2.0 */
/* Puts primitives in an order in which neighbours in space are neighbours in memory. */
#include "scene.h"

static int order_widest_axis(const float (*centres)[3], const uint32_t *order, uint32_t count)
{
    int widest = 0;
    float width = -1.0f;
    for (int axis = 0; axis < 3; ++axis) {
        float low = centres[order[0]][axis];
        float high = low;
        for (uint32_t i = 1; i < count; ++i) {
            float at = centres[order[i]][axis];
            low = at < low ? at : low;
            high = at > high ? at : high;
        }
        if (high - low > width) {
            width = high - low;
            widest = axis;
        }
    }
    return widest;
}

/* Move the `middle` items that are lowest on the axis to the front. */
static void order_select(const float (*centres)[3], int axis, uint32_t *order, uint32_t count,
                         uint32_t middle)
{
    int64_t first = 0;
    int64_t last = (int64_t)count - 1;
    while (first < last) {
        const float pivot = centres[order[(first + last) / 2]][axis];
        int64_t low = first;
        int64_t high = last;
        while (low <= high) {
            while (centres[order[low]][axis] < pivot)
                ++low;
            while (centres[order[high]][axis] > pivot)
                --high;
            if (low <= high) {
                uint32_t swapped = order[low];
                order[low++] = order[high];
                order[high--] = swapped;
            }
        }
        if (middle <= high)
            last = high;
        else if (middle >= low)
            first = low;
        else
            return;
    }
}

static void order_split(const float (*centres)[3], uint32_t *order, uint32_t count)
{
    while (count > 2) {
        const uint32_t half = (count + 1) / 2;
        order_select(centres, order_widest_axis(centres, order, count), order, count, half);
        order_split(centres, order, half);
        order += half;
        count -= half;
    }
}

void order_by_place(const float (*centres)[3], uint32_t count, uint32_t *order)
{
    for (uint32_t i = 0; i < count; ++i)
        order[i] = i;
    order_split(centres, order, count);
}
