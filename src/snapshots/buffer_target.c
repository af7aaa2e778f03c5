/* SPDX-License-Identifier: Apache-2.0 */
/* Finds buffers by address. */
#include "src/snapshots/buffer_target.h"

bool buffer_target_find(struct resources *resources, VkDeviceAddress address,
                        struct buffer_target *target)
{
    struct address_facts facts;
    struct buffer_facts buffer;
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &facts);
    resources_find_buffer(resources, facts.buffer, &buffer);
    resources_end_reading(resources, token);
    *target = (struct buffer_target){0};
    if (facts.status != ADDRESS_IN_BUFFER)
        return false;
    *target = (struct buffer_target){facts.buffer, buffer.size - facts.bytes_left, facts.bytes_left,
                                     facts.is_protected};
    return true;
}
