/* SPDX-License-Identifier: Apache-2.0 */
/* Telling what level content doesn't look at. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COVERAGE_WARNINGS_H
#define ASSAY_LAYER_SNAPSHOTS_COVERAGE_WARNINGS_H

#include "layer/snapshots/snapshots.h"

/* Builds of a command buffer, and of secondaries that it executes, that were left out when they
 * were recorded; each recording once. */
void warn_left_out(const struct layer_device *device, VkCommandBuffer handle);

/* What was left out after the recording: builds of so many executions. */
struct missed_executions {
    uint32_t no_memory;   /* for lack of memory */
    uint32_t overwritten; /* by another of the same submission */
    uint32_t unread;      /* before they were submitted again */
    uint32_t repeated;    /* though they execute once */
    uint32_t device_lost; /* with their device */
    uint32_t held;        /* before signals that nobody submitted */
};
void warn_missed(const struct layer_device *device, const struct missed_executions *missed);

/* Once, of the executions whose order isn't known: why, and that those to come share their fate. */
void warn_unordered(const struct layer_device *device);

/* Once: the driver completes submissions, and has not executed the copies in them. */
void warn_lack_of_copies(const struct layer_device *device);

#endif
