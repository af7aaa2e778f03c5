/* SPDX-License-Identifier: Apache-2.0 */
/* Expands the name of the log file. */
#include "src/report/log/filename.h"

#include <stdio.h>
#include <string.h>

#include "src/base/text_buffer.h"
#include "src/platform/process.h"

static void append_executable(struct text_buffer *text)
{
    char path[LOG_PATH_SIZE];
    process_executable(path, sizeof(path));
    const char *slash = strrchr(path, '/');
    text_append(text, "%s", slash ? slash + 1 : path);
}

bool log_filename_expand(const char *pattern, char path[LOG_PATH_SIZE])
{
    struct text_buffer text;
    text_begin(&text, path, LOG_PATH_SIZE);
    for (const char *rest = pattern; *rest;) {
        size_t plain = strcspn(rest, "%");
        text_append(&text, "%.*s", (int)plain, rest);
        rest += plain;
        if (!*rest)
            break;
        if (rest[1] == 'p')
            text_append_decimal(&text, process_id());
        else if (rest[1] == 'e')
            append_executable(&text);
        else
            text_append(&text, "%%");
        rest += rest[1] == 'p' || rest[1] == 'e' || rest[1] == '%' ? 2 : 1;
    }
    return !text.cut;
}
