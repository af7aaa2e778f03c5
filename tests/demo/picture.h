/* SPDX-License-Identifier: Apache-2.0 */
/* Writes a picture as PNG. */
#ifndef DEMO_PICTURE_H
#define DEMO_PICTURE_H

#include <stdint.h>

/* Write RGBA bytes, the top row first, to folder/name; folders that lack are made. Ends the process
 * with one line on stderr where that fails. */
void picture_write(const char *folder, const char *name, uint32_t width, uint32_t height,
                   const uint32_t *pixels);

#endif
