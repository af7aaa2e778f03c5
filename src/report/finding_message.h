/* SPDX-License-Identifier: Apache-2.0 */
/* Words the message of a finding, with the sentence of the specification. */
#ifndef ASSAY_REPORT_FINDING_MESSAGE_H
#define ASSAY_REPORT_FINDING_MESSAGE_H

#include "src/base/text_buffer.h"
#include "src/report/ids/message_id.h"
#include "src/report/message.h"
#include "src/report/settings.h"
#include "vuid-tables/rules.h"

/* Appends the sentence as `spec_text` says; nothing if the registry lacks it. */
void specification_append_sentence(struct text_buffer *text, const struct vuid_text *vuid,
                                   enum spec_text_setting spec_text);
/* Appends the address of the sentence. */
void specification_append_url(struct text_buffer *text, const struct vuid_text *vuid);

/* ---- words findings, differences of compared rays, and what the layer says about itself */

void message_of_finding(struct message *message, enum vuid vuid, const struct location *location,
                        const struct call_origin *origin, const struct finding *finding,
                        const struct message_style *style);

/* A warning about a difference of compared rays. It quotes no sentence of the specification. */
void message_of_difference(struct message *message, enum difference difference,
                           const struct location *location, const struct call_origin *origin,
                           const struct finding *finding, const struct message_style *style);

/* Advice about an object, for the end of a run (setting advice). */
struct advice_report {
    enum advice advice;
    VkObjectType type;
    uint64_t object;
    char name[MESSAGE_NAME_SIZE];     /* debug name, when it was alive; "": none */
    const struct object_names *names; /* of the objects that `finding` names; or NULL */
    struct finding finding; /* `says` follows the object: "was built once and never compacted" */
    uint32_t more;          /* number of objects with this advice that are not listed */
};
void message_of_advice(struct message *message, const struct advice_report *report,
                       const struct message_style *style);

/* A message of the layer about itself, not about a rule. */
void message_of_layer(struct message *message, enum report_flag severity, const char *line);

/* A message of the layer that has an id of its own, such as ASSAY-device-lost. */
void message_of_event(struct message *message, enum report_flag severity, const char *id,
                      const char *line);

#endif
