/* SPDX-License-Identifier: Apache-2.0 */
/* The forms of a message: as src/report/message.c and src/report/log/lines.c compose them, but
 * without printf, locks and the time zone. */
#include "layer/postmortem/crash_output.h"

#include "src/base/text_buffer.h"
#include "src/platform/clock.h"
#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/message.h"

enum { OUTPUT_SIZE = 2 * MESSAGE_SIZE + 1024 };

static char output_text[OUTPUT_SIZE];

static void write_all(int descriptor, const struct text_buffer *text)
{
    size_t done = 0, written;
    while (done < text->length) {
        if (file_write(descriptor, text->text + done, text->length - done, NULL, 0, &written) != 0)
            return;
        done += written;
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
    text_append_decimal(&text, process_id());
    text_append_plain(&text, ",\"time\":\"");
    text_append_time(&text, clock_utc());
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
    else if (output->descriptor >= 0 && output->descriptor != FILES_STDERR)
        write_text(output->descriptor, id, id_number, text);
    if (output->descriptor != FILES_STDERR || !output->is_json)
        write_text(FILES_STDERR, id, id_number, text);
}
