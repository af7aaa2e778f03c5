/* SPDX-License-Identifier: Apache-2.0 */
/* The records of acceleration structures and of micromaps: creation and destruction. */
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
    struct accel_record *accel = handle_table_remove(&resources->accels, handle_number(handle));
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
                                                 .create_flags = flags,
                                                 .is_external = true}};
    return accel;
}

static void add_accel(struct resources *resources, struct accel_record *accel,
                      VkAccelerationStructureKHR handle, struct buffer_record *buffer)
{
    remove_accel(resources, handle);
    if (accel)
        accel->facts.id = ++resources->last_id;
    bool published = resources_publish(resources, &resources->accels, handle_number(handle), accel);
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

/* Several buffers may contain the range, and one of them may be unknown for lack of memory. Their
 * bytes are the same, but the buffer whose destruction ends the structure is ambiguous, so the
 * buffer then counts as unknown. */
void resources_add_accel_at(struct resources *resources, VkAccelerationStructureKHR handle,
                            const VkAccelerationStructureCreateInfo2KHR *create_info)
{
    struct accel_record *accel = make_accel(handle, create_info->addressRange.size,
                                            create_info->type, create_info->createFlags);
    if (accel) {
        accel->facts.by_address = true;
        accel->facts.fully_bound =
            create_info->addressFlags & VK_ADDRESS_COMMAND_FULLY_BOUND_BIT_KHR;
    }
    reader_lock_write(&resources->lock);
    struct buffer_search search = {.begin = create_info->addressRange.address,
                                   .size = create_info->addressRange.size};
    address_map_find(&resources->addresses, search.begin, note_containing_buffer, &search);
    const bool is_certain = search.matches == 1 && !unknown_is_set(&resources->unknown);
    struct buffer_record *buffer = is_certain ? resources_buffer(resources, search.found) : NULL;
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

uint64_t resources_last_id(struct resources *resources)
{
    unsigned token = resources_begin_reading(resources);
    const uint64_t id = resources->last_id;
    resources_end_reading(resources, token);
    return id;
}

struct accel_listing {
    struct accel_facts *items;
    uint32_t count;
};

static void list_accel(void *record, void *context)
{
    const struct accel_record *accel = record;
    struct accel_listing *listing = context;
    listing->items[listing->count++] = accel->facts;
}

struct accel_facts *resources_list_accels(struct resources *resources, uint32_t *count)
{
    unsigned token = resources_begin_reading(resources);
    const size_t size = resources->accels.count * sizeof(struct accel_facts);
    struct accel_listing listing = {.items = size ? malloc(size) : NULL};
    if (listing.items)
        handle_table_each(&resources->accels, list_accel, &listing);
    resources_end_reading(resources, token);
    *count = listing.count;
    return listing.items;
}

static bool overlaps(VkDeviceSize a, VkDeviceSize size_a, VkDeviceSize b, VkDeviceSize size_b)
{
    return a < b + size_b && b < a + size_a;
}

static bool is_alone_in_buffer(const struct accel_record *accel)
{
    for (const struct accel_record *other = accel->buffer->accels; other; other = other->next)
        if (other != accel &&
            overlaps(accel->offset, accel->facts.size, other->offset, other->facts.size))
            return false;
    return true;
}

/* Other buffers that alias its memory may hold anything. */
static bool is_alone_in_memory(const struct accel_record *accel)
{
    const struct buffer_record *buffer = accel->buffer->memory->buffers;
    for (; buffer; buffer = buffer->next)
        if (buffer != accel->buffer && overlaps(accel->facts.begin, accel->facts.size,
                                                buffer->memory_offset, buffer->where.bytes_left))
            return false;
    return true;
}

bool resources_accel_is_alone(struct resources *resources, VkAccelerationStructureKHR handle)
{
    unsigned token = resources_begin_reading(resources);
    const struct accel_record *accel = handle_table_find(&resources->accels, handle_number(handle));
    const bool is_alone = accel && accel->buffer && !accel->facts.is_external &&
                          !accel->facts.is_sparse && accel->buffer->bound == YES &&
                          accel->buffer->memory && is_alone_in_buffer(accel) &&
                          is_alone_in_memory(accel);
    resources_end_reading(resources, token);
    return is_alone;
}

/* ---- the records of micromaps of VK_EXT_opacity_micromap */

/* Returns the id of the removed record, or 0. */
static uint64_t remove_micromap(struct resources *resources, VkMicromapEXT handle)
{
    struct micromap_record *micromap =
        handle_table_remove(&resources->micromaps, handle_number(handle));
    if (!micromap)
        return 0;
    uint64_t id = micromap->id;
    resources_count_destroyed(resources);
    free(micromap);
    return id;
}

void resources_add_micromap(struct resources *resources, VkMicromapEXT handle,
                            const VkMicromapCreateInfoEXT *create_info)
{
    struct micromap_record *micromap = malloc(sizeof(*micromap));
    reader_lock_write(&resources->lock);
    remove_micromap(resources, handle);
    const struct buffer_record *buffer = resources_buffer(resources, create_info->buffer);
    if (micromap)
        *micromap = (struct micromap_record){.id = ++resources->last_id,
                                             .type = create_info->type,
                                             .create_flags = create_info->createFlags,
                                             .buffer = create_info->buffer,
                                             .buffer_id = buffer ? buffer->where.buffer_id : 0,
                                             .offset = create_info->offset,
                                             .size = create_info->size};
    if (!resources_publish(resources, &resources->micromaps, handle_number(handle), micromap))
        free(micromap);
    reader_lock_write_done(&resources->lock);
}

uint64_t resources_remove_micromap(struct resources *resources, VkMicromapEXT handle)
{
    reader_lock_write(&resources->lock);
    uint64_t id = remove_micromap(resources, handle);
    reader_lock_write_done(&resources->lock);
    return id;
}

static enum tristate tristate_of(bool is_known, bool value)
{
    return !is_known ? UNKNOWN : value ? YES : NO;
}

/* As resources_refresh_accel(). The record of a destroyed buffer is gone. */
static void find_memory(const struct resources *resources, const struct micromap_record *micromap,
                        struct micromap_facts *facts)
{
    const struct buffer_record *buffer = resources_buffer(resources, micromap->buffer);
    if (!buffer || buffer->where.buffer_id != micromap->buffer_id) {
        facts->backed =
            tristate_of(micromap->buffer_id && !unknown_is_set(&resources->unknown), false);
        facts->buffer_is_destroyed = facts->backed == NO;
        return;
    }
    facts->is_sparse = buffer->where.is_sparse;
    facts->backed = facts->is_sparse ? UNKNOWN : buffer->backed;
    const struct memory_record *memory = facts->backed == YES ? buffer->memory : NULL;
    facts->host_visible =
        tristate_of(memory, memory && memory->properties & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT);
    facts->multi_instance = tristate_of(memory, memory && memory->multi_instance);
    facts->span = memory_span_of(buffer->where.memory, buffer->where.begin + micromap->offset,
                                 micromap->size);
}

void resources_find_micromap(struct resources *resources, VkMicromapEXT handle,
                             struct micromap_facts *facts)
{
    *facts = (struct micromap_facts){.handle = handle};
    if (!handle)
        return;
    unsigned token = resources_begin_reading(resources);
    const struct micromap_record *micromap =
        handle_table_find(&resources->micromaps, handle_number(handle));
    if (micromap) {
        facts->alive = YES;
        facts->id = micromap->id;
        facts->type = micromap->type;
        facts->create_flags = micromap->create_flags;
        facts->size = micromap->size;
        facts->buffer = micromap->buffer;
        facts->buffer_id = micromap->buffer_id;
        find_memory(resources, micromap, facts);
    } else {
        facts->alive = unknown_is_set(&resources->unknown) ? UNKNOWN : NO;
    }
    resources_end_reading(resources, token);
}
