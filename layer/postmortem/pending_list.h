/* SPDX-License-Identifier: Apache-2.0 */
/* Words the list of the builds that the device may be executing. */
#ifndef ASSAY_LAYER_POSTMORTEM_PENDING_LIST_H
#define ASSAY_LAYER_POSTMORTEM_PENDING_LIST_H

#include "layer/layer.h"
#include "src/base/text_buffer.h"

enum { PENDING_LISTED = 20 };

/* Appends "1 build was submitted ..." and the builds, PENDING_LISTED at most, the likeliest culprit
 * first: builds whose inputs had been copied and that had not finished, in the order of submission;
 * then those of unknown progress, those that the device had not reached, and those that had
 * finished. Returns their number; appends nothing if there are none.
 *
 * Unless `waits`, this neither allocates nor waits for a lock, so a signal handler may call it. It
 * then returns 0 if another thread uses the list; names and sizes are missing if it cannot get
 * them. Not for two threads at once. */
uint32_t pending_list_append(const struct layer_device *device, bool waits,
                             struct text_buffer *text);

#endif
