/* SPDX-License-Identifier: Apache-2.0 */
/* Decides which messages are sent, and sends them to messengers and log. */
#include "src/report/reporter.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/text_buffer.h"
#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/finding_message.h"
#include "src/report/hazard_message.h"
#include "src/report/ids/message_filter.h"
#include "src/report/log/log.h"
#include "src/report/messengers.h"
#include "src/report/settings.h"
#include "src/report/settings/reported_lines.h"
#include "src/report/summary.h"
#include "src/report/words.h"

/* All members but the messengers and the counts are constant. */
struct reporter {
    struct settings settings;
    struct messengers messengers;
    struct log log;
    struct duplicates duplicates;
    struct unchecked_counts unchecked;
    bool has_begun; /* the log is open and has its header */
    /* How many messages of the layer about itself may still be sent. */
    _Atomic uint32_t warnings_left, unsupported_left;
    atomic_bool only_logs;      /* the process crashes */
    struct log *_Atomic copies; /* owned; NULL: none */
};

enum { LINE_SIZE = 1024 };

static const uint32_t NO_LIMIT = UINT32_MAX;

/* ---- sending */

static struct message_style style_of(const struct reporter *reporter)
{
    return (struct message_style){
        .vuid_names = reporter->settings.vuid_names,
        .spec_text = reporter->settings.spec_text,
    };
}

static bool is_logged(const struct reporter *reporter, bool delivered)
{
    uint32_t action = reporter->settings.debug_action;
    return action & DEBUG_ACTION_LOG ||
           (action & DEBUG_ACTION_DEFAULT && (!delivered || reporter->log.is_owned));
}

static bool is_for_debugger(const struct reporter *reporter, bool delivered)
{
    uint32_t action = reporter->settings.debug_action;
    return PROCESS_HAS_DEBUGGER_OUTPUT &&
           (action & DEBUG_ACTION_DEBUGGER || (action & DEBUG_ACTION_DEFAULT && !delivered));
}

/* Warns once that the log cannot be written: the messengers and, if the log is a file, stderr.
 * `error` is 0 or an error number. */
static void warn_of_log(struct reporter *reporter, int error)
{
    if (!error || !(reporter->settings.report_flags & REPORT_WARNING))
        return;
    struct message message;
    struct text_buffer text;
    char line[LINE_SIZE];
    bool delivered;
    text_begin(&text, line, sizeof(line));
    text_say(&text,
             "assay_validation.log_filename: the log cannot be written ({}). Messages are missing "
             "in it.",
             phrase(strerror(error)));
    message_of_layer(&message, REPORT_WARNING, line);
    messengers_call(&reporter->messengers, &message, &delivered);
    if (reporter->log.is_owned)
        message_write(&message, stderr);
}

/* Sets `delivered` if a messenger got the message. Returns true to skip the call. */
static bool deliver_message(struct reporter *reporter, const struct message *message,
                            bool *delivered)
{
    *delivered = false;
    bool skip = !atomic_load(&reporter->only_logs) &&
                messengers_call(&reporter->messengers, message, delivered);
    if (is_logged(reporter, *delivered))
        warn_of_log(reporter, log_message(&reporter->log, message, &reporter->settings));
    struct log *copies = atomic_load(&reporter->copies);
    if (copies)
        log_message(copies, message, &reporter->settings);
    if (is_for_debugger(reporter, *delivered))
        message_write_to_debugger(message);
    if (reporter->settings.debug_action & DEBUG_ACTION_BREAK && message->severity == REPORT_ERROR)
        process_break();
    return skip;
}

/* Returns whether setting debug_action skips a call with a finding of this id. */
static bool is_failed(const struct reporter *reporter, enum vuid vuid)
{
    return reporter->settings.debug_action & DEBUG_ACTION_FAIL &&
           reporter->duplicates.ids[vuid].is_enabled && !vuid_is_warning(vuid);
}

bool reporter_wants(const struct reporter *reporter, enum vuid vuid)
{
    return duplicates_wanted(&reporter->duplicates, vuid);
}

/* A finding of a rule, if `vuid` is set; else a hazard, an advice, or a difference. */
struct report {
    const enum vuid *vuid;
    enum rule rule;
    enum difference difference;
    const struct location *location;
    const struct call_origin *origin;
    const struct finding *finding;
    const struct hazard_report *hazard;
    const struct advice_report *advice;
};

