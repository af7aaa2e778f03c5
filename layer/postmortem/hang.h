/* SPDX-License-Identifier: Apache-2.0 */
/* Waits of the application during which the layer watches whether the device makes progress: if it
 * makes none for hang_seconds, one report lists the builds that it may be executing, and the wait
 * goes on. Results and timeouts are those of the driver. Without builds whose marks are pending, or
 * below level CONTENT, the calls go down as they are. */
#ifndef ASSAY_LAYER_POSTMORTEM_HANG_H
#define ASSAY_LAYER_POSTMORTEM_HANG_H

#include "layer/layer.h"

VkResult hang_wait_for_fences(struct layer_device *device, uint32_t count, const VkFence *fences,
                              VkBool32 all, uint64_t timeout);
VkResult hang_wait_semaphores(struct layer_device *device, PFN_vkWaitSemaphores wait,
                              const VkSemaphoreWaitInfo *info, uint64_t timeout);

/* Called before a wait for idle, which cannot be cut into slices: waits until the executions of a
 * queue, or of all queues if it is VK_NULL_HANDLE, are complete or the device is lost. The layer's
 * own fences tell that, so no queue is used. */
void hang_wait_before_idle(struct layer_device *device, VkQueue queue);

#endif
