/* SPDX-License-Identifier: Apache-2.0 */
/* Which lines about settings were reported in this process. Instances share their settings mostly,
 * and a warning from each would only repeat the first. Thread-safe. */
#ifndef ASSAY_REPORT_REPORTED_LINES_H
#define ASSAY_REPORT_REPORTED_LINES_H

#include <stdbool.h>

/* Returns false if the line is there already. If the table is full, every line counts as new. */
bool reported_lines_add(const char *line);

/* Takes a line out again that reached nobody. */
void reported_lines_remove(const char *line);

/* Keeps the layer's library, and so the table, loaded until the process ends. */
void reported_lines_keep(void);

#endif
