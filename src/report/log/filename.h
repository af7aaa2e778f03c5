/* SPDX-License-Identifier: Apache-2.0 */
/* The name of the log file, with the words that stand for the process. */
#ifndef ASSAY_REPORT_LOG_FILENAME_H
#define ASSAY_REPORT_LOG_FILENAME_H

#include <stdbool.h>
#include <stddef.h>

enum { LOG_PATH_SIZE = 4096 };

/* Writes `pattern` with the process id instead of %p, the executable's name without folder instead
 * of %e, and % instead of %%. Other uses of % stay as they are. Returns false if the result does
 * not fit. */
bool log_filename_expand(const char *pattern, char path[LOG_PATH_SIZE]);

#endif
