/* SPDX-License-Identifier: Apache-2.0 */
/* How far two pictures are apart. */
#ifndef DEMO_COMPARE_H
#define DEMO_COMPARE_H

#include <stdbool.h>
#include <stdint.h>

struct comparison {
    uint32_t differing; /* pixels */
    uint32_t visible;   /* of them, those of which a channel differs by more than COMPARE_VISIBLE */
    uint32_t largest;   /* difference of a channel, 0 to 255 */
};
#define COMPARE_VISIBLE 8

/* `difference` gets the largest difference of a pixel's channels, as a grey, eightfold. */
struct comparison compare_pictures(const uint32_t *a, const uint32_t *b, uint32_t *difference,
                                   uint32_t pixel_count);

#endif
