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

static enum tristate backing(const struct buffer_record *buffer)
{
    if (!buffer->alive)
        return NO;
    if (buffer->bound != YES)
        return buffer->bound;
    return buffer->memory->alive ? YES : NO;
}

static enum address_status status_of(const struct buffer_record *buffer)
{
    if (buffer->where.is_sparse)
        return ADDRESS_IN_BUFFER;
    switch ((enum tristate)buffer->where.backed) {
    case YES:
        return ADDRESS_IN_BUFFER;
    case NO:
        return ADDRESS_UNBOUND;
    case UNKNOWN:
        break;
    }
    return ADDRESS_UNKNOWN;
}

/* enum tristate of what is asked of something, if that is known. */
static unsigned char is_true(const void *something, bool answer)
{
    return (unsigned char)(!something ? UNKNOWN : answer ? YES : NO);
}

void resources_refresh_accel(struct accel_record *accel)
{
    const struct buffer_record *buffer = accel->buffer;
    bool is_sparse = buffer->where.is_sparse && buffer->alive;
    accel->buffer_handle = buffer->where.handle;
    accel->memory = buffer->where.memory;
    accel->memory_begin = buffer->where.memory_offset + accel->offset;
    accel->in_pieces = is_sparse;
    /* Of a sparse one it depends on who asks: see resources_sparse_backing. */
    accel->backed = (unsigned char)(is_sparse ? UNKNOWN : buffer->where.backed);
    const struct memory_record *memory = accel->backed == YES ? buffer->memory : NULL;
    accel->host_visible =
        is_true(memory, memory && memory->properties & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT);
    accel->multi_instance = is_true(memory, memory && memory->multi_instance);
}

void resources_refresh(struct resources *resources, struct buffer_record *buffer)
{
    buffer->where.is_sparse = buffer->flags & VK_BUFFER_CREATE_SPARSE_BINDING_BIT;
    buffer->where.backed = (unsigned char)backing(buffer);
    buffer->where.status = (unsigned char)status_of(buffer);
    bool has_place =
        buffer->where.backed == YES && !buffer->where.is_sparse && !buffer->instances_differ;
    buffer->where.memory = has_place ? buffer->memory->handle : VK_NULL_HANDLE;
    buffer->where.memory_offset = buffer->memory_offset;
    if (buffer->where.address)
        address_map_update(&resources->addresses, &buffer->where);
    for (struct accel_record *accel = buffer->accels; accel; accel = accel->next)
        resources_refresh_accel(accel);
}

static struct memory_span span_from(VkDeviceMemory memory, VkDeviceSize begin, VkDeviceSize size)
{
    return memory ? (struct memory_span){memory, begin, begin + size} : (struct memory_span){0};
}

static void describe_accel(const struct resources *resources, VkAccelerationStructureKHR handle,
                           const struct accel_record *accel, struct accel_facts *facts)
{
    *facts = (struct accel_facts){.handle = handle};
    if (!handle)
        return;
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
    facts->buffer = accel->buffer_handle;
    facts->span = span_from(accel->memory, accel->memory_begin, accel->size);
    facts->backed = (enum tristate)accel->backed;
    facts->in_pieces = accel->in_pieces;
    facts->host_visible = (enum tristate)accel->host_visible;
    facts->multi_instance = (enum tristate)accel->multi_instance;
    facts->by_address = accel->by_address;
    if (accel->in_pieces)
        facts->buffer_id = accel->buffer->where.id;
}

void resources_find_accel(const struct resources *resources, VkAccelerationStructureKHR handle,
                          struct accel_facts *facts)
{
    describe_accel(resources, handle,
                   handle_table_find(&resources->accels, (uint64_t)(uintptr_t)handle), facts);
}

void resources_find_buffer(const struct resources *resources, VkBuffer handle,
                           struct buffer_facts *facts)
{
    const struct buffer_record *buffer =
        handle_table_find(&resources->buffers, (uint64_t)(uintptr_t)handle);
    *facts = (struct buffer_facts){.handle = handle};
    if (!handle)
        return;
    if (!buffer) {
        facts->alive = resources->incomplete ? UNKNOWN : NO;
        return;
    }
    facts->alive = YES;
    facts->id = buffer->where.id;
    facts->size = buffer->where.size;
    facts->usage = buffer->where.usage;
    facts->status = (enum address_status)buffer->where.status;
}

uint64_t resources_deaths(struct resources *resources)
{
    return atomic_load_explicit(&resources->deaths, memory_order_relaxed);
}

static uint64_t find_id(const struct resources *resources, enum resource_kind kind, uint64_t handle)
{
    switch (kind) {
    case RESOURCE_ACCEL: {
        const struct accel_record *accel = handle_table_find(&resources->accels, handle);
        return accel ? accel->id : 0;
    }
    case RESOURCE_ACCEL_NV: {
        const struct nv_accel_record *accel = handle_table_find(&resources->nv_accels, handle);
        return accel ? accel->id : 0;
    }
    case RESOURCE_BUFFER: {
        const struct buffer_record *buffer = handle_table_find(&resources->buffers, handle);
        return buffer ? buffer->where.id : 0;
    }
    case RESOURCE_MICROMAP: {
        const struct micromap_record *micromap = handle_table_find(&resources->micromaps, handle);
        return micromap ? micromap->id : 0;
    }
    }
    return 0;
}

