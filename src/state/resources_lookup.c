/* SPDX-License-Identifier: Apache-2.0 */
/* What the records say: facts about structures and addresses. */
#include "state/resource_records.h"

unsigned resources_begin_reading(struct resources *resources)
{
    return reader_lock_enter(&resources->lock);
}

void resources_end_reading(struct resources *resources, unsigned token)
{
    reader_lock_leave(&resources->lock, token);
}

static bool is_sparse(const struct buffer_record *buffer)
{
    return buffer->flags & VK_BUFFER_CREATE_SPARSE_BINDING_BIT;
}

/* Whether bytes [begin, end) of a buffer lie in live memory. */
static enum tristate backing(const struct buffer_record *buffer, VkDeviceSize begin,
                             VkDeviceSize end)
{
    if (!buffer->alive)
        return NO;
    if (is_sparse(buffer))
        return buffer_record_sparse_backing(buffer, begin, end);
    if (buffer->bound != YES)
        return buffer->bound;
    return buffer->memory->alive ? YES : NO;
}

static struct memory_span span_of(const struct buffer_record *buffer, VkDeviceSize begin,
                                  VkDeviceSize end)
{
    if (is_sparse(buffer) || buffer->bound != YES || !buffer->memory->alive ||
        buffer->instances_differ)
        return (struct memory_span){0};
    return (struct memory_span){.memory = buffer->memory->handle,
                                .begin = buffer->memory_offset + begin,
                                .end = buffer->memory_offset + end};
}

void resources_find_accel(const struct resources *resources, VkAccelerationStructureKHR handle,
                          struct accel_facts *facts)
{
    *facts = (struct accel_facts){.handle = handle};
    if (!handle)
        return;
    const struct accel_record *accel =
        handle_table_find(&resources->accels, (uint64_t)(uintptr_t)handle);
    if (!accel) {
        facts->alive = resources->incomplete ? UNKNOWN : NO;
        return;
    }
    facts->alive = YES;
    facts->id = accel->id;
    facts->details_known = true;
    facts->type = accel->type;
    facts->create_flags = accel->flags;
    facts->size = accel->size;
    facts->offset = accel->offset;
    if (!accel->buffer)
        return;
    VkDeviceSize end = accel->offset + accel->size;
    facts->buffer = accel->buffer->handle;
    facts->backed = backing(accel->buffer, accel->offset, end);
    facts->in_pieces = accel->buffer->alive && is_sparse(accel->buffer);
    if (accel->buffer->alive)
        facts->span = span_of(accel->buffer, accel->offset, end);
}

void resources_find_pieces(struct resources *resources, VkBuffer handle, VkDeviceSize begin,
                           VkDeviceSize end,
                           void (*visit)(void *user, const struct memory_span *piece), void *user)
{
    unsigned token = resources_begin_reading(resources);
    const struct buffer_record *buffer =
        handle_table_find(&resources->buffers, (uint64_t)(uintptr_t)handle);
    if (buffer)
        buffer_record_sparse_pieces(buffer, begin, end, visit, user);
    resources_end_reading(resources, token);
}

uint64_t resources_deaths(struct resources *resources)
{
    return atomic_load_explicit(&resources->deaths, memory_order_relaxed);
}

bool resources_has_accel(struct resources *resources, VkAccelerationStructureKHR handle)
{
    unsigned token = resources_begin_reading(resources);
    bool found = handle_table_find(&resources->accels, (uint64_t)(uintptr_t)handle) != NULL;
    resources_end_reading(resources, token);
    return found;
}

static enum address_status status_in(const struct buffer_record *buffer)
{
    if (is_sparse(buffer))
        return ADDRESS_IN_BUFFER;
    switch (backing(buffer, 0, buffer->size)) {
    case YES:
        return ADDRESS_IN_BUFFER;
    case NO:
        return ADDRESS_UNBOUND;
    case UNKNOWN:
        break;
    }
    return ADDRESS_UNKNOWN;
}

/* Where buffers share an address a bound one outweighs an unbound one. One whose binding isn't
 * known outweighs both: its usage and its size may be what makes the address good. */
static int weight(enum address_status status)
{
    switch (status) {
    case ADDRESS_UNKNOWN:
        return 3;
    case ADDRESS_IN_BUFFER:
        return 2;
    case ADDRESS_UNBOUND:
        return 1;
    case ADDRESS_NULL:
    case ADDRESS_NOWHERE:
        break;
    }
    return 0;
}

static void add_buffer_facts(void *record, void *context)
{
    const struct buffer_record *buffer = record;
    struct address_facts *facts = context;
    enum address_status status = status_in(buffer);
    if (weight(status) < weight(facts->status))
        return;
    if (weight(status) > weight(facts->status)) {
        facts->status = status;
        facts->usage = 0;
        facts->bytes_left = 0;
    }
    facts->usage |= buffer->usage;
    VkDeviceSize offset = facts->address - buffer->address;
    if (buffer->size - offset <= facts->bytes_left)
        return;
    facts->buffer = buffer->handle;
    facts->buffer_id = buffer->id;
    facts->buffer_offset = offset;
    facts->bytes_left = buffer->size - offset;
    facts->span = span_of(buffer, offset, buffer->size);
    facts->in_pieces = is_sparse(buffer);
}

void resources_find_address(const struct resources *resources, VkDeviceAddress address,
                            struct address_facts *facts)
{
    *facts = (struct address_facts){.address = address, .status = ADDRESS_NULL};
    if (!address)
        return;
    facts->status = resources->incomplete ? ADDRESS_UNKNOWN : ADDRESS_NOWHERE;
    if (!resources->incomplete)
        address_map_find(&resources->addresses, address, add_buffer_facts, facts);
}
