/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups of where an object lies, and of what lies at an address: device addresses for reports of
 * a loss, bytes of memory for the hazard check. */
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

/* ---- bytes of memory */

/* Returns 0 if equal offsets need not be equal bytes. */
static uint64_t id_of(const struct memory_record *memory)
{
    return memory && memory->alive && !memory->multi_instance ? memory->id : 0;
}

uint64_t resources_find_memory_id(struct resources *resources, VkDeviceMemory handle)
{
    unsigned token = resources_begin_reading(resources);
    uint64_t id = id_of(resources_memory(resources, handle));
    resources_end_reading(resources, token);
    return id;
}

static bool find_bytes(const struct buffer_record *buffer, struct memory_bytes *bytes)
{
    /* `where.memory` is null if the bytes are not in one piece of one instance. */
    if (!buffer || !buffer->where.memory)
        return false;
    bytes->memory_id = id_of(buffer->memory);
    bytes->begin = buffer->where.begin;
    bytes->size = buffer->where.bytes_left;
    return bytes->memory_id;
}

bool resources_find_buffer_bytes(struct resources *resources, VkBuffer handle,
                                 struct memory_bytes *bytes)
{
    unsigned token = resources_begin_reading(resources);
    bool found = find_bytes(resources_buffer(resources, handle), bytes);
    resources_end_reading(resources, token);
    return found;
}

bool resources_find_micromap_bytes(struct resources *resources, VkMicromapEXT handle,
                                   struct memory_bytes *bytes)
{
    unsigned token = resources_begin_reading(resources);
    const struct micromap_record *micromap =
        handle_table_find(&resources->micromaps, (uint64_t)(uintptr_t)handle);
    const struct buffer_record *buffer =
        micromap ? resources_buffer(resources, micromap->buffer) : NULL;
    bool found = buffer && buffer->where.buffer_id == micromap->buffer_id &&
                 find_bytes(buffer, bytes) && micromap->offset <= bytes->size &&
                 micromap->size <= bytes->size - micromap->offset;
    if (found) {
        bytes->begin += micromap->offset;
        bytes->size = micromap->size;
    }
    resources_end_reading(resources, token);
    return found;
}
