/* SPDX-License-Identifier: Apache-2.0 */
/* Validates inputs of builds that have been copied, though the submission is not complete. */
#ifndef ASSAY_LAYER_POSTMORTEM_MARKED_INPUTS_H
#define ASSAY_LAYER_POSTMORTEM_MARKED_INPUTS_H

#include "layer/layer.h"

/* `when` is for the messages, such as "read after the device was lost". Returns false if another
 * thread validates now, so that some may be left. */
bool marked_inputs_read(struct layer_device *device, const char *when);

#endif
