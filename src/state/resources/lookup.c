/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups: facts about structures, buffers and addresses. */
#include <string.h>

#include "src/base/recording_path.h"
#include "src/state/resources/records.h"

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
    switch (buffer->backed) {
    case YES:
        return ADDRESS_IN_BUFFER;
    case NO:
        return ADDRESS_UNBOUND;
    case UNKNOWN:
        break;
    }
    return ADDRESS_UNKNOWN;
}

/* Returns UNKNOWN if available is no record, else `value` as YES or NO. */
static enum tristate tristate_of(const void *record, bool value)
{
    return !record ? UNKNOWN : value ? YES : NO;
}

void resources_refresh_accel(struct accel_record *accel)
{
    const struct buffer_record *buffer = accel->buffer;
    struct accel_facts *facts = &accel->facts;
    facts->buffer = buffer->where.buffer;
    facts->buffer_id = buffer->where.buffer_id;
    facts->memory = buffer->where.memory;
    facts->begin = buffer->where.begin + accel->offset;
    facts->is_external = buffer->is_external;
    facts->buffer_is_destroyed = !buffer->alive;
    facts->is_sparse = buffer->where.is_sparse && buffer->alive;
    /* Whether a sparse buffer is backed depends on the execution point: see
     * resources_sparse_backing(). */
    facts->backed = facts->is_sparse ? UNKNOWN : buffer->backed;
    const struct memory_record *memory = facts->backed == YES ? buffer->memory : NULL;
    facts->host_visible =
        tristate_of(memory, memory && memory->properties & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT);
    facts->multi_instance = tristate_of(memory, memory && memory->multi_instance);
}

void resources_refresh(struct resources *resources, struct buffer_record *buffer)
{
    buffer->where.is_sparse = buffer->flags & VK_BUFFER_CREATE_SPARSE_BINDING_BIT;
    buffer->backed = backing(buffer);
    buffer->where.status = status_of(buffer);
    bool has_range = buffer->backed == YES && !buffer->where.is_sparse && !buffer->instances_differ;
    buffer->where.memory = has_range ? buffer->memory->handle : VK_NULL_HANDLE;
    buffer->where.begin = has_range ? buffer->memory_offset : 0;
    if (buffer->where.address)
        address_map_update(&resources->addresses, &buffer->where);
    for (struct accel_record *accel = buffer->accels; accel; accel = accel->next) {
        resources_refresh_accel(accel);
        resources_note_reference(resources, accel->address, false);
    }
}

static void describe_accel(const struct resources *resources, VkAccelerationStructureKHR handle,
                           const struct accel_record *accel, struct accel_facts *facts)
{
    if (__builtin_expect(accel != NULL, true)) {
        memcpy(facts, &accel->facts, offsetof(struct accel_facts, handle));
        facts->handle = handle;
    } else {
        *facts = (struct accel_facts){.handle = handle};
        if (handle)
            facts->alive = unknown_is_set(&resources->unknown) ? UNKNOWN : NO;
    }
}

void resources_find_accel(const struct resources *resources, VkAccelerationStructureKHR handle,
                          struct accel_facts *facts)
{
    describe_accel(resources, handle, handle_table_find(&resources->accels, handle_number(handle)),
                   facts);
}

void resources_find_buffer(const struct resources *resources, VkBuffer handle,
                           struct buffer_facts *facts)
{
    const struct buffer_record *buffer =
        handle_table_find(&resources->buffers, handle_number(handle));
    *facts = (struct buffer_facts){.handle = handle};
    if (!handle)
        return;
    if (!buffer) {
        facts->alive = unknown_is_set(&resources->unknown) ? UNKNOWN : NO;
        return;
    }
    facts->alive = YES;
    facts->id = buffer->where.buffer_id;
    facts->size = buffer->where.bytes_left;
    facts->usage = buffer->where.usage;
    facts->flags = buffer->flags;
    facts->status = buffer->where.status;
}

uint64_t resources_destroy_count(struct resources *resources)
{
    return atomic_load_explicit(&resources->destroy_count, memory_order_relaxed);
}

