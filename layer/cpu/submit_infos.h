/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions as the driver may see them: it knows no stages of ray tracing, at which semaphores
 * may wait and signal. Those without such stages go down as they are. */
#ifndef ASSAY_LAYER_CPU_SUBMIT_INFOS_H
#define ASSAY_LAYER_CPU_SUBMIT_INFOS_H

#include <vulkan/vulkan_core.h>

/* `submit`: the next layer's command. */
VkResult cpu_submit_below(PFN_vkQueueSubmit submit, VkQueue queue, uint32_t count,
                          const VkSubmitInfo *submits, VkFence fence);
VkResult cpu_submit2_below(PFN_vkQueueSubmit2 submit, VkQueue queue, uint32_t count,
                           const VkSubmitInfo2 *submits, VkFence fence);

#endif
