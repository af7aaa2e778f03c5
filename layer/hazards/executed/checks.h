/* SPDX-License-Identifier: Apache-2.0 */
/* Setting hazards: gives what batches access, and how they are synchronized, to the hazard check
 * (src/hazards/hazards.h) as they execute, and reports what it finds.
 *
 * At level content a batch that builds top-level structures, triangles with indices, or of memory
 * that the host has never mapped, is judged once the instances, indices and data are known, which
 * is after it has completed, and so are all batches behind it: they say what else the builds
 * access.
 *
 * The functions accept NULL. They may be called on any thread. No lock is held while a message is
 * sent. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_CHECKS_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_CHECKS_H

#include "layer/hazards/executed/reports.h"
#include "layer/layer.h"
#include "src/state/order/order.h"

struct hazard_checks;

/* Sets device->hazard_checks; NULL if setting hazards is off. Call once the device has an order. */
VkResult hazard_checks_create(struct layer_device *device);
/* Judges the batches that are left. */
void hazard_checks_destroy(struct hazard_checks *checks);

/* Keeps each batch that is replayed, from its execution point on. Add it before the consumer that
 * calls hazard_checks_begin_inputs(). */
struct batch_consumer hazard_checks_consumer(struct hazard_checks *checks);
/* An object was freed or destroyed: the hazard check drops its record once the batches before are
 * judged. Ignores id 0. */
void hazard_checks_forget(struct hazard_checks *checks, enum hazard_end ended, uint64_t id);
/* The order is unknown: judges the batches that are left, and no others. */
void hazard_checks_stop(struct hazard_checks *checks);

/* The instances and indices of one command buffer of the batch will be known. For each call
 * hazard_checks_end_inputs() must follow, when they are known or never will be. */
void hazard_checks_begin_inputs(struct hazard_checks *checks, struct order_batch *batch);
/* An instance of the build at `position` of the command buffer refers to a structure. */
void hazard_checks_add_reference(struct hazard_checks *checks, struct order_batch *batch,
                                 const struct journal *journal, uint32_t position,
                                 const struct accel_facts *referenced);
/* What a build of the command buffer reads: a structure, or the indices of a geometry. */
void hazard_checks_add_input(struct hazard_checks *checks, struct order_batch *batch,
                             const struct hazard_input *input);
void hazard_checks_end_inputs(struct hazard_checks *checks, struct order_batch *batch);

#endif
