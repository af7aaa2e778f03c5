/* SPDX-License-Identifier: Apache-2.0 */
/* The records of buffers: creation, destruction, binding and addresses; and where an object lies.
 */
#include <stdlib.h>

#include "src/base/chain.h"
#include "src/state/resources/records.h"

static void unbind(struct buffer_record *buffer)
{
    if (buffer->memory) {
        if (buffer->previous)
            buffer->previous->next = buffer->next;
        else
            buffer->memory->buffers = buffer->next;
        if (buffer->next)
            buffer->next->previous = buffer->previous;
        buffer->previous = buffer->next = NULL;
    }
    memory_record_release(buffer->memory);
    buffer->memory = NULL;
    for (uint32_t i = 0; i < buffer->sparse_count; i++)
        memory_record_release(buffer->sparse[i].memory);
    buffer->sparse_count = 0;
}

void buffer_record_release(struct buffer_record *buffer)
{
    if (!buffer || --buffer->references)
        return;
    unbind(buffer);
    free(buffer->sparse);
    free(buffer);
}

static void remove_address(struct resources *resources, struct buffer_record *buffer)
{
    address_map_remove(&resources->addresses, &buffer->where);
    buffer->where.address = 0;
}

static void remove_buffer(struct resources *resources, VkBuffer handle)
{
    struct buffer_record *buffer = handle_table_remove(&resources->buffers, handle_number(handle));
    if (!buffer)
        return;
    if (buffer->where.address) /* structures that refer to the record need no address */
        remove_address(resources, buffer);
    resources_count_destroyed(resources);
    buffer->alive = false;
    resources_refresh(resources, buffer);
    buffer_record_release(buffer);
}

static VkBufferUsageFlags2 usage_of(const VkBufferCreateInfo *create_info)
{
    const VkBufferUsageFlags2CreateInfo *flags2 =
        chain_find(create_info->pNext, VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO);
    return flags2 ? flags2->usage : create_info->usage;
}

static bool is_external(const VkBufferCreateInfo *create_info)
{
    const VkExternalMemoryBufferCreateInfo *external =
        chain_find(create_info->pNext, VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO);
    return external && external->handleTypes;
}

/* Returns whether the application creates the buffer with a captured address, which it need not
 * retrieve again. */
static bool replays_address(const VkBufferCreateInfo *create_info)
{
    const VkBufferOpaqueCaptureAddressCreateInfo *opaque =
        chain_find(create_info->pNext, VK_STRUCTURE_TYPE_BUFFER_OPAQUE_CAPTURE_ADDRESS_CREATE_INFO);
    const VkBufferDeviceAddressCreateInfoEXT *ext =
        chain_find(create_info->pNext, VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_CREATE_INFO_EXT);
    return (opaque && opaque->opaqueCaptureAddress) || (ext && ext->deviceAddress);
}

void resources_add_buffer(struct resources *resources, VkBuffer handle,
                          const VkBufferCreateInfo *create_info)
{
    struct buffer_record *buffer = calloc(1, sizeof(*buffer));
    if (buffer) {
        buffer->references = 1;
        buffer->alive = true;
        buffer->where.buffer = handle;
        buffer->where.bytes_left = create_info->size;
        buffer->where.usage = usage_of(create_info);
        buffer->where.is_protected = create_info->flags & VK_BUFFER_CREATE_PROTECTED_BIT;
        buffer->flags = create_info->flags;
        buffer->is_external = is_external(create_info);
        buffer->bound = NO;
        resources_refresh(resources, buffer);
    }
    reader_lock_write(&resources->lock);
    remove_buffer(resources, handle);
    if (replays_address(create_info))
        resources->replays_addresses = true;
    if (buffer)
        buffer->where.buffer_id = ++resources->last_id;
    if (!resources_publish(resources, &resources->buffers, handle_number(handle), buffer))
        free(buffer);
    reader_lock_write_done(&resources->lock);
}

void resources_remove_buffer(struct resources *resources, VkBuffer handle)
{
    reader_lock_write(&resources->lock);
    remove_buffer(resources, handle);
    reader_lock_write_done(&resources->lock);
}

struct buffer_record *resources_buffer(const struct resources *resources, VkBuffer handle)
{
    return handle_table_find(&resources->buffers, handle_number(handle));
}

struct memory_record *resources_memory(const struct resources *resources, VkDeviceMemory handle)
{
    return handle_table_find(&resources->memories, handle_number(handle));
}

/* Sets the address of a buffer. If there is no memory, the state is incomplete from then on. */
static void add_address(struct resources *resources, struct buffer_record *buffer,
                        VkDeviceAddress address)
{
    buffer->where.address = address;
    if (!address_map_add(&resources->addresses, &buffer->where)) {
        buffer->where.address = 0;
        resources_become_unknown(resources);
    }
}

/* Applications retrieve the same address often, so this compares it before it takes the write
 * lock. */
void resources_set_address(struct resources *resources, VkBuffer handle, VkDeviceAddress address)
{
    unsigned token = resources_begin_reading(resources);
    const struct buffer_record *known = resources_buffer(resources, handle);
    bool is_new = known && known->where.address != address;
    resources_end_reading(resources, token);
    if (!is_new)
        return;

    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = resources_buffer(resources, handle);
    if (buffer && buffer->where.address != address) {
        if (buffer->where.address)
            remove_address(resources, buffer);
        if (address)
            add_address(resources, buffer, address);
    }
    reader_lock_write_done(&resources->lock);
}

static void bind_to_memory(struct buffer_record *buffer)
{
    buffer->memory->references++;
    buffer->next = buffer->memory->buffers;
    if (buffer->next)
        buffer->next->previous = buffer;
    buffer->memory->buffers = buffer;
}

