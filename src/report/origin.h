/* SPDX-License-Identifier: Apache-2.0 */
/* Where a finding comes from: the call, and how far it had come. */
#ifndef ASSAY_REPORT_ORIGIN_H
#define ASSAY_REPORT_ORIGIN_H

#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct object_names;
struct label_stack;

/* Who made the call: what a message names beside the finding. Members may be null or 0. */
struct call_origin {
    VkDevice device;
    VkCommandBuffer command_buffer;
    uint32_t build_index; /* builds recorded in the command buffer before this call */
    const struct object_names *names;
    const struct label_stack *labels; /* of the command buffer */
    VkQueue queue; /* that the command buffer was submitted to, if that told the finding */
};

#endif
