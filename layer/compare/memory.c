/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers with dedicated memory, which live as long as one comparison. */
#include "layer/compare/memory.h"

VkResult compare_buffer_create(const struct compare_device *device, VkBufferUsageFlags usage,
                               uint64_t size, bool is_mapped, struct own_buffer *buffer)
{
    const struct own_device own = compare_own_device(device);
    return own_buffer_create(&own, usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, size,
                             is_mapped, buffer);
}

void compare_buffer_free(const struct compare_device *device, struct own_buffer *buffer)
{
    const struct own_device own = compare_own_device(device);
    own_buffer_free(&own, buffer);
}
