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

#endif