void resources_bind_buffer(struct resources *resources, VkBuffer handle, VkDeviceMemory memory,
                           VkDeviceSize offset, bool instances_differ)
{
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = resources_buffer(resources, handle);
    if (buffer) {
        unbind(buffer);
        buffer->memory = resources_memory(resources, memory);
        buffer->memory_offset = offset;
        buffer->instances_differ = instances_differ;
        buffer->bound = buffer->memory ? YES : UNKNOWN;
        if (buffer->memory)
            bind_to_memory(buffer);
        resources_refresh(resources, buffer);
    }
    reader_lock_write_done(&resources->lock);
}

void resources_forget_binding(struct resources *resources, VkBuffer handle)
{
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = resources_buffer(resources, handle);
    if (buffer) {
        unbind(buffer);
        buffer->bound = UNKNOWN;
        resources_refresh(resources, buffer);
    }
    reader_lock_write_done(&resources->lock);
}

/* ---- Look-ups of where an object lies, and of what lies at an address: device addresses for
 * reports of a loss, bytes of memory for the hazard check. */

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

static bool may_be_micromap(const struct accel_record *accel)
{
    return accel->facts.type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR ||
           accel->facts.type == VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR;
}

bool resources_find_micromap_at(struct resources *resources, VkDeviceAddress address,
                                struct accel_facts *facts)
{
    struct address_facts at;
    uint32_t count = 0;
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &at);
    const struct buffer_record *buffer = at.is_shared || unknown_is_set(&resources->unknown)
                                             ? NULL
                                             : resources_buffer(resources, at.buffer);
    for (const struct accel_record *accel = buffer ? buffer->accels : NULL; accel;
         accel = accel->next)
        if (may_be_micromap(accel) && buffer->where.address + accel->offset == address) {
            *facts = accel->facts;
            count++;
        }
    resources_end_reading(resources, token);
    return count == 1;
}

bool resources_find_before(struct resources *resources, VkDeviceAddress address,
                           struct resources_before *before)
{
    struct address_facts facts;
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &facts);
    const struct address_facts *range =
        facts.status == ADDRESS_NOWHERE ? address_map_before(&resources->addresses, address) : NULL;
    if (range)
        *before =
            (struct resources_before){range->buffer, address - range->address - range->bytes_left};
    resources_end_reading(resources, token);
    return range;
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

struct memory_facts resources_find_memory(struct resources *resources, VkDeviceMemory handle)
{
    unsigned token = resources_begin_reading(resources);
    const struct memory_record *memory = resources_memory(resources, handle);
    const struct memory_facts facts = memory ? (struct memory_facts){.known = true,
                                                                     .size = memory->size,
                                                                     .type = memory->type,
                                                                     .is_shared = memory->is_shared}
                                             : (struct memory_facts){.known = false};
    resources_end_reading(resources, token);
    return facts;
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

static enum tristate find_bytes_at(const struct resources *resources,
                                   const struct address_facts *at, struct memory_bytes *bytes,
                                   bool *is_external)
{
    const struct buffer_record *buffer =
        at->status == ADDRESS_IN_BUFFER ? resources_buffer(resources, at->buffer) : NULL;
    if (!find_bytes(buffer, bytes))
        return at->status == ADDRESS_IN_BUFFER || at->status == ADDRESS_UNKNOWN ? UNKNOWN : NO;
    bytes->begin = at->begin;
    bytes->size = at->bytes_left;
    *is_external = buffer->is_external || buffer->memory->is_foreign;
    return YES;
}

enum tristate resources_find_address_bytes(struct resources *resources, VkDeviceAddress address,
                                           struct memory_bytes *bytes, bool *is_external)
{
    struct address_facts at;
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &at);
    enum tristate found = find_bytes_at(resources, &at, bytes, is_external);
    resources_end_reading(resources, token);
    return found;
}

struct address_visit {
    const struct resources *resources;
    void (*visit)(void *user, const struct addressed_bytes *there);
    void *user;
};

static void visit_addresses(const struct address_facts *range, void *context)
{
    const struct address_visit *visit = context;
    struct addressed_bytes there = {.address = range->address};
    const enum tristate found =
        find_bytes_at(visit->resources, range, &there.bytes, &there.is_external);
    if (found != YES)
        there.bytes = (struct memory_bytes){.size = range->bytes_left};
    if (found != NO)
        visit->visit(visit->user, &there);
}

bool resources_visit_addresses(struct resources *resources,
                               void (*visit)(void *user, const struct addressed_bytes *there),
                               void *user)
{
    struct address_visit context = {resources, visit, user};
    unsigned token = resources_begin_reading(resources);
    const bool are_all = !unknown_is_set(&resources->unknown) && !resources->replays_addresses;
    address_map_each(&resources->addresses, visit_addresses, &context);
    resources_end_reading(resources, token);
    return are_all;
}

bool resources_find_buffer_memory(struct resources *resources, VkBuffer handle,
                                  struct buffer_memory *memory)
{
    struct memory_bytes bytes;
    unsigned token = resources_begin_reading(resources);
    const struct buffer_record *buffer = resources_buffer(resources, handle);
    bool found = find_bytes(buffer, &bytes) && !buffer->memory->multi_instance;
    if (found)
        *memory = (struct buffer_memory){buffer->memory->handle, buffer->memory->properties,
                                         bytes.begin, bytes.size};
    resources_end_reading(resources, token);
    return found;
}

bool resources_find_micromap_bytes(struct resources *resources, VkMicromapEXT handle,
                                   struct memory_bytes *bytes)
{
    unsigned token = resources_begin_reading(resources);
    const struct micromap_record *micromap =
        handle_table_find(&resources->micromaps, handle_number(handle));
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
