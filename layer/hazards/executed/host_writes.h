/* SPDX-License-Identifier: Apache-2.0 */
/* Setting hazards: finds inputs of builds that the application overwrites before it knows that the
 * build is complete.
 *
 * When a batch reaches its execution point, the layer takes hashes of the inputs that its builds
 * certainly read, as far as nothing but the host can write them: mapped, coherent memory, in
 * buffers that no command writes, on a device whose shaders write through no address. Before the
 * application submits or waits again, it takes them once more.
 *
 * The functions accept NULL, and may be called on any thread. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_HOST_WRITES_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_HOST_WRITES_H

#include "layer/layer.h"
#include "src/state/order/order.h"

struct host_writes;

/* Sets device->host_writes; NULL if setting hazards is off. Call once the device has an order. */
VkResult host_writes_create(struct layer_device *device);
void host_writes_destroy(struct host_writes *host_writes);
struct batch_consumer host_writes_consumer(struct host_writes *host_writes);

/* Compares the inputs of the batches that are not complete, as far as the host has observed. */
void host_writes_look(struct host_writes *host_writes);
/* The host may have let batches go on that waited: it may have written their inputs in time. */
void host_writes_forget(struct host_writes *host_writes);
/* Shaders may write any memory from now on. */
void host_writes_stop(struct host_writes *host_writes);

#endif
