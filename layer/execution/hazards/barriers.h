/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the barrier between two commands of a hazard that lacks a stage or an access on one side.
 */
#ifndef ASSAY_LAYER_EXECUTION_HAZARDS_BARRIERS_H
#define ASSAY_LAYER_EXECUTION_HAZARDS_BARRIERS_H

#include "layer/execution/hazards/reports.h"

/* Fills `barrier` if the accesses are of one queue, and if there is such a barrier; the last one,
 * if there are several. */
void hazard_judge_find_barrier(const struct hazard_judge *judge, const struct hazard *hazard,
                               struct hazard_barrier_text *barrier);

#endif
