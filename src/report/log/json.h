/* SPDX-License-Identifier: Apache-2.0 */
/* Writes one line of JSON into a buffer of fixed size. Allocates nothing.
 *
 * A key may be NULL: inside an array. Text that is not UTF-8 has U+FFFD instead of each wrong byte.
 */
#ifndef ASSAY_REPORT_LOG_JSON_H
#define ASSAY_REPORT_LOG_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    JSON_TEXT_MAX = 8192, /* bytes of one text; longer texts are cut between characters */
    JSON_LINE_MAX = 256 * 1024,
    JSON_MEMORY = 4096,
};

struct yajl_gen_t;

/* All of one line; large, so it does not belong on the stack. */
struct json {
    struct yajl_gen_t *generator;
    size_t length, memory_used;
    bool failed;                  /* the line did not fit, or it is not one object */
    char text[3 * JSON_TEXT_MAX]; /* U+FFFD takes three bytes */
    _Alignas(16) char memory[JSON_MEMORY];
    char line[JSON_LINE_MAX];
};

/* Begins a line, which is one object. */
void json_begin(struct json *json);
/* Ends the line with a newline. It is json->line, json->length bytes long. Returns false if the
 * line is not complete. */
bool json_end(struct json *json);

/* Writes an empty text if `text` is NULL. */
void json_text(struct json *json, const char *key, const char *text);
/* Writes at most `size` bytes of a text. */
void json_text_of_size(struct json *json, const char *key, const char *text, size_t size);
void json_number(struct json *json, const char *key, uint64_t number);
/* A text such as 0x1f. */
void json_hex(struct json *json, const char *key, uint64_t number);

void json_begin_object(struct json *json, const char *key);
void json_end_object(struct json *json);
void json_begin_array(struct json *json, const char *key);
void json_end_array(struct json *json);

#endif
