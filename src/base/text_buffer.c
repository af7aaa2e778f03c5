/* SPDX-License-Identifier: Apache-2.0 */
/* Text in a bounded buffer. */
#include "src/base/text_buffer.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { CHARACTER_MAX = 4 }; /* bytes of a character in UTF-8 */

static const char dots[] = "...";

static bool is_continuation(unsigned char byte)
{
    return (byte & 0xc0) == 0x80;
}

void text_begin(struct text_buffer *buffer, char *text, size_t size)
{
    *buffer = (struct text_buffer){.text = text, .size = size};
    text[0] = '\0';
}

size_t text_cut_length(const char *text, size_t length)
{
    size_t cut = length;
    for (int steps = 0; cut > 0 && is_continuation((unsigned char)text[cut]); steps++, cut--)
        if (steps == CHARACTER_MAX - 1)
            return length;
    return cut;
}

/* Ends a text of which only a part fitted. */
static void cut(struct text_buffer *buffer)
{
    buffer->cut = true;
    buffer->length = text_cut_length(buffer->text, buffer->size - sizeof(dots));
    memcpy(buffer->text + buffer->length, dots, sizeof(dots));
    buffer->length += sizeof(dots) - 1;
}

void text_append(struct text_buffer *buffer, const char *format, ...)
{
    if (buffer->cut)
        return;

    size_t room = buffer->size - buffer->length;
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(buffer->text + buffer->length, room, format, arguments);
    va_end(arguments);

    if (length >= 0 && (size_t)length < room)
        buffer->length += (size_t)length;
    else
        cut(buffer);
}

/* ---- without printf */

static void append_bytes(struct text_buffer *buffer, const char *bytes, size_t length)
{
    if (buffer->cut)
        return;
    size_t room = buffer->size - buffer->length - 1;
    size_t fitting = length < room ? length : room;
    memcpy(buffer->text + buffer->length, bytes, fitting);
    buffer->text[buffer->length + fitting] = '\0';
    if (fitting == length)
        buffer->length += length;
    else
        cut(buffer);
}

void text_append_plain(struct text_buffer *buffer, const char *text)
{
    append_bytes(buffer, text, strlen(text));
}

static void append_digits(struct text_buffer *buffer, uint64_t number, unsigned base,
                          unsigned least)
{
    char digits[20];
    size_t at = sizeof(digits);
    do {
        digits[--at] = "0123456789abcdef"[number % base];
        number /= base;
    } while (number || sizeof(digits) - at < least);
    append_bytes(buffer, digits + at, sizeof(digits) - at);
}

void text_append_decimal(struct text_buffer *buffer, uint64_t number)
{
    append_digits(buffer, number, 10, 1);
}

void text_append_padded(struct text_buffer *buffer, uint64_t number, unsigned digits)
{
    append_digits(buffer, number, 10, digits);
}

void text_append_hex(struct text_buffer *buffer, uint64_t number)
{
    text_append_plain(buffer, "0x");
    append_digits(buffer, number, 16, 1);
}

/* Appends the date of a day since 1970-01-01: years begin in March here, so that a leap day is the
 * last day of its year. */
static void append_date(struct text_buffer *buffer, uint64_t days)
{
    days += 719468; /* since 0000-03-01 */
    uint64_t era = days / 146097, day = days % 146097;
    uint64_t year = (day - day / 1460 + day / 36524 - day / 146096) / 365;
    day -= 365 * year + year / 4 - year / 100;
    uint64_t month = (5 * day + 2) / 153;
    day -= (153 * month + 2) / 5;
    text_append_padded(buffer, era * 400 + year + (month >= 10), 4);
    text_append_plain(buffer, "-");
    text_append_padded(buffer, month < 10 ? month + 3 : month - 9, 2);
    text_append_plain(buffer, "-");
    text_append_padded(buffer, day + 1, 2);
}

void text_append_time(struct text_buffer *buffer, struct utc_time time)
{
    uint64_t seconds = time.seconds % 86400;
    append_date(buffer, time.seconds / 86400);
    text_append_plain(buffer, "T");
    text_append_padded(buffer, seconds / 3600, 2);
    text_append_plain(buffer, ":");
    text_append_padded(buffer, seconds / 60 % 60, 2);
    text_append_plain(buffer, ":");
    text_append_padded(buffer, seconds % 60, 2);
    text_append_plain(buffer, ".");
    text_append_padded(buffer, time.nanoseconds / 1000, 6);
    text_append_plain(buffer, "Z");
}

