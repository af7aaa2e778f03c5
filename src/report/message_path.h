/* SPDX-License-Identifier: Apache-2.0 */
/* Paths of fields, such as pInfos[3].pGeometries[5].flags, and call sites. */
#ifndef ASSAY_REPORT_MESSAGE_PATH_H
#define ASSAY_REPORT_MESSAGE_PATH_H

#include "src/base/text_buffer.h"
#include "src/report/origin.h"
#include "src/view/finding.h"
#include "src/view/location.h"

struct call_site;

/* Appends the build's element of the call's parameters. */
void message_append_build(struct text_buffer *text, enum build_command command, uint32_t build);
/* Appends nothing if the field is "", which stands for the structure itself. */
void message_append_field(struct text_buffer *text, const char *separator, const char *field);
void message_append_path(struct text_buffer *text, const struct location *at, const char *field);

/* Appends a sentence: Called from /usr/bin/app+0x1139, /usr/lib/libengine.so+0x52f0. It has so many
 * frames at most. Signal handlers may call this. */
void message_append_call_site(struct text_buffer *text, const struct call_site *site,
                              uint32_t most);
/* If the value is an address that a destroyed object had, appends which one, and when it was
 * destroyed. */
void message_append_destroyed(struct text_buffer *text, const struct value *value,
                              const struct call_origin *origin);

#endif
