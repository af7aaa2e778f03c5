/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of the inputs of builds. A build resolves device addresses when it executes, and so does
 * the shader that copies (copy.comp). Each submission decides what that shader may read. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_ORDERS_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_ORDERS_H

#include "layer/snapshots/recorder.h"

/* Records dispatches for the orders since the last flush. */
void copy_orders_flush(struct recorder *recorder);

/* Records a command that sets the mark of the copies by vkCmdCopyBuffer. */
void copy_orders_mark(const struct recorder *recorder);

/* The orders in the memory that the device reads. */
static inline struct copy_order *copy_orders_at(const struct recording *recording,
                                                const struct copy_orders *orders)
{
    return (struct copy_order *)(recording->chunks[orders->chunk]->bytes + orders->offset);
}

#endif
