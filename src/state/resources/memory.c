/* SPDX-License-Identifier: Apache-2.0 */
/* Creates and destroys struct resources; the records of memory, and its host mappings. */
#include <stdlib.h>

#include "src/state/resources/records.h"
#include "src/state/resources/resources.h"

VkResult resources_create(struct resources **resources)
{
    *resources = calloc(1, sizeof(**resources));
    if (!*resources)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    return VK_SUCCESS;
}

static void free_accel(void *record)
{
    accel_record_free(record);
}

static void free_buffer(void *record)
{
    buffer_record_release(record);
}

static void free_memory(void *record)
{
    memory_record_release(record);
}

void resources_destroy(struct resources *resources)
{
    if (!resources)
        return;
    resources_release_nv(resources);
    resources_release_references(resources);
    handle_table_drop(&resources->accels, free_accel);
    handle_table_drop(&resources->micromaps, free);
    handle_table_drop(&resources->buffers, free_buffer);
    handle_table_drop(&resources->memories, free_memory);
    address_map_release(&resources->addresses);
    free(resources->watched.changes);
    free(resources);
}

/* ---- memory */

static void remove_memory(struct resources *resources, VkDeviceMemory handle)
{
    struct memory_record *memory = handle_table_remove(&resources->memories, handle_number(handle));
    if (!memory)
        return;
    resources_count_destroyed(resources);
    memory_record_unmap(resources, memory);
    memory->alive = false;
    nv_accel_records_end_memory(resources, memory);
    for (struct buffer_record *buffer = memory->buffers; buffer; buffer = buffer->next)
        resources_refresh(resources, buffer);
    memory_record_release(memory);
}

void resources_add_memory(struct resources *resources, VkDeviceMemory handle, VkDeviceSize size,
                          uint32_t type, VkMemoryPropertyFlags properties, bool multi_instance)
{
    struct memory_record *memory = malloc(sizeof(*memory));
    if (memory)
        *memory = (struct memory_record){.references = 1,
                                         .alive = true,
                                         .handle = handle,
                                         .size = size,
                                         .type = type,
                                         .properties = properties,
                                         .multi_instance = multi_instance};
    reader_lock_write(&resources->lock);
    remove_memory(resources, handle);
    if (memory)
        memory->id = ++resources->last_id;
    if (!resources_publish(resources, &resources->memories, handle_number(handle), memory))
        free(memory);
    reader_lock_write_done(&resources->lock);
}

void resources_remove_memory(struct resources *resources, VkDeviceMemory handle)
{
    reader_lock_write(&resources->lock);
    remove_memory(resources, handle);
    reader_lock_write_done(&resources->lock);
}

/* ---- Host mappings of memory. A linear search suffices: few allocations are mapped at a time, and
 * only host builds search them. */

void memory_record_unmap(struct resources *resources, struct memory_record *memory)
{
    if (memory->mapped_begin == memory->mapped_end)
        return;
    if (memory->previous_mapped)
        memory->previous_mapped->next_mapped = memory->next_mapped;
    else
        resources->mapped = memory->next_mapped;
    if (memory->next_mapped)
        memory->next_mapped->previous_mapped = memory->previous_mapped;
    memory->previous_mapped = memory->next_mapped = NULL;
    memory->mapped_begin = memory->mapped_end = 0;
}

static void map(struct resources *resources, struct memory_record *memory, VkDeviceSize offset,
                VkDeviceSize size, const void *pointer)
{
    memory_record_unmap(resources, memory);
    memory->is_shared = true;
    if (offset > memory->size)
        return;
    if (size > memory->size - offset)
        size = memory->size - offset;
    if (!size)
        return;
    memory->mapped_begin = (uint64_t)(uintptr_t)pointer;
    memory->mapped_end = memory->mapped_begin + size;
    memory->mapped_offset = offset;
    memory->next_mapped = resources->mapped;
    if (memory->next_mapped)
        memory->next_mapped->previous_mapped = memory;
    resources->mapped = memory;
}

void resources_share_memory(struct resources *resources, VkDeviceMemory handle)
{
    reader_lock_write(&resources->lock);
    struct memory_record *memory = resources_memory(resources, handle);
    if (memory)
        memory->is_shared = memory->is_foreign = true;
    reader_lock_write_done(&resources->lock);
}

void resources_map_memory(struct resources *resources, VkDeviceMemory handle, VkDeviceSize offset,
                          VkDeviceSize size, const void *pointer)
{
    reader_lock_write(&resources->lock);
    struct memory_record *memory = resources_memory(resources, handle);
    if (memory)
        map(resources, memory, offset, size, pointer);
    reader_lock_write_done(&resources->lock);
}

void resources_unmap_memory(struct resources *resources, VkDeviceMemory handle)
{
    reader_lock_write(&resources->lock);
    struct memory_record *memory = resources_memory(resources, handle);
    if (memory)
        memory_record_unmap(resources, memory);
    reader_lock_write_done(&resources->lock);
}