static uint64_t find_id(const struct resources *resources, enum resource_kind kind, uint64_t handle)
{
    switch (kind) {
    case RESOURCE_ACCEL: {
        const struct accel_record *accel = handle_table_find(&resources->accels, handle);
        return accel ? accel->facts.id : 0;
    }
    case RESOURCE_ACCEL_NV: {
        const struct nv_accel_record *accel = handle_table_find(&resources->nv_accels, handle);
        return accel ? accel->id : 0;
    }
    case RESOURCE_BUFFER: {
        const struct buffer_record *buffer = handle_table_find(&resources->buffers, handle);
        return buffer ? buffer->where.buffer_id : 0;
    }
    case RESOURCE_MICROMAP: {
        const struct micromap_record *micromap = handle_table_find(&resources->micromaps, handle);
        return micromap ? micromap->id : 0;
    }
    case RESOURCE_MEMORY: {
        const struct memory_record *memory = handle_table_find(&resources->memories, handle);
        return memory ? memory->id : 0;
    }
    case RESOURCE_QUERY_POOL:
        break;
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

enum tristate resources_has(struct resources *resources, enum resource_kind kind, uint64_t handle)
{
    unsigned token = resources_begin_reading(resources);
    bool found = find_id(resources, kind, handle) != 0,
         is_unknown = unknown_is_set(&resources->unknown);
    resources_end_reading(resources, token);
    return found ? YES : is_unknown ? UNKNOWN : NO;
}

/* Returns NULL if there is no such structure or micromap. */
static bool *find_callbacks(const struct resources *resources, enum resource_kind kind,
                            uint64_t handle)
{
    if (kind == RESOURCE_ACCEL) {
        struct accel_record *accel = handle_table_find(&resources->accels, handle);
        return accel ? &accel->has_callbacks : NULL;
    }
    if (kind == RESOURCE_ACCEL_NV) {
        struct nv_accel_record *accel = handle_table_find(&resources->nv_accels, handle);
        return accel ? &accel->has_callbacks : NULL;
    }
    struct micromap_record *micromap = handle_table_find(&resources->micromaps, handle);
    return micromap ? &micromap->has_callbacks : NULL;
}

void resources_note_callbacks(struct resources *resources, enum resource_kind kind, uint64_t handle)
{
    reader_lock_write(&resources->lock);
    bool *has_callbacks = find_callbacks(resources, kind, handle);
    if (has_callbacks)
        *has_callbacks = true;
    reader_lock_write_done(&resources->lock);
}

enum tristate resources_has_callbacks(struct resources *resources, enum resource_kind kind,
                                      uint64_t handle)
{
    unsigned token = resources_begin_reading(resources);
    const bool *has_callbacks = find_callbacks(resources, kind, handle);
    enum tristate found = !has_callbacks ? UNKNOWN : *has_callbacks ? YES : NO;
    resources_end_reading(resources, token);
    return found;
}

/* If buffers share an address, a bound buffer outweighs an unbound one. A buffer whose binding is
 * unknown outweighs both, because its usage and size may make the address valid. */
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

/* Derives the facts about an address from the range that contains it. */
static inline void read_range(const struct address_facts *range, VkDeviceAddress address,
                              struct address_facts *facts)
{
    VkDeviceSize offset = address - range->address;
    *facts = *range;
    facts->address = address;
    facts->bytes_left -= offset;
    facts->begin += offset;
}

static void add_range(const struct address_facts *range, void *context)
{
    struct address_facts *facts = context;
    int heavier = weight(range->status) - weight(facts->status);
    if (heavier < 0)
        return;
    VkBufferUsageFlags2 usage = range->usage | (heavier > 0 ? 0 : facts->usage);
    bool is_protected = range->is_protected || facts->is_protected;
    if (heavier > 0 || range->bytes_left - (facts->address - range->address) > facts->bytes_left)
        read_range(range, facts->address, facts);
    facts->usage = usage;
    facts->is_protected = is_protected;
}

__attribute__((noinline, cold)) static void search_address(const struct resources *resources,
                                                           VkDeviceAddress address,
                                                           struct address_facts *facts)
{
    *facts = (struct address_facts){.address = address, .status = ADDRESS_NULL};
    if (!address)
        return;
    facts->status = unknown_is_set(&resources->unknown) ? ADDRESS_UNKNOWN : ADDRESS_NOWHERE;
    if (!unknown_is_set(&resources->unknown))
        address_map_find(&resources->addresses, address, add_range, facts);
    if (facts->status == ADDRESS_NOWHERE && resources->replays_addresses)
        facts->status = ADDRESS_UNKNOWN;
}

/* If the state is incomplete, nothing is certain about any address. */
static struct address_guesses guesses_of(const struct resources *resources)
{
    return address_map_guesses(unknown_is_set(&resources->unknown) ? NULL : &resources->addresses);
}

static inline void describe_address(const struct resources *resources, VkDeviceAddress address,
                                    const struct address_facts *guess, struct address_facts *facts)
{
    if (buffer_range_contains(guess, address) && !guess->is_shared)
        read_range(guess, address, facts);
    else
        search_address(resources, address, facts);
}

void resources_find_address(const struct resources *resources, VkDeviceAddress address,
                            struct address_facts *facts)
{
    const struct address_guesses guesses = guesses_of(resources);
    describe_address(resources, address, address_guesses_find(&guesses, address), facts);
}

/* Records and guesses found for a batch of queries. */
struct found {
    const struct accel_record *accels[RESOURCE_ACCEL_QUERIES];
    const struct address_facts *ranges[RESOURCE_ADDRESS_QUERIES]; /* first guesses */
};

/* Finds the records and guesses and prefetches all of them. */
static inline void locate_all(const struct resources *resources,
                              const struct address_guesses *guesses,
                              const struct resource_queries *queries, struct found *found)
{
    for (unsigned i = 0; i < queries->accel_count; i++) {
        found->accels[i] =
            handle_table_find(&resources->accels, handle_number(queries->accels[i].handle));
        __builtin_prefetch(found->accels[i]);
    }
    for (unsigned i = 0; i < queries->address_count; i++) {
        found->ranges[i] = address_guesses_first(guesses, queries->addresses[i].address);
        __builtin_prefetch(found->ranges[i]);
    }
}

ON_RECORDING_PATH void resources_find_all(struct resources *resources,
                                          const struct resource_queries *queries)
{
    struct found found;
    unsigned token = resources_begin_reading(resources);
    const struct address_guesses guesses = guesses_of(resources);
    locate_all(resources, &guesses, queries, &found);
    for (unsigned i = 0; i < queries->address_count; i++)
        describe_address(
            resources, queries->addresses[i].address,
            address_guesses_find_from(&guesses, found.ranges[i], queries->addresses[i].address),
            queries->addresses[i].facts);
    for (unsigned i = 0; i < queries->accel_count; i++)
        describe_accel(resources, queries->accels[i].handle, found.accels[i],
                       queries->accels[i].facts);
    resources_end_reading(resources, token);
}

void resources_look_up_accel(struct resources *resources, VkAccelerationStructureKHR handle,
                             struct accel_facts *facts)
{
    unsigned token = resources_begin_reading(resources);
    resources_find_accel(resources, handle, facts);
    resources_end_reading(resources, token);
}

void resources_look_up_address(struct resources *resources, VkDeviceAddress address,
                               struct address_facts *facts)
{
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, facts);
    resources_end_reading(resources, token);
}

void resources_look_up_buffer(struct resources *resources, VkBuffer handle,
                              struct buffer_facts *facts)
{
    unsigned token = resources_begin_reading(resources);
    resources_find_buffer(resources, handle, facts);
    resources_end_reading(resources, token);
}

void resources_look_up_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                                struct nv_accel_facts *facts)
{
    unsigned token = resources_begin_reading(resources);
    resources_find_nv_accel(resources, handle, facts);
    resources_end_reading(resources, token);
}

