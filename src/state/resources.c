/* SPDX-License-Identifier: Apache-2.0 */
/* How the records of buffers, memory and acceleration structures come and go. */
#include "state/resources.h"

#include <stdlib.h>

#include "state/chain.h"
#include "state/resource_records.h"

VkResult resources_create(struct resources **resources)
{
    *resources = calloc(1, sizeof(**resources));
    if (!*resources)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    reader_lock_init(&(*resources)->lock);
    return VK_SUCCESS;
}

void memory_record_release(struct memory_record *memory)
{
    if (memory && --memory->references == 0)
        free(memory);
}

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

static void take_out_of_buffer(struct accel_record *accel)
{
    if (!accel->buffer)
        return;
    if (accel->previous)
        accel->previous->next = accel->next;
    else
        accel->buffer->accels = accel->next;
    if (accel->next)
        accel->next->previous = accel->previous;
}

static void free_accel(void *record, void *context)
{
    struct accel_record *accel = record;
    (void)context;
    take_out_of_buffer(accel);
    buffer_record_release(accel->buffer);
    free(accel);
}

static void free_buffer(void *record, void *context)
{
    (void)context;
    buffer_record_release(record);
}

static void free_micromap(void *record, void *context)
{
    (void)context;
    free(record);
}

static void free_memory(void *record, void *context)
{
    (void)context;
    memory_record_release(record);
}

void resources_destroy(struct resources *resources)
{
    if (!resources)
        return;
    resources_release_nv(resources);
    handle_table_each(&resources->accels, free_accel, NULL);
    handle_table_each(&resources->micromaps, free_micromap, NULL);
    handle_table_each(&resources->buffers, free_buffer, NULL);
    handle_table_each(&resources->memories, free_memory, NULL);
    handle_table_release(&resources->accels);
    handle_table_release(&resources->micromaps);
    handle_table_release(&resources->buffers);
    handle_table_release(&resources->memories);
    address_map_release(&resources->addresses);
    reader_lock_destroy(&resources->lock);
    free(resources);
}

bool resources_publish(struct resources *resources, struct handle_table *table, uint64_t handle,
                       void *record)
{
    bool kept = record && handle_table_set(table, handle, record);
    if (!kept) {
        resources->incomplete = true;
        free(record);
    }
    return kept;
}

void resources_note_death(struct resources *resources)
{
    atomic_fetch_add_explicit(&resources->deaths, 1, memory_order_relaxed);
}

/* Memory. */

static void remove_memory(struct resources *resources, VkDeviceMemory handle)
{
    struct memory_record *memory =
        handle_table_remove(&resources->memories, (uint64_t)(uintptr_t)handle);
    if (!memory)
        return;
    resources_note_death(resources);
    memory->alive = false;
    for (struct buffer_record *buffer = memory->buffers; buffer; buffer = buffer->next)
        resources_refresh(buffer);
    memory_record_release(memory);
}

void resources_add_memory(struct resources *resources, VkDeviceMemory handle, VkDeviceSize size,
                          VkMemoryPropertyFlags properties, bool multi_instance)
{
    struct memory_record *memory = malloc(sizeof(*memory));
    if (memory)
        *memory = (struct memory_record){.references = 1,
                                         .alive = true,
                                         .handle = handle,
                                         .size = size,
                                         .properties = properties,
                                         .multi_instance = multi_instance};
    reader_lock_write(&resources->lock);
    remove_memory(resources, handle);
    resources_publish(resources, &resources->memories, (uint64_t)(uintptr_t)handle, memory);
    reader_lock_write_done(&resources->lock);
}

void resources_remove_memory(struct resources *resources, VkDeviceMemory handle)
{
    reader_lock_write(&resources->lock);
    remove_memory(resources, handle);
    reader_lock_write_done(&resources->lock);
}

/* Buffers. */

static void remove_buffer(struct resources *resources, VkBuffer handle)
{
    struct buffer_record *buffer =
        handle_table_remove(&resources->buffers, (uint64_t)(uintptr_t)handle);
    if (!buffer)
        return;
    if (buffer->where.address)
        address_map_remove(&resources->addresses, buffer->where.address, buffer);
    resources_note_death(resources);
    buffer->alive = false;
    resources_refresh(buffer);
    buffer_record_release(buffer);
}

static VkBufferUsageFlags2 usage_of(const VkBufferCreateInfo *create_info)
{
    const VkBufferUsageFlags2CreateInfo *flags2 =
        chain_find(create_info->pNext, VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO);
    return flags2 ? flags2->usage : create_info->usage;
}

/* Whether the application asked for an address that it knows from elsewhere, and need not retrieve.
 */
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
        buffer->where.handle = handle;
        buffer->where.size = create_info->size;
        buffer->where.usage = usage_of(create_info);
        buffer->flags = create_info->flags;
        buffer->bound = NO;
        resources_refresh(buffer);
    }
    reader_lock_write(&resources->lock);
    remove_buffer(resources, handle);
    if (replays_address(create_info))
        resources->replays_addresses = true;
    if (buffer)
        buffer->where.id = ++resources->last_id;
    resources_publish(resources, &resources->buffers, (uint64_t)(uintptr_t)handle, buffer);
    reader_lock_write_done(&resources->lock);
}

void resources_remove_buffer(struct resources *resources, VkBuffer handle)
{
    reader_lock_write(&resources->lock);
    remove_buffer(resources, handle);
    reader_lock_write_done(&resources->lock);
}

static struct buffer_record *find_buffer(const struct resources *resources, VkBuffer handle)
{
    return handle_table_find(&resources->buffers, (uint64_t)(uintptr_t)handle);
}

