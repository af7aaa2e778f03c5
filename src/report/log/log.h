/* SPDX-License-Identifier: Apache-2.0 */
/* Where messages are logged to: a file, stderr or stdout, as text or as lines of JSON.
 *
 * Thread-safe. A line of JSON is one write to a file that is opened for appending, so lines of
 * several threads and processes do not mix, and each is complete if the process is killed. */
#ifndef ASSAY_REPORT_LOG_LOG_H
#define ASSAY_REPORT_LOG_LOG_H

#include <stdatomic.h>
#include <stdio.h>

#include "src/platform/threads.h"
#include "src/report/log/lines.h"

struct log {
    FILE *file;
    bool is_active;       /* setting debug_action logs */
    bool is_owned;        /* a file that log_filename names */
    struct json *json;    /* NULL: text; guarded by `lock` */
    pthread_mutex_t lock; /* held while a line is composed and written */
    bool is_torn;         /* the last write was incomplete; guarded by `lock` */
    atomic_bool has_failed;
};

/* Opens the log as the settings say. If the file cannot be opened, adds one line to `warnings` and
 * logs to stderr. Fails only if memory runs out. `log` is zero-initialized. */
VkResult log_open(struct log *log, const struct settings *settings, struct kept_lines *warnings);
/* Opens a log of lines of JSON in a new file, whatever the settings say. Returns 0 or an error
 * number. */
int log_open_new(struct log *log, const char *path);
void log_close(struct log *log);

/* These write one line, or message. The ones other than log_message write nothing if the log is
 * text. Each returns 0, or the error number of the first failure to write. */
int log_message(struct log *log, const struct message *message, const struct settings *settings);
int log_header(struct log *log, const VkApplicationInfo *application,
               const struct settings *settings);
int log_device(struct log *log, VkDevice device, const char *name,
               const VkPhysicalDeviceDriverProperties *driver);
int log_summary(struct log *log, const struct settings *settings,
                const struct duplicates *duplicates, struct unchecked_counts *unchecked);
int log_add(struct log *log, const struct log_record *record);

#endif
