/* SPDX-License-Identifier: Apache-2.0 */
/* The lines of log_format = json; json/findings.schema.json describes them.
 *
 * The functions that return bool begin and end a line. They return false if the line is not
 * complete. */
#ifndef ASSAY_REPORT_LOG_LINES_H
#define ASSAY_REPORT_LOG_LINES_H

#include "src/report/log/json.h"
#include "src/report/message.h"
#include "src/report/settings.h"
#include "src/report/summary.h"

/* Begins a line with the members that all lines have. The other functions call it. */
void line_begin(struct json *json, const char *type);

/* `application` may be NULL. */
bool line_of_header(struct json *json, const VkApplicationInfo *application,
                    const struct settings *settings);
/* `driver` may lack names. */
bool line_of_device(struct json *json, VkDevice device, const char *name,
                    const VkPhysicalDeviceDriverProperties *driver);
bool line_of_message(struct json *json, const struct message *message, enum spec_text spec_text);
bool line_of_summary(struct json *json, const struct settings *settings,
                     const struct duplicates *duplicates, struct unchecked_counts *unchecked);

#endif