/* The plurals that do not end in "s" alone. */
static const char *irregular_plural(const char *noun)
{
    static const struct {
        const char *one, *many;
    } nouns[] = {{"vertex", "vertices"}, {"index", "indices"}, {"geometry", "geometries"}};
    for (size_t i = 0; i < sizeof(nouns) / sizeof(nouns[0]); i++)
        if (strcmp(noun, nouns[i].one) == 0)
            return nouns[i].many;
    return NULL;
}

void text_append_count(struct text_buffer *buffer, uint64_t count, const char *noun)
{
    const char *irregular = irregular_plural(noun);
    text_append_decimal(buffer, count);
    text_append_plain(buffer, " ");
    text_append_plain(buffer, count != 1 && irregular ? irregular : noun);
    if (count != 1 && !irregular)
        text_append_plain(buffer, "s");
}

/* ---- quoted text */

size_t text_decode(const unsigned char *bytes, size_t size, uint32_t *character)
{
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000}; /* by length */
    size_t length = bytes[0] < 0x80             ? 1
                    : (bytes[0] & 0xe0) == 0xc0 ? 2
                    : (bytes[0] & 0xf0) == 0xe0 ? 3
                    : (bytes[0] & 0xf8) == 0xf0 ? 4
                                                : 0;
    if (!length || length > size)
        return 0;
    uint32_t value = length == 1 ? bytes[0] : bytes[0] & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        if (!is_continuation(bytes[i]))
            return 0;
        value = value << 6 | (bytes[i] & 0x3f);
    }
    if (value < least[length] || value > 0x10ffff || (value >= 0xd800 && value <= 0xdfff))
        return 0;
    *character = value;
    return length;
}

/* The control characters of Unicode, its separators of lines and paragraphs, and the characters
 * that change the direction of writing. */
static bool is_control(uint32_t character)
{
    return character < 0x20 || (character >= 0x7f && character <= 0x9f) || character == 0x061c ||
           character == 0x200e || character == 0x200f ||
           (character >= 0x2028 && character <= 0x202e) ||
           (character >= 0x2066 && character <= 0x2069);
}

/* Appends an escape sequence such as \x1b. */
static void append_code(struct text_buffer *buffer, char letter, uint32_t code, unsigned digits)
{
    const char start[] = {'\\', letter, '\0'};
    text_append_plain(buffer, start);
    append_digits(buffer, code, 16, digits);
}

static void append_character(struct text_buffer *buffer, const unsigned char *bytes, size_t length,
                             uint32_t character)
{
    if (!length)
        append_code(buffer, 'x', bytes[0], 2);
    else if (character == '"' || character == '\\')
        text_append_plain(buffer, character == '"' ? "\\\"" : "\\\\");
    else if (character == '\n')
        text_append_plain(buffer, "\\n");
    else if (character == '\r')
        text_append_plain(buffer, "\\r");
    else if (character == '\t')
        text_append_plain(buffer, "\\t");
    else if (is_control(character))
        append_code(buffer, character < 0x80 ? 'x' : 'u', character, character < 0x80 ? 2 : 4);
    else
        append_bytes(buffer, (const char *)bytes, length);
}

void text_append_escaped(struct text_buffer *buffer, const char *text, size_t size)
{
    const unsigned char *bytes = (const unsigned char *)text;
    size_t left = strnlen(text, size);
    if (left == size && left > 0)
        left = text_cut_length(text, size);
    while (left > 0) {
        uint32_t character = 0;
        size_t length = text_decode(bytes, left, &character);
        append_character(buffer, bytes, length, character);
        bytes += length ? length : 1;
        left -= length ? length : 1;
    }
}

void text_append_quoted(struct text_buffer *buffer, const char *quoted, size_t size)
{
    text_append_plain(buffer, "\"");
    text_append_escaped(buffer, quoted, size);
    text_append_plain(buffer, "\"");
}
