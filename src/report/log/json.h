/* SPDX-License-Identifier: Apache-2.0 */
/* Writes one line of JSON into a buffer of fixed size. Neither allocates nor locks, so a signal
 * handler may use it.
 *
 * A key may be NULL: inside an array. Text that is not UTF-8 has U+FFFD instead of each wrong byte.
 */
#ifndef ASSAY_REPORT_LOG_JSON_H
#define ASSAY_REPORT_LOG_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/text_buffer.h"

enum {
    JSON_TEXT_MAX = 8192, /* bytes of one text; longer texts are cut between characters */
    JSON_LINE_MAX = 256 * 1024,
};

/* All of one line; large, so it does not belong on the stack. */
struct json {
    struct text_buffer text; /* in `line`; cut if the line did not fit */
    int depth;               /* of objects and arrays */
    char line[JSON_LINE_MAX];
};

/* Begins a line, which is one object. */
void json_begin(struct json *json);
/* Begins a line in memory of the caller, which may have more room. */
void json_begin_in(struct json *json, char *line, size_t size);
/* Ends the line with a newline. It is json->text.text, json->text.length bytes long. Returns false
 * if the line did not fit, or is not one object. */
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
