/* SPDX-License-Identifier: Apache-2.0 */
/* Compares pictures pixel by pixel. */
#include "compare.h"

#include <stdlib.h>

#define GAIN 8

static uint32_t channel(uint32_t pixel, int i)
{
    return pixel >> 8 * i & 0xff;
}

struct comparison compare_pictures(const uint32_t *a, const uint32_t *b, uint32_t *difference,
                                   uint32_t pixel_count)
{
    struct comparison comparison = {0};
    for (uint32_t i = 0; i < pixel_count; ++i) {
        uint32_t largest = 0;
        for (int c = 0; c < 3; ++c) {
            uint32_t apart = (uint32_t)abs((int)channel(a[i], c) - (int)channel(b[i], c));
            largest = apart > largest ? apart : largest;
        }
        comparison.differing += largest > 0;
        comparison.visible += largest > COMPARE_VISIBLE;
        comparison.largest = largest > comparison.largest ? largest : comparison.largest;
        uint32_t grey = largest * GAIN < 255 ? largest * GAIN : 255;
        difference[i] = 0xff000000u | grey << 16 | grey << 8 | grey;
    }
    return comparison;
}
