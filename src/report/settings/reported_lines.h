/* SPDX-License-Identifier: Apache-2.0 */
/* Warnings about settings: kept until all settings are read and the log is open, and then reported.
 * Most instances share their settings, so each line is reported once per process. Thread-safe. */
#ifndef ASSAY_REPORT_SETTINGS_REPORTED_LINES_H
#define ASSAY_REPORT_SETTINGS_REPORTED_LINES_H

#include <stdbool.h>
#include <stddef.h>

/* Owned lines. Zero-initialized is empty. */
struct kept_lines {
    char **lines;
    size_t count;
};

/* `context` is the struct kept_lines. If memory runs out, the line is lost. */
void kept_lines_add(void *context, const char *line);

/* Returns false if the table already has the line. If the table is full, every line is new. */
bool reported_lines_add(const char *line);

/* Removes a line that was neither logged nor given to a messenger. */
void reported_lines_remove(const char *line);

/* Keeps the layer's library, and so the table, loaded until the process ends. */
void reported_lines_keep(void);

#endif
