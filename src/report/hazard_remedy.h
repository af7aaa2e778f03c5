/* SPDX-License-Identifier: Apache-2.0 */
/* Words why two accesses are not ordered, and what orders them: what the barrier between them
 * lacks, or which barrier, semaphore or wait to add. */
#ifndef ASSAY_REPORT_HAZARD_REMEDY_H
#define ASSAY_REPORT_HAZARD_REMEDY_H

#include "src/report/hazard_message.h"

/* Appends the sentences. */
void hazard_append_remedy(struct text_buffer *text, struct message *message,
                          const struct hazard_report *report);
/* Appends that a wait of the host timed out; nothing if `timeout` is 0. */
void hazard_append_timeout(struct text_buffer *text, uint64_t timeout);

#endif
