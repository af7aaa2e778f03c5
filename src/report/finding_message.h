/* SPDX-License-Identifier: Apache-2.0 */
/* Words findings, differences of compared rays, and what the layer says about itself. */
#ifndef ASSAY_REPORT_FINDING_MESSAGE_H
#define ASSAY_REPORT_FINDING_MESSAGE_H

#include "src/report/ids/other_id.h"
#include "src/report/message.h"

void message_of_finding(struct message *message, enum vuid vuid, const struct location *location,
                        const struct call_origin *origin, const struct finding *finding,
                        const struct message_style *style);

/* A warning about a difference of compared rays. It quotes no sentence of the specification. */
void message_of_difference(struct message *message, enum difference difference,
                           const struct location *location, const struct call_origin *origin,
                           const struct finding *finding, const struct message_style *style);

/* A message of the layer about itself, not about a rule. */
void message_of_layer(struct message *message, enum report_flag severity, const char *line);

/* A message of the layer that has an id of its own, such as ASSAY-device-lost. */
void message_of_event(struct message *message, enum report_flag severity, const char *id,
                      const char *line);

#endif
