/* SPDX-License-Identifier: Apache-2.0 */
/* Text in a buffer of fixed size. What does not fit is cut, and three dots say so. */
#ifndef ASSAY_BASE_TEXT_BUFFER_H
#define ASSAY_BASE_TEXT_BUFFER_H

#include <stdbool.h>
#include <stddef.h>

/* `text` is always terminated. `size` is at least 4. */
struct text_buffer {
    char *text;
    size_t size, length;
    bool cut;
};

void text_begin(struct text_buffer *buffer, char *text, size_t size);

/* Appends as printf does; nothing more once the text has been cut. */
__attribute__((format(printf, 2, 3))) void text_append(struct text_buffer *buffer,
                                                       const char *format, ...);

/* The greatest length up to `length` at which UTF-8 text may be cut without splitting a character.
 */
size_t text_cut_length(const char *text, size_t length);

#endif