static struct memory_record *find_memory(const struct resources *resources, VkDeviceMemory handle)
{
    return handle_table_find(&resources->memories, (uint64_t)(uintptr_t)handle);
}

/* Applications ask for the same address often, so look before taking the write lock. */
void resources_set_address(struct resources *resources, VkBuffer handle, VkDeviceAddress address)
{
    unsigned token = resources_begin_reading(resources);
    const struct buffer_record *known = find_buffer(resources, handle);
    bool is_news = known && known->where.address != address;
    resources_end_reading(resources, token);
    if (!is_news)
        return;

    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = find_buffer(resources, handle);
    if (buffer && buffer->where.address != address) {
        if (buffer->where.address)
            address_map_remove(&resources->addresses, buffer->where.address, buffer);
        buffer->where.address = address;
        if (address &&
            !address_map_add(&resources->addresses, address, buffer->where.size, buffer)) {
            buffer->where.address = 0;
            resources->incomplete = true;
        }
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
    struct buffer_record *buffer = find_buffer(resources, handle);
    if (buffer) {
        unbind(buffer);
        buffer->memory = find_memory(resources, memory);
        buffer->memory_offset = offset;
        buffer->instances_differ = instances_differ;
        buffer->bound = buffer->memory ? YES : UNKNOWN;
        if (buffer->memory)
            bind_to_memory(buffer);
        resources_refresh(buffer);
    }
    reader_lock_write_done(&resources->lock);
}

void resources_forget_binding(struct resources *resources, VkBuffer handle)
{
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = find_buffer(resources, handle);
    if (buffer) {
        unbind(buffer);
        buffer->bound = UNKNOWN;
        resources_refresh(buffer);
    }
    reader_lock_write_done(&resources->lock);
}

void resources_bind_sparse(struct resources *resources, VkBuffer handle,
                           const VkSparseMemoryBind *bind)
{
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = find_buffer(resources, handle);
    if (buffer)
        buffer_record_bind_sparse(buffer, bind, find_memory(resources, bind->memory));
    reader_lock_write_done(&resources->lock);
}

void resources_forget_sparse(struct resources *resources, VkBuffer handle)
{
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = find_buffer(resources, handle);
    if (buffer)
        buffer->sparse_incomplete = true;
    reader_lock_write_done(&resources->lock);
}

/* Acceleration structures. */

/* Returns the id of what was removed, or 0. */
static uint64_t remove_accel(struct resources *resources, VkAccelerationStructureKHR handle)
{
    struct accel_record *accel =
        handle_table_remove(&resources->accels, (uint64_t)(uintptr_t)handle);
    if (!accel)
        return 0;
    uint64_t id = accel->id;
    resources_note_death(resources);
    free_accel(accel, NULL);
    return id;
}

static void put_into_buffer(struct accel_record *accel, struct buffer_record *buffer)
{
    buffer->references++;
    accel->buffer = buffer;
    accel->next = buffer->accels;
    if (accel->next)
        accel->next->previous = accel;
    buffer->accels = accel;
    resources_refresh_accel(accel);
}

static void add_accel(struct resources *resources, struct accel_record *accel,
                      VkAccelerationStructureKHR handle, struct buffer_record *buffer)
{
    remove_accel(resources, handle);
    if (accel)
        accel->id = ++resources->last_id;
    if (resources_publish(resources, &resources->accels, (uint64_t)(uintptr_t)handle, accel) &&
        buffer)
        put_into_buffer(accel, buffer);
}

void resources_add_accel(struct resources *resources, VkAccelerationStructureKHR handle,
                         const VkAccelerationStructureCreateInfoKHR *create_info)
{
    struct accel_record *accel = malloc(sizeof(*accel));
    if (accel)
        *accel = (struct accel_record){.offset = create_info->offset,
                                       .size = create_info->size,
                                       .type = create_info->type,
                                       .flags = create_info->createFlags};
    reader_lock_write(&resources->lock);
    add_accel(resources, accel, handle, find_buffer(resources, create_info->buffer));
    reader_lock_write_done(&resources->lock);
}

struct buffer_search {
    VkDeviceAddress begin;
    VkDeviceSize size;
    struct buffer_record *found;
    uint32_t matches;
};

static void note_containing_buffer(void *record, void *context)
{
    struct buffer_record *buffer = record;
    struct buffer_search *search = context;
    if (buffer->where.size - (search->begin - buffer->where.address) < search->size)
        return;
    search->found = buffer;
    search->matches++;
}

/* Several buffers may hold the range; which one is meant doesn't matter for where the bytes lie,
 * but it does for what happens when one of them dies, so then the buffer counts as unknown. */
void resources_add_accel_at(struct resources *resources, VkAccelerationStructureKHR handle,
                            const VkAccelerationStructureCreateInfo2KHR *create_info)
{
    struct accel_record *accel = malloc(sizeof(*accel));
    if (accel)
        *accel = (struct accel_record){.size = create_info->addressRange.size,
                                       .type = create_info->type,
                                       .flags = create_info->createFlags};
    reader_lock_write(&resources->lock);
    struct buffer_search search = {.begin = create_info->addressRange.address,
                                   .size = create_info->addressRange.size};
    address_map_find(&resources->addresses, search.begin, note_containing_buffer, &search);
    struct buffer_record *buffer = search.matches == 1 ? search.found : NULL;
    if (accel && buffer)
        accel->offset = search.begin - buffer->where.address;
    add_accel(resources, accel, handle, buffer);
    reader_lock_write_done(&resources->lock);
}

uint64_t resources_remove_accel(struct resources *resources, VkAccelerationStructureKHR handle)
{
    reader_lock_write(&resources->lock);
    uint64_t id = remove_accel(resources, handle);
    reader_lock_write_done(&resources->lock);
    return id;
}
