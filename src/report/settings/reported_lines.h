/* SPDX-License-Identifier: Apache-2.0 */
/* The lines about settings that were reported in this process. Most instances share their settings,
 * so each line is reported once per process. Thread-safe. */
#ifndef ASSAY_REPORT_SETTINGS_REPORTED_LINES_H
#define ASSAY_REPORT_SETTINGS_REPORTED_LINES_H

#include <stdbool.h>

/* Returns false if the table already has the line. If the table is full, every line is new. */
bool reported_lines_add(const char *line);

/* Removes a line that was neither logged nor given to a messenger. */
void reported_lines_remove(const char *line);

/* Keeps the layer's library, and so the table, loaded until the process ends. */
void reported_lines_keep(void);

#endif
