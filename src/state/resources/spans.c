/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups for reports of a loss: where an object lies, and what lies at an address. */
#include "src/state/resources/records.h"

static bool find_span(const struct resources *resources, VkObjectType type, uint64_t handle,
                      struct resource_span *span)
{
    const struct buffer_record *buffer = handle_table_find(&resources->buffers, handle);
    const struct accel_record *accel = handle_table_find(&resources->accels, handle);
    if (type == VK_OBJECT_TYPE_BUFFER && buffer)
        *span = (struct resource_span){buffer->where.address, buffer->where.bytes_left};
    else if (type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR && accel)
        *span = (struct resource_span){accel->address, accel->facts.size};
    else
        return false;
    return true;
}

bool resources_find_span(struct resources *resources, VkObjectType type, uint64_t handle,
                         bool waits, struct resource_span *span)
{
    unsigned token;
    *span = (struct resource_span){0};
    if (waits)
        token = resources_begin_reading(resources);
    else if (!reader_lock_try_enter(&resources->lock, &token))
        return false;
    bool found = find_span(resources, type, handle, span);
    resources_end_reading(resources, token);
    return found;
}

struct resources_at resources_find_at(struct resources *resources, VkDeviceAddress address)
{
    struct resources_at at = {0};
    struct address_facts facts;
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &facts);
    const struct buffer_record *buffer = resources_buffer(resources, facts.buffer);
    at.buffer = buffer ? facts.buffer : VK_NULL_HANDLE;
    for (const struct accel_record *accel = buffer ? buffer->accels : NULL; accel;
         accel = accel->next)
        if (address - buffer->where.address - accel->offset < accel->facts.size)
            at.structure = accel->facts.handle;
    resources_end_reading(resources, token);
    return at;
}
