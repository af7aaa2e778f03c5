/* SPDX-License-Identifier: Apache-2.0 */
/* What is reported when the device is lost. */
#ifndef ASSAY_LAYER_POSTMORTEM_LOSS_H
#define ASSAY_LAYER_POSTMORTEM_LOSS_H

#include "layer/layer.h"

/* Called with the first VK_ERROR_DEVICE_LOST of a device, without a lock: validates the inputs that
 * had been copied, lists the builds that may not be complete, and makes the execution order
 * unknown. Does nothing on later calls. */
void postmortem_report_loss(struct layer_device *device);

/* Each intercept of a command that can return VK_ERROR_DEVICE_LOST passes its result through this
 * before it returns. */
static inline VkResult postmortem_see(struct layer_device *device, VkResult result)
{
    if (__builtin_expect(result == VK_ERROR_DEVICE_LOST, false))
        postmortem_report_loss(device);
    return result;
}

#endif
