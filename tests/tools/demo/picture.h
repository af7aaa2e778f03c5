/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures in PNG files. */
#ifndef DEMO_PICTURE_H
#define DEMO_PICTURE_H

#include <stdbool.h>
#include <stdint.h>

/* Write RGBA bytes, the top row first, to folder/name; folders that lack are made. Ends the process
 * with one line on stderr where that fails. */
void picture_write(const char *folder, const char *name, uint32_t width, uint32_t height,
                   const uint32_t *pixels);

/* Read such a picture; false where there is none of this size. */
bool picture_read(const char *folder, const char *name, uint32_t width, uint32_t height,
                  uint32_t *pixels);

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
