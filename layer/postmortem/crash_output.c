/* SPDX-License-Identifier: Apache-2.0 */
/* The forms of a message: as src/report/message.c and src/report/log/lines.c compose them, but
 * without printf, locks and the time zone. */
#include "layer/postmortem/crash_output.h"

#include <errno.h>
#include <time.h>
#include <unistd.h>

#include "src/base/text_buffer.h"
#include "src/report/message.h"

enum { OUTPUT_SIZE = 2 * MESSAGE_SIZE + 1024 };

static char output_text[OUTPUT_SIZE];

static void write_all(int descriptor, const struct text_buffer *text)
{
    size_t done = 0;
    while (done < text->length) {
        ssize_t written = write(descriptor, text->text + done, text->length - done);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return;
        done += (size_t)written;
    }
}

/* ---- text */

static void write_text(int descriptor, const char *id, int32_t id_number, const char *words)
{
    struct text_buffer text;
    text_begin(&text, output_text, sizeof(output_text));
    text_append_plain(&text, "Validation Warning: [ ");
    text_append_plain(&text, id);
    text_append_plain(&text, " ] | MessageID = ");
    text_append_hex(&text, (uint32_t)id_number);
    text_append_plain(&text, "\n");
    text_append_plain(&text, words);
    text_append_plain(&text, "\n");
    write_all(descriptor, &text);
}

/* ---- JSON */

/* Appends the date of a day since 1970-01-01: years begin in March here, so that a leap day is the
 * last day of its year. */
static void append_date(struct text_buffer *text, uint64_t days)
{
    days += 719468; /* since 0000-03-01 */
    uint64_t era = days / 146097, day = days % 146097;
    uint64_t year = (day - day / 1460 + day / 36524 - day / 146096) / 365;
    day -= 365 * year + year / 4 - year / 100;
    uint64_t month = (5 * day + 2) / 153;
    day -= (153 * month + 2) / 5;
    text_append_padded(text, era * 400 + year + (month >= 10), 4);
    text_append_plain(text, "-");
    text_append_padded(text, month < 10 ? month + 3 : month - 9, 2);
    text_append_plain(text, "-");
    text_append_padded(text, day + 1, 2);
}

static void append_time(struct text_buffer *text)
{
    struct timespec now = {0};
    clock_gettime(CLOCK_REALTIME, &now);
    uint64_t seconds = (uint64_t)now.tv_sec % 86400;
    append_date(text, (uint64_t)now.tv_sec / 86400);
    text_append_plain(text, "T");
    text_append_padded(text, seconds / 3600, 2);
    text_append_plain(text, ":");
    text_append_padded(text, seconds / 60 % 60, 2);
    text_append_plain(text, ":");
    text_append_padded(text, seconds % 60, 2);
    text_append_plain(text, ".");
    text_append_padded(text, (uint64_t)now.tv_nsec / 1000, 6);
    text_append_plain(text, "Z");
}

/* The list is valid UTF-8, with all control characters but newlines escaped. */
static void append_string(struct text_buffer *text, const char *words)
{
    char part[2] = {0};
    text_append_plain(text, "\"");
    for (; *words; words++) {
        part[0] = *words;
        text_append_plain(text, *words == '\n'   ? "\\n"
                                : *words == '"'  ? "\\\""
                                : *words == '\\' ? "\\\\"
                                                 : part);
    }
    text_append_plain(text, "\"");
}

static void write_json(int descriptor, const char *id, int32_t id_number, const char *words)
{
    struct text_buffer text;
    text_begin(&text, output_text, sizeof(output_text));
    text_append_plain(&text, "{\"Type\":\"Finding\",\"pid\":");
    text_append_decimal(&text, (uint64_t)getpid());
    text_append_plain(&text, ",\"time\":\"");
    append_time(&text);
    text_append_plain(&text, "\",\"Severity\":\"Warning\",\"VUID\":\"");
    text_append_plain(&text, id);
    text_append_plain(&text, "\",\"MessageID\":\"");
    text_append_hex(&text, (uint32_t)id_number);
    text_append_plain(&text, "\",\"Objects\":[],\"MainMessage\":");
    append_string(&text, words);
    text_append_plain(&text, "}\n");
    write_all(descriptor, &text);
}

void crash_output_write(const struct crash_output *output, const char *id, int32_t id_number,
                        const char *text)
{
    if (output->descriptor >= 0 && output->is_json)
        write_json(output->descriptor, id, id_number, text);
    else if (output->descriptor >= 0 && output->descriptor != STDERR_FILENO)
        write_text(output->descriptor, id, id_number, text);
    if (output->descriptor != STDERR_FILENO || !output->is_json)
        write_text(STDERR_FILENO, id, id_number, text);
}
