/* SPDX-License-Identifier: Apache-2.0 */
/* From findings to the application's ears: filters, counts duplicates, words the message, and hands
 * it to the messengers of an instance, or to the log where it has none.
 *
 * Thread-safe. No lock of the reporter is held while a callback runs. */
#ifndef ASSAY_REPORT_REPORTER_H
#define ASSAY_REPORT_REPORTER_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

#include "src/report/origin.h"
#include "src/report/settings.h"
#include "src/view/finding.h"
#include "src/view/location.h"
#include "vuid-tables/rules.h"

struct reporter;

/* One per instance. Reads the settings and the messengers in the chain of `create_info`, which
 * serve while the instance is created and destroyed. */
VkResult reporter_create(const VkInstanceCreateInfo *create_info, struct reporter **out);
void reporter_destroy(struct reporter *reporter);

/* Told when the instance has been created (true), and before it is destroyed (false): between the
 * two the messengers of the create info are silent. */
void reporter_set_instance_alive(struct reporter *reporter, bool alive);

const struct settings *reporter_settings(const struct reporter *reporter);

/* Messengers that the application creates and destroys. */
VkResult reporter_add_messenger(struct reporter *reporter, VkDebugUtilsMessengerEXT handle,
                                const VkDebugUtilsMessengerCreateInfoEXT *create_info);
void reporter_remove_messenger(struct reporter *reporter, VkDebugUtilsMessengerEXT handle);
VkResult reporter_add_report_callback(struct reporter *reporter, VkDebugReportCallbackEXT handle,
                                      const VkDebugReportCallbackCreateInfoEXT *create_info);
void reporter_remove_report_callback(struct reporter *reporter, VkDebugReportCallbackEXT handle);

/* False if a message of this id would not go out: filtered, or over its limit. */
bool reporter_wants(const struct reporter *reporter, enum vuid vuid);

/* Sends one finding. Returns true if a callback asked to skip the call. */
bool reporter_send(struct reporter *reporter, enum rule rule, const struct location *location,
                   const struct call_origin *origin, const struct finding *finding);

/* The same of what compared rays found, severity warning. */
bool reporter_wants_difference(const struct reporter *reporter, enum difference difference);
void reporter_send_difference(struct reporter *reporter, enum difference difference,
                              const struct location *location, const struct call_origin *origin,
                              const struct finding *finding);

/* A message of the layer about itself (a bad setting, no memory), severity warning. */
void reporter_warn(struct reporter *reporter, const char *line);

/* The same of severity error: a call that the layer cannot carry out. */
void reporter_report_unsupported(struct reporter *reporter, const char *line);

#endif
