/* SPDX-License-Identifier: Apache-2.0 */
/* Puts primitives in an order in which neighbours in space are neighbours in memory. */
#define _GNU_SOURCE /* qsort_r */
#include <stdlib.h>

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

struct order_key {
    const float (*centres)[3];
    int axis;
};

static int order_compare(const void *a, const void *b, void *context)
{
    const struct order_key *key = context;
    const float x = key->centres[*(const uint32_t *)a][key->axis],
                y = key->centres[*(const uint32_t *)b][key->axis];
    return (x > y) - (x < y);
}

static void order_split(const float (*centres)[3], uint32_t *order, uint32_t count)
{
    while (count > 2) {
        const uint32_t half = (count + 1) / 2;
        struct order_key key = {centres, order_widest_axis(centres, order, count)};
        qsort_r(order, count, sizeof(*order), order_compare, &key);
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
