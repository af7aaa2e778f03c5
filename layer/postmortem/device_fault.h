/* SPDX-License-Identifier: Apache-2.0 */
/* What VK_EXT_device_fault says about a lost device. */
#ifndef ASSAY_LAYER_POSTMORTEM_DEVICE_FAULT_H
#define ASSAY_LAYER_POSTMORTEM_DEVICE_FAULT_H

#include "layer/layer.h"
#include "src/base/text_buffer.h"

/* Appends the driver's description and addresses, each with the buffer and structure in whose range
 * it lies, live or destroyed. Returns false, and appends nothing, if the application has not
 * enabled the feature deviceFault, or if the driver has nothing to say. */
bool device_fault_append(const struct layer_device *device, bool on_new_line,
                         struct text_buffer *text);

#endif
