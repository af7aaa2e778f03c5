/* SPDX-License-Identifier: Apache-2.0 */
/* Words the list of the builds that the device may be executing. */
#ifndef ASSAY_LAYER_POSTMORTEM_PENDING_LIST_H
#define ASSAY_LAYER_POSTMORTEM_PENDING_LIST_H

#include "layer/layer.h"
#include "src/base/text_buffer.h"

enum { PENDING_LISTED = 20 };

/* Device addresses that the device or the process accessed without right. */
struct pending_faults {
    struct {
        uint64_t begin, end;
        uint64_t structure; /* the handle of the one there, or 0 */
    } ranges[8];
    uint32_t count;
};

/* Appends "1 build was submitted ..." and the builds, PENDING_LISTED at most, the likeliest culprit
 * first: builds with findings about their inputs; builds whose structures or inputs contain a
 * faulting address; builds whose inputs had been copied and that had not finished, in the order of
 * submission; then those of unknown progress, those that the device had not reached, and those that
 * had finished. Returns their number; appends nothing if there are none.
 *
 * Unless `waits`, this neither allocates nor waits for a lock, so a signal handler may call it. It
 * then returns 0 if another thread uses the list; names and sizes are missing if it cannot get
 * them. Not for two threads at once. `faults`: NULL if none are known. */
uint32_t pending_list_append(const struct layer_device *device, bool waits,
                             const struct pending_faults *faults, struct text_buffer *text);

#endif