static void message_of_report(struct message *message, const struct report *report,
                              const struct message_style *style)
{
    if (report->vuid) {
        message_of_finding(message, *report->vuid, report->location, report->origin,
                           report->finding, style);
        message->level = rule_infos[report->rule].level; /* warnings of one id may differ */
    } else if (report->hazard) {
        message_of_hazard(message, report->hazard, style);
    } else if (report->advice) {
        message_of_advice(message, report->advice, style);
    } else {
        message_of_difference(message, report->difference, report->location, report->origin,
                              report->finding, style);
    }
}

/* Returns false if the message is muted. Else `skip` says whether a callback skips the call. */
static bool send_report(struct reporter *reporter, uint32_t id, VkDevice device,
                        const struct message_subject *subject, const struct report *report,
                        bool *skip)
{
    const struct narrow_filter *filters = reporter->settings.narrow_filters;
    struct message_style style = style_of(reporter);
    struct message message;
    bool delivered;
    *skip = false;
    if (narrow_filters_have(filters, id)) {
        message_of_report(&message, report, &style);
        if (message_is_muted(&message, filters, id))
            return false;
    }
    const uint32_t shown =
        report->vuid ? reported_vuid(*report->vuid, &style, report->location, report->finding) : id;
    if (!duplicates_add(&reporter->duplicates, id, shown, device, subject, &style))
        return true;
    message_of_report(&message, report, &style);
    *skip = deliver_message(reporter, &message, &delivered);
    return true;
}

static _Thread_local bool thread_has_sent;

void reporter_begin_call(void)
{
    thread_has_sent = false;
}

bool reporter_has_sent(void)
{
    return thread_has_sent;
}

bool reporter_send(struct reporter *reporter, enum rule rule, const struct location *location,
                   const struct call_origin *origin, const struct finding *finding)
{
    const enum vuid vuid = rule_infos[rule].vuid[location->command];
    const struct message_subject subject = message_subject_of(origin, finding);
    bool skip;
    thread_has_sent = true;
    return send_report(reporter, vuid, origin->device, &subject,
                       &(struct report){.vuid = &vuid,
                                        .rule = rule,
                                        .location = location,
                                        .origin = origin,
                                        .finding = finding},
                       &skip) &&
           (skip || is_failed(reporter, vuid));
}

bool reporter_wants_difference(const struct reporter *reporter, enum difference difference)
{
    return duplicates_wanted(&reporter->duplicates, reported_other(difference));
}

void reporter_send_difference(struct reporter *reporter, enum difference difference,
                              const struct location *location, const struct call_origin *origin,
                              const struct finding *finding)
{
    const struct message_subject subject = message_subject_of(origin, finding);
    bool skip;
    send_report(
        reporter, reported_other(difference), origin->device, &subject,
        &(struct report){
            .difference = difference, .location = location, .origin = origin, .finding = finding},
        &skip);
}

bool reporter_wants_hazard(const struct reporter *reporter, enum hazard_id hazard)
{
    return duplicates_wanted(&reporter->duplicates, reported_other(other_id_of_hazard(hazard)));
}

void reporter_send_hazard(struct reporter *reporter, const struct hazard_report *report)
{
    const struct message_subject subject = hazard_subject(report);
    const enum hazard_id hazard = hazard_id_of(&report->hazard);
    bool skip;
    send_report(reporter, reported_other(other_id_of_hazard(hazard)), report->later.origin.device,
                &subject, &(struct report){.hazard = report}, &skip);
}

void reporter_send_advice(struct reporter *reporter, const struct advice_report *report,
                          VkDevice device)
{
    const struct message_subject subject = {report->type, report->object};
    const uint32_t id = reported_other(other_id_of_advice(report->advice));
    bool skip;
    send_report(reporter, id, device, &subject, &(struct report){.advice = report}, &skip);
    duplicates_hold(&reporter->duplicates, id, report->more);
}

static void send_line(struct reporter *reporter, _Atomic uint32_t *messages,
                      enum report_flag severity, const char *line)
{
    bool delivered;
    uint32_t left;
    if (!duplicates_take(messages, &left))
        return;
    struct message message;
    message_of_layer(&message, severity, line);
    deliver_message(reporter, &message, &delivered);
}

void reporter_warn(struct reporter *reporter, const char *line)
{
    send_line(reporter, &reporter->warnings_left, REPORT_WARNING, line);
}

