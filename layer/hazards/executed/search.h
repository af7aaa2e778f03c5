/* SPDX-License-Identifier: Apache-2.0 */
/* Judges batches one by one, in execution order: gives their accesses and synchronization to the
 * hazard check, and reports what it finds. One thread at a time, without a lock. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_SEARCH_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_SEARCH_H

#include "layer/hazards/executed/reports.h"

/* `search` is zero-initialized. Returns false if memory runs out. */
bool hazard_search_begin(struct hazard_search *search, struct layer_device *device);
void hazard_search_end(struct hazard_search *search);
/* Takes over the batch, whose references are all known, and lets go of it later. */
void hazard_search_batch(struct hazard_search *search, struct hazard_batch_record *batch);
/* Drops the record of an object. No batch that is yet to be judged uses it. */
void hazard_search_end_object(struct hazard_search *search, const struct ended_object *ended);

#endif
