/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the report of a crash, and keeps the devices that it is about. A signal handler must not
 * use the lock of the log, which the interrupted thread may hold, so it writes to the file itself.
 */
#include "layer/postmortem/postmortem.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "layer/execution/input_checks.h"
#include "src/base/text_buffer.h"
#include "src/platform/crash_handler.h"
#include "src/platform/files.h"
#include "src/platform/threads.h"
#include "src/report/finding_message.h"
#include "src/report/log/json.h"
#include "src/report/log/lines.h"
#include "src/report/words.h"

/* Where an instance logs. */
struct crash_output {
    int descriptor; /* -1: nowhere */
    bool is_json;
};

/* What the handler words. Static, because the stack of a signal handler is small. */
static struct {
    struct message message;
    struct json json;
    char lines[MESSAGE_LINES_SIZE];
} report;

static void write_all(int descriptor, const struct text_buffer *text)
{
    size_t done = 0, written;
    while (done < text->length) {
        if (file_write(descriptor, text->text + done, text->length - done, NULL, 0, &written) != 0)
            return;
        done += written;
    }
}

/* Writes a warning to the log and, if that is JSON or another file, as text to stderr. Neither
 * allocates nor locks; not for two threads at once. */
static void crash_output_write(const struct crash_output *output, const char *words)
{
    const int descriptor = output->descriptor;
    struct text_buffer text;
    message_of_event(&report.message, REPORT_WARNING, "ASSAY-crash", words);
    text_begin(&text, report.lines, sizeof(report.lines));
    message_append_lines(&report.message, &text);
    if (descriptor >= 0 && output->is_json &&
        line_of_message(&report.json, &report.message, SPEC_TEXT_NONE))
        write_all(descriptor, &report.json.text);
    else if (descriptor >= 0 && !output->is_json && descriptor != FILES_STDERR)
        write_all(descriptor, &text);
    if (descriptor != FILES_STDERR || !output->is_json)
        write_all(FILES_STDERR, &text);
}

/* ---- devices */

enum { DEVICES_MAX = 16 };

static struct {
    pthread_mutex_t lock; /* of the members up to `devices`; the handler only reads them */
    struct {
        struct layer_device *_Atomic device;
        struct crash_output output;
    } devices[DEVICES_MAX];
    char text[MESSAGE_SIZE];
} crash = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* Runs in the thread of the crash handler. */
static bool validate(void)
{
    bool is_done = true;
    for (int i = 0; i < DEVICES_MAX; i++) {
        struct layer_device *device = atomic_load(&crash.devices[i].device);
        if (!device)
            continue;
        reporter_silence_callbacks(device->instance->reporter);
        is_done &= input_checks_read_marked(device->input_checks, "read when the process crashed");
    }
    return is_done;
}

/* ---- the report */

static void append_event(struct text_buffer *text, const struct crash_event *event)
{
    text_say(text, "The process received {}", phrase(event->name));
    if (event->has_address)
        text_say(text, event->is_of_instruction ? " at instruction {}" : " for address {}",
                 hex(event->address));
    text_append(text, ". ");
}

/* Returns whether the device has builds that may be incomplete. */
static bool report_device(int i, const struct crash_event *event)
{
    const struct layer_device *device = atomic_load(&crash.devices[i].device);
    struct text_buffer text;
    if (!device)
        return false;
    text_begin(&text, crash.text, sizeof(crash.text));
    append_event(&text, event);
    const struct pending_faults faults = {{{event->address, event->address + 1, 0}}};
    const bool has_fault = event->has_address && !event->is_of_instruction;
    if (!pending_list_append(device, false, has_fault ? &faults : NULL, &text))
        return false;
    crash_output_write(&crash.devices[i].output, crash.text);
    return device->input_checks;
}

static void report_crash(const struct crash_event *event)
{
    bool has_inputs[DEVICES_MAX], has_any = false;
    for (int i = 0; i < DEVICES_MAX; i++) {
        has_inputs[i] = report_device(i, event);
        has_any |= has_inputs[i];
    }
    if (!has_any || crash_handler_validate())
        return;
    for (int i = 0; i < DEVICES_MAX; i++)
        if (has_inputs[i])
            crash_output_write(&crash.devices[i].output,
                               "The inputs of these builds that had been copied could not be "
                               "validated, or not all of them.");
}

/* ---- devices */

/* A child process has neither the thread nor the devices of its parent. */
static void leave_parent(void)
{
    if (!crash_handler_is_of_parent())
        return;
    pthread_mutex_init(&crash.lock, NULL);
    for (int i = 0; i < DEVICES_MAX; i++)
        atomic_store(&crash.devices[i].device, NULL);
    crash_handler_leave_parent();
}

/* The slot of a device, or of none if it is NULL. Returns DEVICES_MAX if there is no such slot. */
static int find_slot(const struct layer_device *device)
{
    int i = 0;
    while (i < DEVICES_MAX && atomic_load(&crash.devices[i].device) != device)
        i++;
    return i;
}

static bool has_devices(void)
{
    bool has_any = false;
    for (int i = 0; i < DEVICES_MAX; i++)
        has_any |= atomic_load(&crash.devices[i].device) != NULL;
    return has_any;
}

static bool is_wanted(const struct layer_device *device)
{
    const struct reporter *reporter = device->instance->reporter;
    return reporter_settings(reporter)->crash_report && reporter_has_warnings(reporter) &&
           device->submitted_builds;
}

void crash_add_device(struct layer_device *device)
{
    if (!is_wanted(device))
        return;
    leave_parent();
    pthread_mutex_lock(&crash.lock);
    if (!has_devices())
        crash_handler_install(&(struct crash_hooks){report_crash, validate});
    int i = find_slot(NULL);
    if (i < DEVICES_MAX) {
        struct crash_output *output = &crash.devices[i].output;
        output->descriptor = reporter_log_descriptor(device->instance->reporter, &output->is_json);
        atomic_store(&crash.devices[i].device, device);
    }
    pthread_mutex_unlock(&crash.lock);
}

void crash_remove_device(struct layer_device *device)
{
    if (!is_wanted(device) || crash_handler_is_of_parent())
        return;
    pthread_mutex_lock(&crash.lock);
    int i = find_slot(device);
    if (i < DEVICES_MAX)
        atomic_store(&crash.devices[i].device, NULL);
    if (i < DEVICES_MAX && !has_devices())
        crash_handler_uninstall();
    pthread_mutex_unlock(&crash.lock);
    crash_handler_wait(); /* a handler may use the device */
}
