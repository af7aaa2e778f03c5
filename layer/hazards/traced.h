/* SPDX-License-Identifier: Apache-2.0 */
/* Records which structures a command may trace. */
#ifndef ASSAY_LAYER_HAZARDS_TRACED_H
#define ASSAY_LAYER_HAZARDS_TRACED_H

#include "layer/hazards/recording.h"
#include "src/state/commands/journal.h"

/* Adds an entry for each structure that is bound, if no other can be traced. The entry of the trace
 * itself follows. */
void hazards_add_traced(struct hazard_recording *recording, enum access_kind kind,
                        enum traced_point point);

#endif
