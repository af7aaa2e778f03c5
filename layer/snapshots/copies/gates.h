/* SPDX-License-Identifier: Apache-2.0 */
/* Gates: words of memory that the layer's shaders read first. While a recording's gate is closed,
 * its dispatches read and write nothing else.
 *
 * An application may by mistake resubmit a command buffer that it began with ONE_TIME_SUBMIT. By
 * then the chunks that its dispatches name may belong to other recordings, but its gate still
 * belongs to its own recording. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_GATES_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_GATES_H

#include "layer/snapshots/snapshots.h"
#include "src/snapshots/recording.h"

/* The gates of a device; usable from any thread. */
struct gates;

VkResult gates_create(const struct layer_device *device, struct gates **gates);
void gates_destroy(struct gates *gates); /* accepts NULL */

/* Takes a closed gate. Returns false without memory. */
bool gates_take(struct gates *gates, struct recording_gate *gate);
void gates_give_back(struct gates *gates, const struct recording_gate *gate);

#endif
