/* SPDX-License-Identifier: Apache-2.0 */
/* A place in a buffer. */
#ifndef ASSAY_SNAPSHOTS_BUFFER_TARGET_H
#define ASSAY_SNAPSHOTS_BUFFER_TARGET_H

#include "src/state/resources/resources.h"

struct buffer_target {
    VkBuffer buffer;
    VkDeviceSize offset, size; /* bytes from the offset to the buffer's end */
    bool is_protected;         /* unprotected commands may not access it */
};

/* What has the address now; false, and zeros, if nothing has it or it is not known. */
bool buffer_target_find(struct resources *resources, VkDeviceAddress address,
                        struct buffer_target *target);

#endif