/* Returns the span that begins at `begin` and ends at `end` at most. */
static struct memory_span piece_at(const struct resources *resources, uint64_t begin, uint64_t end)
{
    struct memory_span piece = {memory_of_host(), begin, end};
    for (const struct memory_record *memory = resources->mapped; memory;
         memory = memory->next_mapped) {
        if (memory->mapped_begin <= begin && begin < memory->mapped_end) {
            VkDeviceSize offset = memory->mapped_offset + (begin - memory->mapped_begin);
            uint64_t left = memory->mapped_end - begin;
            return (struct memory_span){memory->handle, offset,
                                        offset + (left < end - begin ? left : end - begin)};
        }
        if (begin < memory->mapped_begin && memory->mapped_begin < piece.end)
            piece.end = memory->mapped_begin;
    }
    return piece;
}

void resources_find_host_pieces(struct resources *resources, const void *pointer, VkDeviceSize size,
                                void (*visit)(void *user, const struct memory_span *piece),
                                void *user)
{
    uint64_t begin = (uint64_t)(uintptr_t)pointer;
    uint64_t end = size < UINT64_MAX - begin ? begin + size : UINT64_MAX;
    unsigned token = resources_begin_reading(resources);
    while (begin < end) {
        struct memory_span piece = piece_at(resources, begin, end);
        visit(user, &piece);
        begin += piece.end - piece.begin;
    }
    resources_end_reading(resources, token);
}

/* Finds the host mapping of an address. Returns how many bytes are mapped from there on. */
static uint64_t find_bytes(const struct resources *resources, const struct address_facts *facts,
                           const void **bytes)
{
    const struct memory_record *memory = resources_memory(resources, facts->memory);
    if (!memory || !(memory->properties & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) ||
        facts->begin < memory->mapped_offset)
        return 0;
    uint64_t skipped = facts->begin - memory->mapped_offset;
    uint64_t size = memory->mapped_end - memory->mapped_begin;
    if (skipped >= size)
        return 0;
    *bytes = (const void *)(uintptr_t)(memory->mapped_begin + skipped);
    return size - skipped;
}

/* Whether a command may write some of the bytes through a buffer. */
static bool has_writers(const struct memory_record *memory, const struct mapped_bytes *bytes)
{
    for (const struct buffer_record *buffer = memory->buffers; buffer; buffer = buffer->next)
        if (!buffer_is_only_read(buffer->where.usage) &&
            buffer->memory_offset < bytes->begin + bytes->size &&
            bytes->begin < buffer->memory_offset + buffer->where.bytes_left)
            return true;
    return false;
}

/* Returns NULL unless the host alone writes to the memory, or commands through other buffers. */
static const struct memory_record *host_memory_of(const struct resources *resources,
                                                  const struct mapped_bytes *bytes)
{
    const struct buffer_record *buffer = resources_buffer(resources, bytes->buffer);
    const struct memory_record *memory = buffer && buffer->bound == YES ? buffer->memory : NULL;
    if (!memory || !memory->alive || memory->id != bytes->memory_id || memory->is_foreign ||
        memory->multi_instance || unknown_is_set(&resources->unknown) ||
        !(memory->properties & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT))
        return NULL;
    return buffer->is_external || !buffer_is_only_read(buffer->where.usage) ? NULL : memory;
}

static const void *find_host_bytes(const struct resources *resources,
                                   const struct mapped_bytes *bytes)
{
    const struct memory_record *memory = host_memory_of(resources, bytes);
    if (!memory || !bytes->size || bytes->begin < memory->mapped_offset)
        return NULL;
    const uint64_t mapped = memory->mapped_end - memory->mapped_begin,
                   skipped = bytes->begin - memory->mapped_offset;
    if (skipped > mapped || bytes->size > mapped - skipped || has_writers(memory, bytes))
        return NULL;
    return (const void *)(uintptr_t)(memory->mapped_begin + skipped);
}

bool resources_visit_mapped(struct resources *resources, const struct mapped_bytes *wanted,
                            void (*visit)(void *user, const void *bytes, uint64_t size), void *user)
{
    unsigned token = resources_begin_reading(resources);
    const void *bytes = find_host_bytes(resources, wanted);
    if (bytes)
        visit(user, bytes, wanted->size);
    resources_end_reading(resources, token);
    return bytes != NULL;
}

uint64_t resources_find_mapped(struct resources *resources, VkDeviceAddress address, uint64_t size,
                               const void **bytes)
{
    struct address_facts facts;
    uint64_t found = 0;
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &facts);
    if (facts.status == ADDRESS_IN_BUFFER && facts.memory)
        found = find_bytes(resources, &facts, bytes);
    resources_end_reading(resources, token);
    if (facts.bytes_left < found)
        found = facts.bytes_left;
    return found < size ? found : size;
}
