/* SPDX-License-Identifier: Apache-2.0 */
/* The records of acceleration structures: creation and destruction. */
#include <stdlib.h>

#include "src/platform/aligned.h"
#include "src/state/resources/records.h"

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

void accel_record_free(struct accel_record *accel)
{
    take_out_of_buffer(accel);
    buffer_record_release(accel->buffer);
    aligned_free(accel);
}

/* Returns the id of the removed record, or 0. */
static uint64_t remove_accel(struct resources *resources, VkAccelerationStructureKHR handle)
{
    struct accel_record *accel =
        handle_table_remove(&resources->accels, (uint64_t)(uintptr_t)handle);
    if (!accel)
        return 0;
    uint64_t id = accel->facts.id;
    resources_count_destroyed(resources);
    accel_record_forget_address(resources, accel);
    accel_record_free(accel);
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

/* Makes a record without a buffer. Returns NULL if there is no memory. */
static struct accel_record *make_accel(VkAccelerationStructureKHR handle, VkDeviceSize size,
                                       VkAccelerationStructureTypeKHR type,
                                       VkAccelerationStructureCreateFlagsKHR flags)
{
    struct accel_record *accel = aligned_allocate(CACHE_LINE, sizeof(*accel));
    if (accel)
        *accel = (struct accel_record){.facts = {.handle = handle,
                                                 .alive = YES,
                                                 .details_known = true,
                                                 .size = size,
                                                 .type = type,
                                                 .create_flags = flags}};
    return accel;
}

static void add_accel(struct resources *resources, struct accel_record *accel,
                      VkAccelerationStructureKHR handle, struct buffer_record *buffer)
{
    remove_accel(resources, handle);
    if (accel)
        accel->facts.id = ++resources->last_id;
    bool published =
        resources_publish(resources, &resources->accels, (uint64_t)(uintptr_t)handle, accel);
    if (!published)
        aligned_free(accel);
    else if (buffer)
        put_into_buffer(accel, buffer);
}

void resources_add_accel(struct resources *resources, VkAccelerationStructureKHR handle,
                         const VkAccelerationStructureCreateInfoKHR *create_info)
{
    struct accel_record *accel =
        make_accel(handle, create_info->size, create_info->type, create_info->createFlags);
    if (accel)
        accel->offset = create_info->offset;
    reader_lock_write(&resources->lock);
    add_accel(resources, accel, handle, resources_buffer(resources, create_info->buffer));
    reader_lock_write_done(&resources->lock);
}

struct buffer_search {
    VkDeviceAddress begin;
    VkDeviceSize size;
    VkBuffer found;
    uint32_t matches;
};

static void note_containing_buffer(const struct address_facts *place, void *context)
{
    struct buffer_search *search = context;
    if (place->bytes_left - (search->begin - place->address) < search->size)
        return;
    search->found = place->buffer;
    search->matches++;
}

/* Several buffers may contain the range. Their bytes are the same, but the buffer whose destruction
 * ends the structure is ambiguous, so the buffer then counts as unknown. */
void resources_add_accel_at(struct resources *resources, VkAccelerationStructureKHR handle,
                            const VkAccelerationStructureCreateInfo2KHR *create_info)
{
    struct accel_record *accel = make_accel(handle, create_info->addressRange.size,
                                            create_info->type, create_info->createFlags);
    if (accel)
        accel->facts.by_address = true;
    reader_lock_write(&resources->lock);
    struct buffer_search search = {.begin = create_info->addressRange.address,
                                   .size = create_info->addressRange.size};
    address_map_find(&resources->addresses, search.begin, note_containing_buffer, &search);
    struct buffer_record *buffer =
        search.matches == 1 ? resources_buffer(resources, search.found) : NULL;
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
