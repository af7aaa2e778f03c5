/* SPDX-License-Identifier: Apache-2.0 */
/* Text in a buffer of fixed size. Text that does not fit is truncated and ends in three dots. */
#ifndef ASSAY_BASE_TEXT_BUFFER_H
#define ASSAY_BASE_TEXT_BUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/platform/clock.h"

/* A bounded text. `text` is always terminated. `size` is in bytes and at least 4. The caller owns
 * the memory. */
struct text_buffer {
    char *text;
    size_t size, length;
    bool cut;
};

/* Begins an empty text in `text`, which has `size` bytes and must outlive the buffer. */
void text_begin(struct text_buffer *buffer, char *text, size_t size);

/* None of the functions below allocates or locks, so a signal handler may use them all. */
void text_append(struct text_buffer *buffer, const char *text);
/* Appends the first `length` bytes of a text. */
void text_append_part(struct text_buffer *buffer, const char *text, size_t length);
void text_append_decimal(struct text_buffer *buffer, uint64_t number);
/* Appends a number with zeros in front, if it has fewer digits. */
void text_append_padded(struct text_buffer *buffer, uint64_t number, unsigned digits);
/* A number such as 0x1f. */
void text_append_hex(struct text_buffer *buffer, uint64_t number);
/* A number with up to so many significant digits, at least 1, as printf does with %g. */
void text_append_real(struct text_buffer *buffer, double number, unsigned digits);
/* A time such as 2026-01-31T23:59:59.000000Z. */
void text_append_time(struct text_buffer *buffer, struct utc_time time);

/* Appends a count with its noun, such as "1 byte" or "2 bytes". `noun` is the singular. */
void text_append_count(struct text_buffer *buffer, uint64_t count, const char *noun);

/* Appends at most `size` bytes of UTF-8 text from outside the layer, such as a debug name, in
 * quotation marks and on one line. Quotation marks, backslashes, control characters, line
 * separators, characters that reverse the direction of writing, and bytes that are not UTF-8 appear
 * as escape sequences: \" \n \x1b \u2028. */
void text_append_quoted(struct text_buffer *buffer, const char *quoted, size_t size);

/* Appends such a text without quotation marks around it. */
void text_append_escaped(struct text_buffer *buffer, const char *text, size_t size);

/* Appends what a gap stands for, or nothing. `name` has `length` bytes, without the braces. */
typedef void text_fill(struct text_buffer *text, void *about, const char *name, size_t length);
/* Appends a template, in which {name} is a gap that `fill` fills. A part between [[ and ]] is left
 * out if one of its gaps stays empty. Parts do not nest. */
void text_append_template(struct text_buffer *buffer, const char *says, text_fill *fill,
                          void *about);

/* Returns the greatest length up to `length` at which UTF-8 text can be cut without splitting a
 * character. Text that is not UTF-8 is cut at `length`. */
size_t text_cut_length(const char *text, size_t length);

/* Reads the character at `bytes`, of which `size`, at least 1, may be read. Returns its length; 0
 * if the bytes are not UTF-8. */
size_t text_decode(const unsigned char *bytes, size_t size, uint32_t *character);

#endif
