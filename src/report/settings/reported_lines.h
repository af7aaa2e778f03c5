/* SPDX-License-Identifier: Apache-2.0 */
/* Warnings about settings: kept until all settings are read and the log is open, and then reported.
 * Most instances share their settings, so each line is reported once per process. Thread-safe. */
#ifndef ASSAY_REPORT_SETTINGS_REPORTED_LINES_H
#define ASSAY_REPORT_SETTINGS_REPORTED_LINES_H

#include <stdbool.h>
#include <stddef.h>

#include "src/view/finding.h"

/* Owned lines. Zero-initialized is empty. */
struct kept_lines {
    char **lines;
    size_t count;
};

/* If memory runs out, the line is lost. */
void kept_lines_add(struct kept_lines *kept, const char *line);
void kept_lines_free(struct kept_lines *kept);
/* Words a line of up to 1023 bytes, as text_say() does, and adds it. */
void kept_lines_append(struct kept_lines *kept, const char *says, const struct value *values,
                       uint32_t count);
#define kept_lines_say(kept, says, ...) kept_lines_append((kept), (says), VALUES(__VA_ARGS__))

/* Returns false if the table already has the line. If the table is full, every line is new. */
bool reported_lines_add(const char *line);

/* Removes a line that was neither logged nor given to a messenger. */
void reported_lines_remove(const char *line);

/* Keeps the layer's library, and so the table, loaded until the process ends. */
void reported_lines_keep(void);

#endif
