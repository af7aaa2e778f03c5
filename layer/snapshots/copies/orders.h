/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of what builds read. A build resolves device addresses when it executes, and so does the
 * shader that copies (copy.comp); where it may read is decided at each submission. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_ORDERS_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_ORDERS_H

#include "layer/snapshots/recorder.h"

/* Records what was ordered since the last flush. */
void copy_orders_flush(struct recorder *recorder);

/* Records that the device sets the mark of the copies by vkCmdCopyBuffer. */
void copy_orders_mark(const struct recorder *recorder);

/* Before a recording is submitted with the ticket `next`: buffers have come and gone since it was
 * recorded. What the device still executes stays as it is. Likewise for secondaries. */
void copy_orders_renew(const struct layer_device *device, struct recording *recording,
                       const struct ticket *next);

#endif