uint64_t resources_find_id(struct resources *resources, enum resource_kind kind, uint64_t handle)
{
    unsigned token = resources_begin_reading(resources);
    uint64_t id = find_id(resources, kind, handle);
    resources_end_reading(resources, token);
    return id;
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

static void add_buffer_facts(const struct buffer_place *place, void *context)
{
    struct address_facts *facts = context;
    enum address_status status = (enum address_status)place->status;
    if (weight(status) < weight(facts->status))
        return;
    if (weight(status) > weight(facts->status)) {
        facts->status = status;
        facts->usage = 0;
        facts->bytes_left = 0;
    }
    facts->usage |= place->usage;
    VkDeviceSize offset = facts->address - place->address;
    VkDeviceSize left = place->size - offset;
    if (left <= facts->bytes_left)
        return;
    facts->buffer = place->handle;
    facts->buffer_id = place->id;
    facts->buffer_offset = offset;
    facts->bytes_left = left;
    facts->span = span_from(place->memory, place->memory_offset + offset, left);
    facts->in_pieces = place->is_sparse;
}

static void describe_address(const struct resources *resources, VkDeviceAddress address,
                             struct address_position position, struct address_facts *facts)
{
    *facts = (struct address_facts){.address = address, .status = ADDRESS_NULL};
    if (!address)
        return;
    facts->status = resources->incomplete ? ADDRESS_UNKNOWN : ADDRESS_NOWHERE;
    const struct buffer_place *only =
        resources->incomplete ? NULL : address_map_only(&resources->addresses, position, address);
    if (only)
        add_buffer_facts(only, facts);
    else if (!resources->incomplete)
        address_map_visit(&resources->addresses, position, address, add_buffer_facts, facts);
    if (facts->status == ADDRESS_NOWHERE && resources->replays_addresses)
        facts->status = ADDRESS_UNKNOWN;
}

void resources_find_address(const struct resources *resources, VkDeviceAddress address,
                            struct address_facts *facts)
{
    struct address_position position = address_map_find_chunk(&resources->addresses, address);
    address_map_find_entry(&resources->addresses, address, &position);
    describe_address(resources, address, position, facts);
}

static const struct accel_record *fetch_accel(const struct resources *resources,
                                              VkAccelerationStructureKHR handle)
{
    const struct accel_record *accel =
        handle_table_find(&resources->accels, (uint64_t)(uintptr_t)handle);
    if (accel) {
        __builtin_prefetch(accel);
        __builtin_prefetch(&accel->in_pieces);
    }
    return accel;
}

/* What queries have found before they are answered. */
struct found {
    const struct accel_record *accels[RESOURCE_ACCEL_QUERIES];
    struct address_position positions[RESOURCE_ADDRESS_QUERIES];
};

/* In steps, each of which needs what the one before has fetched. */
static void locate_all(const struct resources *resources, const struct resource_queries *queries,
                       struct found *found)
{
    const struct address_map *map = &resources->addresses;
    for (unsigned i = 0; i < queries->accel_count; i++)
        handle_table_prefetch(&resources->accels, (uint64_t)(uintptr_t)queries->accels[i].handle);
    for (unsigned i = 0; i < queries->address_count; i++)
        found->positions[i] = address_map_find_chunk(map, queries->addresses[i].address);
    for (unsigned i = 0; i < queries->accel_count; i++)
        found->accels[i] = fetch_accel(resources, queries->accels[i].handle);
    for (unsigned i = 0; i < queries->address_count; i++)
        address_map_find_entry(map, queries->addresses[i].address, &found->positions[i]);
}

void resources_find_all(struct resources *resources, const struct resource_queries *queries)
{
    struct found found;
    unsigned token = resources_begin_reading(resources);
    locate_all(resources, queries, &found);
    for (unsigned i = 0; i < queries->address_count; i++)
        describe_address(resources, queries->addresses[i].address, found.positions[i],
                         queries->addresses[i].facts);
    for (unsigned i = 0; i < queries->accel_count; i++)
        describe_accel(resources, queries->accels[i].handle, found.accels[i],
                       queries->accels[i].facts);
    resources_end_reading(resources, token);
}

void resources_ask_accel(struct resources *resources, VkAccelerationStructureKHR handle,
                         struct accel_facts *facts)
{
    unsigned token = resources_begin_reading(resources);
    resources_find_accel(resources, handle, facts);
    resources_end_reading(resources, token);
}

void resources_ask_address(struct resources *resources, VkDeviceAddress address,
                           struct address_facts *facts)
{
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, facts);
    resources_end_reading(resources, token);
}

/* ---- all addresses */

struct range_union {
    void (*visit)(void *user, uint64_t begin, uint64_t end);
    void *user;
    uint64_t begin, end; /* of what was joined so far; equal: nothing */
};

static void end_range(const struct range_union *joined)
{
    if (joined->end > joined->begin)
        joined->visit(joined->user, joined->begin, joined->end);
}

static void join_range(const struct buffer_place *place, void *context)
{
    struct range_union *joined = context;
    uint64_t begin = place->address, end = begin + place->size;
    if (place->status != ADDRESS_IN_BUFFER || place->is_sparse)
        return;
    if (begin > joined->end) {
        end_range(joined);
        joined->begin = begin;
    }
    if (end > joined->end)
        joined->end = end;
}

void resources_find_ranges(struct resources *resources,
                           void (*visit)(void *user, uint64_t begin, uint64_t end), void *user)
{
    struct range_union joined = {.visit = visit, .user = user};
    unsigned token = resources_begin_reading(resources);
    address_map_each(&resources->addresses, join_range, &joined);
    end_range(&joined);
    resources_end_reading(resources, token);
}
