/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the log and writes to it. */
#include "src/report/log/log.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/letter_case.h"
#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/log/lines.h"
#include "src/report/words.h"

enum { FILENAME_SHOWN = 200 };

/* ---- opening */

/* Returns NULL, and sets `reason`, if the file cannot be opened. Appends, because several instances
 * and several processes may share the file. */
static FILE *open_file(const char *filename, const char **reason)
{
    char path[LOG_PATH_SIZE];
    if (process_is_elevated()) {
        *reason = "a process with elevated privileges writes no file";
        return NULL;
    }
    if (!log_filename_expand(filename, path)) {
        *reason = strerror(ENAMETOOLONG);
        return NULL;
    }
    FILE *file = file_open_to_append(path);
    *reason = strerror(errno);
    return file;
}

static void choose_file(struct log *log, const struct settings *settings,
                        struct kept_lines *warnings)
{
    const char *filename = settings->log_filename, *reason;
    log->file = stderr;
    if (!log->is_active || !filename || text_equals_in_any_case(filename, "stderr"))
        return;
    if (text_equals_in_any_case(filename, "stdout")) {
        log->file = stdout;
        return;
    }
    FILE *file = open_file(filename, &reason);
    if (file) {
        log->file = file;
        log->is_owned = true;
        return;
    }
    kept_lines_say(warnings,
                   "assay_validation.log_filename: {} cannot be opened for writing ({}). The "
                   "default, stderr, is used.",
                   quoted(filename, FILENAME_SHOWN), phrase(reason));
}

VkResult log_open(struct log *log, const struct settings *settings, struct kept_lines *warnings)
{
    log->is_active = settings->debug_action & (DEBUG_ACTION_LOG | DEBUG_ACTION_DEFAULT);
    pthread_mutex_init(&log->lock, NULL);
    if (log->is_active && settings->log_format == LOG_FORMAT_JSON) {
        log->json = malloc(sizeof(*log->json));
        if (!log->json)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    choose_file(log, settings, warnings);
    return VK_SUCCESS;
}

int log_open_new(struct log *log, const char *path)
{
    *log = (struct log){.is_active = true, .is_owned = true};
    log->json = malloc(sizeof(*log->json));
    if (!log->json)
        return ENOMEM;
    log->file = file_open_new(path);
    if (!log->file) {
        free(log->json);
        return errno;
    }
    pthread_mutex_init(&log->lock, NULL);
    return 0;
}

void log_close(struct log *log)
{
    if (log->is_owned)
        fclose(log->file);
    if (log->file || log->json)
        pthread_mutex_destroy(&log->lock);
    free(log->json);
}

/* ---- writing */

/* Writes all of the data with one call, unless the file takes only a part of it. A newline ends the
 * part of a line that an earlier failure has left. Returns an error number or 0. */
static int write_all(struct log *log, const char *data, size_t size)
{
    const int descriptor = file_descriptor(log->file);
    size_t newline = log->is_torn, done = 0, written;
    while (done < size) {
        int error = file_write(descriptor, "\n", newline, data + done, size - done, &written);
        if (error) {
            log->is_torn |= done != 0;
            return error;
        }
        done += written - newline;
        newline = 0;
    }
    log->is_torn = false;
    return 0;
}

/* Returns the error of the first failure; later ones return 0. */
static int first_failure(struct log *log, int error)
{
    return error && !atomic_exchange(&log->has_failed, true) ? error : 0;
}

/* Writes the line that was composed, if it is complete, and releases the lock. */
static int finish_line(struct log *log, bool is_complete)
{
    int error = EOVERFLOW;
    if (is_complete) {
        if (!log->is_owned)
            fflush(log->file); /* the application's text comes first */
        struct write_signals blocked;
        file_block_signals(&blocked);
        error = write_all(log, log->json->line, log->json->text.length);
        file_unblock_signals(&blocked, error);
    }
    pthread_mutex_unlock(&log->lock);
    return first_failure(log, error);
}

static int write_text(struct log *log, const struct message *message)
{
    struct write_signals blocked;
    file_block_signals(&blocked);
    errno = 0;
    message_write(message, log->file);
    int error = !ferror(log->file) ? 0 : errno ? errno : EIO;
    file_unblock_signals(&blocked, error);
    return first_failure(log, error);
}

int log_message(struct log *log, const struct message *message, const struct settings *settings)
{
    if (!log->json)
        return write_text(log, message);
    pthread_mutex_lock(&log->lock);
    return finish_line(log, line_of_message(log->json, message, settings->spec_text));
}

int log_header(struct log *log, const VkApplicationInfo *application,
               const struct settings *settings)
{
    if (!log->json)
        return 0;
    pthread_mutex_lock(&log->lock);
    return finish_line(log, line_of_header(log->json, application, settings));
}

int log_device(struct log *log, VkDevice device, const char *name,
               const VkPhysicalDeviceDriverProperties *driver)
{
    if (!log->json)
        return 0;
    pthread_mutex_lock(&log->lock);
    return finish_line(log, line_of_device(log->json, device, name, driver));
}

int log_summary(struct log *log, const struct settings *settings,
                const struct duplicates *duplicates, struct unchecked_counts *unchecked)
{
    if (!log->json)
        return 0;
    pthread_mutex_lock(&log->lock);
    return finish_line(log, line_of_summary(log->json, settings, duplicates, unchecked));
}

int log_add(struct log *log, const struct log_record *record)
{
    if (!log->json)
        return 0;
    pthread_mutex_lock(&log->lock);
    return finish_line(log, line_of_record(log->json, record));
}