void reporter_warn_words(struct reporter *reporter, const char *says, const struct value *values,
                         uint32_t count)
{
    char line[LINE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    words_append(&(const struct words){.text = &text}, says, values, count);
    reporter_warn(reporter, line);
}

void reporter_report_unsupported(struct reporter *reporter, const char *line)
{
    send_line(reporter, &reporter->unsupported_left, REPORT_ERROR, line);
}

static uint32_t allowed_messages(const struct settings *settings, enum report_flag severity)
{
    uint32_t limit = settings->duplicate_message_limit;
    if (settings->debug_action & DEBUG_ACTION_IGNORE || !(settings->report_flags & severity))
        return 0;
    return limit ? limit : NO_LIMIT;
}

bool reporter_has_warnings(const struct reporter *reporter)
{
    return allowed_messages(&reporter->settings, REPORT_WARNING) != 0;
}

void reporter_report_event(struct reporter *reporter, const char *id, const char *text)
{
    struct message message;
    bool delivered;
    message_of_event(&message, REPORT_WARNING, id, text);
    if (reporter_has_warnings(reporter))
        deliver_message(reporter, &message, &delivered);
}

int reporter_log_descriptor(const struct reporter *reporter, bool *is_json)
{
    *is_json = reporter->log.json;
    return reporter->log.is_active ? file_descriptor(reporter->log.file) : -1;
}

void reporter_silence_callbacks(struct reporter *reporter)
{
    atomic_store(&reporter->only_logs, true);
}

static bool is_informing(const struct reporter *reporter)
{
    const struct settings *settings = &reporter->settings;
    return settings->report_flags & REPORT_INFO && !(settings->debug_action & DEBUG_ACTION_IGNORE);
}

static void send_information(struct reporter *reporter, const char *line)
{
    struct message message;
    bool delivered;
    message_of_layer(&message, REPORT_INFO, line);
    deliver_message(reporter, &message, &delivered);
}

void reporter_announce(struct reporter *reporter, const char *version)
{
    char line[MESSAGE_SIZE];
    struct text_buffer text;
    if (!is_informing(reporter))
        return;
    text_begin(&text, line, sizeof(line));
    summary_append_start(&text, version, &reporter->settings);
    send_information(reporter, line);
}

void reporter_summarize(struct reporter *reporter)
{
    char line[MESSAGE_SIZE];
    struct text_buffer text;
    if (!is_informing(reporter))
        return;
    text_begin(&text, line, sizeof(line));
    unchecked_add_unknown(&reporter->unchecked);
    summary_append_end(&text, &reporter->settings, &reporter->duplicates, &reporter->unchecked);
    send_information(reporter, line);
}

int reporter_copy_messages(struct reporter *reporter, const char *path)
{
    struct log *none = NULL;
    if (atomic_load(&reporter->copies))
        return 0;
    struct log *copies = calloc(1, sizeof(*copies));
    const int error = copies ? log_open_new(copies, path) : ENOMEM;
    if (!error && atomic_compare_exchange_strong(&reporter->copies, &none, copies))
        return 0;
    if (!error)
        log_close(copies);
    free(copies);
    return error;
}

void reporter_add_unchecked(struct reporter *reporter, const char *what, uint32_t count)
{
    unchecked_add(&reporter->unchecked, what, count);
}

void reporter_add_device(struct reporter *reporter, VkDevice device, const char *name,
                         const VkPhysicalDeviceDriverProperties *driver)
{
    warn_of_log(reporter, log_device(&reporter->log, device, name, driver));
}

void reporter_record(struct reporter *reporter, const struct log_record *record)
{
    warn_of_log(reporter, log_add(&reporter->log, record));
}

/* ---- creation */

static void allow_messages(struct reporter *reporter)
{
    const struct settings *settings = &reporter->settings;
    duplicates_enable(&reporter->duplicates, settings);
    atomic_init(&reporter->warnings_left, allowed_messages(settings, REPORT_WARNING));
    atomic_init(&reporter->unsupported_left, allowed_messages(settings, REPORT_ERROR));
}

/* Sends each line once per process. */
static void send_kept_line(struct reporter *reporter, const char *line)
{
    struct message message;
    bool delivered;
    if (!reporter->warnings_left || !reported_lines_add(line))
        return;
    message_of_layer(&message, REPORT_WARNING, line);
    deliver_message(reporter, &message, &delivered);
    if (delivered || is_logged(reporter, delivered))
        reported_lines_keep();
    else
        reported_lines_remove(line);
}

/* Ignores duplicate_message_limit, because no two lines are equal. */
static void send_kept_lines(struct reporter *reporter, struct kept_lines *kept)
{
    for (size_t i = 0; i < kept->count; i++)
        send_kept_line(reporter, kept->lines[i]);
    kept_lines_free(kept);
}

VkResult reporter_create(const VkInstanceCreateInfo *create_info, struct reporter **out)
{
    struct reporter *reporter = calloc(1, sizeof(*reporter));
    if (!reporter)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    messengers_init(&reporter->messengers);
    duplicates_init(&reporter->duplicates);
    unchecked_init(&reporter->unchecked);
    struct kept_lines kept = {0};
    VkResult result = messengers_add_chain(&reporter->messengers, create_info->pNext);
    if (result == VK_SUCCESS)
        result = settings_load(create_info, &kept, &reporter->settings);
    if (result == VK_SUCCESS)
        settings_check(&reporter->settings, &kept);
    if (result == VK_SUCCESS)
        result = log_open(&reporter->log, &reporter->settings, &kept);
    if (result == VK_SUCCESS) {
        allow_messages(reporter);
        warn_of_log(reporter,
                    log_header(&reporter->log, create_info->pApplicationInfo, &reporter->settings));
        reporter->has_begun = true;
    }
    /* If creation has failed, all limits are 0, so this only frees the lines. */
    send_kept_lines(reporter, &kept);
    if (result != VK_SUCCESS) {
        reporter_destroy(reporter);
        return result;
    }
    *out = reporter;
    return VK_SUCCESS;
}

struct reporter *reporter_create_silent(const struct reporter *of)
{
    struct reporter *reporter = calloc(1, sizeof(*reporter));
    if (!reporter)
        return NULL;
    messengers_init(&reporter->messengers);
    duplicates_init(&reporter->duplicates);
    unchecked_init(&reporter->unchecked);
    reporter->settings = of->settings;
    settings_disown(&reporter->settings);
    reporter->settings.report_flags = 0;
    reporter->settings.debug_action = DEBUG_ACTION_IGNORE;
    reporter->settings.log_format = LOG_FORMAT_TEXT;
    allow_messages(reporter);
    return reporter;
}

void reporter_destroy(struct reporter *reporter)
{
    if (!reporter)
        return;
    unchecked_add_unknown(&reporter->unchecked);
    if (reporter->has_begun)
        warn_of_log(reporter, log_summary(&reporter->log, &reporter->settings,
                                          &reporter->duplicates, &reporter->unchecked));
    log_close(&reporter->log);
    if (reporter->copies)
        log_close(reporter->copies);
    free(reporter->copies);
    duplicates_destroy(&reporter->duplicates);
    unchecked_destroy(&reporter->unchecked);
    settings_release(&reporter->settings);
    messengers_destroy(&reporter->messengers);
    free(reporter);
}

void reporter_set_instance_alive(struct reporter *reporter, bool alive)
{
    atomic_store(&reporter->messengers.instance_alive, alive);
}

const struct settings *reporter_settings(const struct reporter *reporter)
{
    return &reporter->settings;
}

VkResult reporter_add_messenger(struct reporter *reporter, VkDebugUtilsMessengerEXT handle,
                                const VkDebugUtilsMessengerCreateInfoEXT *create_info)
{
    return messengers_add(&reporter->messengers, handle, create_info);
}

void reporter_remove_messenger(struct reporter *reporter, VkDebugUtilsMessengerEXT handle)
{
    messengers_remove(&reporter->messengers, VK_OBJECT_TYPE_DEBUG_UTILS_MESSENGER_EXT,
                      (uint64_t)handle);
}

VkResult reporter_add_report_callback(struct reporter *reporter, VkDebugReportCallbackEXT handle,
                                      const VkDebugReportCallbackCreateInfoEXT *create_info)
{
    return messengers_add_report_callback(&reporter->messengers, handle, create_info);
}

void reporter_remove_report_callback(struct reporter *reporter, VkDebugReportCallbackEXT handle)
{
    messengers_remove(&reporter->messengers, VK_OBJECT_TYPE_DEBUG_REPORT_CALLBACK_EXT,
                      (uint64_t)handle);
}
