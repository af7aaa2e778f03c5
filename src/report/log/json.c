/* SPDX-License-Identifier: Apache-2.0 */
/* Writes JSON. A comma stands before each value but the first of its object or array. */
#include "src/report/log/json.h"

#include <string.h>

static const char replacement[] = "\xef\xbf\xbd"; /* U+FFFD */

void json_begin_in(struct json *json, char *line, size_t size)
{
    text_begin(&json->text, line, size);
    json->depth = 0;
    json_begin_object(json, NULL);
}

void json_begin(struct json *json)
{
    json_begin_in(json, json->line, sizeof(json->line));
}

bool json_end(struct json *json)
{
    json_end_object(json);
    text_append(&json->text, "\n");
    return !json->text.cut && !json->depth;
}

/* ---- values */

static void append_character(struct text_buffer *text, const unsigned char *bytes, size_t length)
{
    static const char escaped[] = "\"\\\b\f\n\r\t", letters[] = "\"\\bfnrt";
    const char *found = *bytes && length == 1 ? strchr(escaped, *bytes) : NULL;
    if (!length) {
        text_append(text, replacement);
    } else if (found) {
        text_append(text, "\\");
        text_append_part(text, &letters[found - escaped], 1);
    } else if (*bytes < 0x20) {
        text_append(text, *bytes < 0x10 ? "\\u000" : "\\u001");
        text_append_part(text, &"0123456789ABCDEF"[*bytes & 0xf], 1);
    } else {
        text_append_part(text, (const char *)bytes, length);
    }
}

/* Returns how many characters at the beginning stand for themselves. */
static size_t count_plain(const unsigned char *bytes, size_t size)
{
    size_t count = 0;
    while (count < size && bytes[count] >= ' ' && bytes[count] < 0x7f && bytes[count] != '"' &&
           bytes[count] != '\\')
        count++;
    return count;
}

static void append_string(struct text_buffer *text, const char *string, size_t size)
{
    const unsigned char *bytes = (const unsigned char *)string;
    text_append(text, "\"");
    while (size > 0) {
        uint32_t character;
        const size_t plain = count_plain(bytes, size);
        const size_t length = plain ? plain : text_decode(bytes, size, &character);
        append_character(text, bytes, length);
        bytes += length ? length : 1;
        size -= length ? length : 1;
    }
    text_append(text, "\"");
}

static void begin_value(struct json *json, const char *key)
{
    const size_t length = json->text.length;
    if (length && !strchr("{[", json->text.text[length - 1]))
        text_append(&json->text, ",");
    if (key) {
        append_string(&json->text, key, strlen(key));
        text_append(&json->text, ":");
    }
}

void json_text_of_size(struct json *json, const char *key, const char *text, size_t size)
{
    size = text ? strnlen(text, size) : 0;
    begin_value(json, key);
    append_string(&json->text, text,
                  size > JSON_TEXT_MAX ? text_cut_length(text, JSON_TEXT_MAX) : size);
}

void json_text(struct json *json, const char *key, const char *text)
{
    json_text_of_size(json, key, text, text ? strlen(text) : 0);
}

void json_number(struct json *json, const char *key, uint64_t number)
{
    begin_value(json, key);
    text_append_decimal(&json->text, number);
}

void json_hex(struct json *json, const char *key, uint64_t number)
{
    begin_value(json, key);
    text_append(&json->text, "\"");
    text_append_hex(&json->text, number);
    text_append(&json->text, "\"");
}

/* ---- objects and arrays */

static void begin_group(struct json *json, const char *key, const char *bracket)
{
    begin_value(json, key);
    text_append(&json->text, bracket);
    json->depth++;
}

static void end_group(struct json *json, const char *bracket)
{
    text_append(&json->text, bracket);
    json->depth--;
}

void json_begin_object(struct json *json, const char *key)
{
    begin_group(json, key, "{");
}

void json_end_object(struct json *json)
{
    end_group(json, "}");
}

void json_begin_array(struct json *json, const char *key)
{
    begin_group(json, key, "[");
}

void json_end_array(struct json *json)
{
    end_group(json, "]");
}
