/* SPDX-License-Identifier: Apache-2.0 */
/* Text in a bounded buffer. */
#include "src/base/text_buffer.h"

#include <inttypes.h>
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

void text_append(struct text_buffer *buffer, const char *format, ...)
{
    if (buffer->cut)
        return;

    size_t room = buffer->size - buffer->length;
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(buffer->text + buffer->length, room, format, arguments);
    va_end(arguments);

    if (length >= 0 && (size_t)length < room) {
        buffer->length += (size_t)length;
        return;
    }
    buffer->cut = true;
    buffer->length = text_cut_length(buffer->text, buffer->size - sizeof(dots));
    memcpy(buffer->text + buffer->length, dots, sizeof(dots));
    buffer->length += sizeof(dots) - 1;
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
    if (count == 1)
        text_append(buffer, "1 %s", noun);
    else if (irregular)
        text_append(buffer, "%" PRIu64 " %s", count, irregular);
    else
        text_append(buffer, "%" PRIu64 " %ss", count, noun);
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

static void append_character(struct text_buffer *buffer, const unsigned char *bytes, size_t length,
                             uint32_t character)
{
    if (!length)
        text_append(buffer, "\\x%02x", (unsigned)bytes[0]);
    else if (character == '"' || character == '\\')
        text_append(buffer, "\\%c", (int)character);
    else if (character == '\n')
        text_append(buffer, "\\n");
    else if (character == '\r')
        text_append(buffer, "\\r");
    else if (character == '\t')
        text_append(buffer, "\\t");
    else if (is_control(character))
        text_append(buffer, character < 0x80 ? "\\x%02x" : "\\u%04x", (unsigned)character);
    else
        text_append(buffer, "%.*s", (int)length, (const char *)bytes);
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
    text_append(buffer, "\"");
    text_append_escaped(buffer, quoted, size);
    text_append(buffer, "\"");
}
