/* SPDX-License-Identifier: Apache-2.0 */
/* A position in a buffer. */
#ifndef ASSAY_SNAPSHOTS_BUFFER_TARGET_H
#define ASSAY_SNAPSHOTS_BUFFER_TARGET_H

#include "src/state/resources/resources.h"

struct buffer_target {
    VkBuffer buffer;
    VkDeviceSize offset, size; /* bytes from the offset to the buffer's end */
    bool is_protected;         /* unprotected commands may not access it */
};

/* The buffer that has the address now. Returns false, with zeros in `target`, if no buffer has it
 * or if that is unknown. */
bool buffer_target_find(struct resources *resources, VkDeviceAddress address,
                        struct buffer_target *target);

#endif
