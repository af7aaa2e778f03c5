/* SPDX-License-Identifier: Apache-2.0 */
/* Uses the generator of YAJL, with memory and a buffer of its own. */
#include "src/report/log/json.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <yajl/yajl_gen.h>

#include "src/base/text_buffer.h"

static const char replacement[] = "\xef\xbf\xbd"; /* U+FFFD */

/* ---- memory of the generator, which needs less than 1 KiB, and none while it writes */

static void *take_memory(void *context, size_t size)
{
    struct json *json = context;
    size_t rounded = (size + 15) & ~(size_t)15;
    if (rounded > sizeof(json->memory) - json->memory_used)
        return NULL;
    void *memory = json->memory + json->memory_used;
    json->memory_used += rounded;
    return memory;
}

static void *take_no_more_memory(void *context, void *memory, size_t size)
{
    (void)context, (void)memory, (void)size;
    return NULL;
}

static void keep_memory(void *context, void *memory)
{
    (void)context, (void)memory;
}

/* ---- the line */

/* Leaves room for the newline. */
static void append_to_line(void *context, const char *text, size_t length)
{
    struct json *json = context;
    if (length >= sizeof(json->line) - json->length) {
        json->failed = true;
        return;
    }
    memcpy(json->line + json->length, text, length);
    json->length += length;
}

static void note_status(struct json *json, yajl_gen_status status)
{
    if (status != yajl_gen_status_ok)
        json->failed = true;
}

void json_begin(struct json *json)
{
    const yajl_alloc_funcs functions = {take_memory, take_no_more_memory, keep_memory, json};
    json->length = json->memory_used = 0;
    json->failed = false;
    json->generator = yajl_gen_alloc(&functions);
    if (!json->generator ||
        !yajl_gen_config(json->generator, yajl_gen_print_callback, append_to_line, json)) {
        json->generator = NULL;
        json->failed = true;
        return;
    }
    json_begin_object(json, NULL);
}

bool json_end(struct json *json)
{
    json_end_object(json);
    if (json->failed)
        return false;
    json->line[json->length++] = '\n';
    return true;
}

/* ---- values */

static void write_key(struct json *json, const char *key)
{
    if (key && !json->failed)
        note_status(json,
                    yajl_gen_string(json->generator, (const unsigned char *)key, strlen(key)));
}

/* Returns the length of the copy in json->text. */
static size_t copy_as_utf8(struct json *json, const char *text, size_t size)
{
    size_t length = 0;
    for (size_t at = 0; at < size;) {
        uint32_t character;
        size_t taken = text_decode((const unsigned char *)text + at, size - at, &character);
        if (taken)
            memcpy(json->text + length, text + at, taken);
        else
            memcpy(json->text + length, replacement, sizeof(replacement) - 1);
        length += taken ? taken : sizeof(replacement) - 1;
        at += taken ? taken : 1;
    }
    return length;
}

void json_text_of_size(struct json *json, const char *key, const char *text, size_t size)
{
    write_key(json, key);
    if (json->failed)
        return;
    size = text ? strnlen(text, size) : 0;
    if (size > JSON_TEXT_MAX)
        size = text_cut_length(text, JSON_TEXT_MAX);
    size_t length = copy_as_utf8(json, text, size);
    note_status(json, yajl_gen_string(json->generator, (const unsigned char *)json->text, length));
}

void json_text(struct json *json, const char *key, const char *text)
{
    json_text_of_size(json, key, text, text ? strlen(text) : 0);
}

void json_number(struct json *json, const char *key, uint64_t number)
{
    write_key(json, key);
    char digits[24];
    int length = snprintf(digits, sizeof(digits), "%" PRIu64, number);
    if (!json->failed)
        note_status(json, yajl_gen_number(json->generator, digits, (size_t)length));
}

void json_hex(struct json *json, const char *key, uint64_t number)
{
    char digits[24];
    snprintf(digits, sizeof(digits), "0x%" PRIx64, number);
    json_text(json, key, digits);
}

void json_begin_object(struct json *json, const char *key)
{
    write_key(json, key);
    if (!json->failed)
        note_status(json, yajl_gen_map_open(json->generator));
}

void json_end_object(struct json *json)
{
    if (!json->failed)
        note_status(json, yajl_gen_map_close(json->generator));
}

void json_begin_array(struct json *json, const char *key)
{
    write_key(json, key);
    if (!json->failed)
        note_status(json, yajl_gen_array_open(json->generator));
}

void json_end_array(struct json *json)
{
    if (!json->failed)
        note_status(json, yajl_gen_array_close(json->generator));
}