/* ---- all addresses */

struct range_union {
    void (*visit)(void *user, uint64_t begin, uint64_t end);
    void *user;
    uint64_t begin, end; /* the ranges joined so far; empty if equal */
};

static void end_range(const struct range_union *joined)
{
    if (joined->end > joined->begin)
        joined->visit(joined->user, joined->begin, joined->end);
}

static void join_range(const struct address_facts *range, void *context)
{
    struct range_union *joined = context;
    uint64_t begin = range->address, end = begin + range->bytes_left;
    if (range->status != ADDRESS_IN_BUFFER || range->is_sparse || range->is_protected)
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

static void find_unknown_range(const struct address_facts *range, void *context)
{
    bool *is_unknown = context;
    *is_unknown |= range->status == ADDRESS_UNKNOWN || range->is_sparse || range->is_protected;
}

bool resources_has_unknown_ranges(struct resources *resources)
{
    unsigned token = resources_begin_reading(resources);
    bool is_unknown = unknown_is_set(&resources->unknown) || resources->replays_addresses;
    address_map_each(&resources->addresses, find_unknown_range, &is_unknown);
    resources_end_reading(resources, token);
    return is_unknown;
}

/* ---- what a command can read */

uint64_t resources_find_readable(struct resources *resources, VkDeviceAddress address,
                                 uint64_t size, const struct execution_clock *clock)
{
    struct address_facts facts;
    struct sparse_bytes missing;
    resources_look_up_address(resources, address, &facts);
    if (facts.status != ADDRESS_IN_BUFFER || facts.is_protected)
        return 0;
    uint64_t available = size < facts.bytes_left ? size : facts.bytes_left;
    const struct sparse_bytes bytes = {facts.buffer, facts.buffer_id, facts.begin,
                                       facts.begin + available};
    if (facts.is_sparse && resources_sparse_backing(resources, &bytes, clock, &missing) != YES)
        return 0;
    return available;
}
