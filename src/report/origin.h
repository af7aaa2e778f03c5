/* SPDX-License-Identifier: Apache-2.0 */
/* The call that a finding is about. */
#ifndef ASSAY_REPORT_ORIGIN_H
#define ASSAY_REPORT_ORIGIN_H

#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct call_site;
struct destroyed_objects;
struct object_names;
struct label_stack;

/* The objects that a message names in addition to the finding's. Members may be null or 0. */
struct call_origin {
    VkDevice device;
    VkCommandBuffer command_buffer;
    uint32_t build_index; /* builds recorded in the command buffer before this call */
    const struct object_names *names;
    const struct label_stack *labels;  /* of the command buffer */
    const struct call_site *call_site; /* of the call that recorded the build, or made it */
    /* The submission, if the finding arose from one. */
    VkQueue queue;
    uint64_t submission; /* number of the call that submitted to the queue, from 1; 0: unknown */
    const struct label_stack *queue_labels;
    /* Number of references that the layer replaced by 0 because of the mistake (setting guard). */
    uint32_t replaced;
    /* When the data was read, if that was not after completion: static text such as "read after the
     * device was lost". */
    const char *when;
    /* The objects that were destroyed, for addresses; and the number of calls that had submitted
     * work when the build was submitted, or now. NULL: unknown. */
    struct destroyed_objects *destroyed;
    uint64_t submissions;
};

#endif
