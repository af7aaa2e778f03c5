/* SPDX-License-Identifier: Apache-2.0 */
/* Marks around builds: words that the device fills before and behind the builds of a call, so that
 * the host sees how far it got if it is lost or hangs. Only on backend driver. */
#ifndef ASSAY_LAYER_SNAPSHOTS_MARKS_H
#define ASSAY_LAYER_SNAPSHOTS_MARKS_H

#include "layer/snapshots/recorder.h"

/* The words of a device; usable from any thread. */
struct marks;

VkResult marks_create(const struct layer_device *device, struct marks **marks);
void marks_destroy(struct marks *marks); /* accepts NULL */
void marks_give_back(struct marks *marks, const struct build_mark *mark);

/* Called behind the copies of a call, whose barrier makes them visible to the host: records the
 * first fill. Without memory the call has no mark. */
void recorder_mark_reached(const struct recorder *recorder);
/* Called behind the call itself: records the second fill, if the first one was recorded. */
void recorder_mark_finished(VkCommandBuffer handle);

#endif
