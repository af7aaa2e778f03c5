/* SPDX-License-Identifier: Apache-2.0 */
/* Text in a bounded buffer. */
#include "src/base/text_buffer.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const char dots[] = "...";

void text_begin(struct text_buffer *buffer, char *text, size_t size)
{
    *buffer = (struct text_buffer){.text = text, .size = size};
    text[0] = '\0';
}

size_t text_cut_length(const char *text, size_t length)
{
    while (length > 0 && ((unsigned char)text[length] & 0xc0) == 0x80)
        length--;
    return length;
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
