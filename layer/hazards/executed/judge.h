/* SPDX-License-Identifier: Apache-2.0 */
/* Judges batches one by one, in execution order: gives their accesses and synchronization to the
 * hazard check, and reports what it finds. One thread at a time, without a lock. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_JUDGE_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_JUDGE_H

#include "layer/hazards/executed/reports.h"

/* `judge` is zero-initialized. Returns false if memory runs out. */
bool hazard_judge_begin(struct hazard_judge *judge, struct layer_device *device);
void hazard_judge_end(struct hazard_judge *judge);
/* Takes over the batch, whose references are all known, and lets go of it later. */
void hazard_judge_batch(struct hazard_judge *judge, struct hazard_batch_record *batch);
/* Drops the record of an object. No batch that is yet to be judged uses it. */
void hazard_judge_end_object(struct hazard_judge *judge, const struct ended_object *ended);

#endif
