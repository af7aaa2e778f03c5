/* SPDX-License-Identifier: Apache-2.0 */
/* Quotes the specification. */
#ifndef ASSAY_REPORT_SPECIFICATION_H
#define ASSAY_REPORT_SPECIFICATION_H

#include "src/base/text_buffer.h"
#include "src/report/settings.h"
#include "vuid-tables/rules.h"

/* Appends the sentence as `spec_text` says; nothing if the registry lacks it. */
void specification_append_sentence(struct text_buffer *text, const struct vuid_text *vuid,
                                   enum spec_text spec_text);
/* Appends the address of the sentence. */
void specification_append_url(struct text_buffer *text, const struct vuid_text *vuid);

/* Appends a line with the sentence, its address, and the other ids of the same sentence. `named` is
 * the message's id. If the message has the current id, retired ids are appended. */
void specification_append(struct text_buffer *text, enum vuid vuid, const char *named,
                          enum spec_text spec_text);

#endif
