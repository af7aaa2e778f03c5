/* SPDX-License-Identifier: Apache-2.0 */
/* Reports findings: filters them, limits duplicates, composes the message, and gives it to the
 * messengers of an instance, to the log, or both (setting debug_action).
 *
 * Thread-safe. No lock of the reporter is held while a callback runs. */
#ifndef ASSAY_REPORT_REPORTER_H
#define ASSAY_REPORT_REPORTER_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

#include "src/report/message.h"
#include "src/report/settings.h"
#include "src/view/finding.h"
#include "src/view/location.h"
#include "vuid-tables/rules.h"

struct reporter;

/* Creates the reporter of an instance. Reads the settings, and the messengers in the chain of
 * `create_info`; these are called while the instance is created and destroyed. */
VkResult reporter_create(const VkInstanceCreateInfo *create_info, struct reporter **out);
void reporter_destroy(struct reporter *reporter);
/* Creates a reporter without messengers and log, which has the settings of another reporter. Reads
 * nothing else of that reporter. Returns NULL if memory runs out. */
struct reporter *reporter_create_silent(const struct reporter *of);

/* Call with true when the instance has been created, and with false before it is destroyed. In
 * between, the messengers of the create info are silent. */
void reporter_set_instance_alive(struct reporter *reporter, bool alive);

const struct settings *reporter_settings(const struct reporter *reporter);

/* Adds and removes messengers that the application creates and destroys. */
VkResult reporter_add_messenger(struct reporter *reporter, VkDebugUtilsMessengerEXT handle,
                                const VkDebugUtilsMessengerCreateInfoEXT *create_info);
void reporter_remove_messenger(struct reporter *reporter, VkDebugUtilsMessengerEXT handle);
VkResult reporter_add_report_callback(struct reporter *reporter, VkDebugReportCallbackEXT handle,
                                      const VkDebugReportCallbackCreateInfoEXT *create_info);
void reporter_remove_report_callback(struct reporter *reporter, VkDebugReportCallbackEXT handle);

/* Returns false if further findings of this id, in this call of the application, make no
 * difference: messages of this id are filtered, or over their limit. */
bool reporter_wants(const struct reporter *reporter, enum vuid vuid);

/* Sends one finding. Returns true to skip the call: a callback returned VK_TRUE, or debug_action
 * has DEBUG_ACTION_FAIL and the finding is an error, even if its message is held back. */
bool reporter_send(struct reporter *reporter, enum rule rule, const struct location *location,
                   const struct call_origin *origin, const struct finding *finding);

/* Whether this thread has called reporter_send() since it called reporter_begin_call(). */
void reporter_begin_call(void);
bool reporter_has_sent(void);

/* Differences of compared rays have severity warning. */
bool reporter_wants_difference(const struct reporter *reporter, enum difference difference);
void reporter_send_difference(struct reporter *reporter, enum difference difference,
                              const struct location *location, const struct call_origin *origin,
                              const struct finding *finding);

/* Hazards have severity error. */
bool reporter_wants_hazard(const struct reporter *reporter, enum hazard_id hazard);
struct hazard_report;
void reporter_send_hazard(struct reporter *reporter, const struct hazard_report *report);

/* Sends an advice, and counts those that its message says are not listed. */
struct advice_report;
void reporter_send_advice(struct reporter *reporter, const struct advice_report *report,
                          VkDevice device);

/* Sends a message of the layer about itself (such as an invalid setting, or that memory ran out),
 * with severity warning. */
void reporter_warn(struct reporter *reporter, const char *line);
/* Words a line of up to 1023 bytes, as text_say() does, and warns with it. */
void reporter_warn_words(struct reporter *reporter, const char *says, const struct value *values,
                         uint32_t count);
#define reporter_say_warning(reporter, says, ...)                                                  \
    reporter_warn_words((reporter), (says), VALUES(__VA_ARGS__))

/* Sends a message about the device, such as its loss, with severity warning and an id of its own.
 * duplicate_message_limit does not apply. */
void reporter_report_event(struct reporter *reporter, const char *id, const char *text);
bool reporter_has_warnings(const struct reporter *reporter);

/* For a signal handler: where messages are logged, and whether as JSON. Returns -1: nowhere. */
int reporter_log_descriptor(const struct reporter *reporter, bool *is_json);
/* Stops calls of the application's callbacks for good. */
void reporter_silence_callbacks(struct reporter *reporter);

/* Reports with severity error that the layer cannot execute a call. */
void reporter_report_unsupported(struct reporter *reporter, const char *line);

/* Counts something that was not validated, for the summary. `what` is static text in the plural,
 * such as "builds without memory for copies". */
void reporter_add_unchecked(struct reporter *reporter, const char *what, uint32_t count);

/* Writes all messages, as lines of JSON, to a new file, too, until the reporter is destroyed. Only
 * the first such file of a reporter gets any. Returns 0 or an error number. */
int reporter_copy_messages(struct reporter *reporter, const char *path);

/* Logs a device that the application has created, if log_format is json. */
void reporter_add_device(struct reporter *reporter, VkDevice device, const char *name,
                         const VkPhysicalDeviceDriverProperties *driver);

/* Logs a record of setting record_builds, or an announced finding, if log_format is json. */
struct log_record;
void reporter_record(struct reporter *reporter, const struct log_record *record);

/* If report_flags has REPORT_INFO, these send one line with severity information: about the layer,
 * when an instance is created, and about its findings, at its end. */
void reporter_announce(struct reporter *reporter, const char *version);
void reporter_summarize(struct reporter *reporter);

#endif
