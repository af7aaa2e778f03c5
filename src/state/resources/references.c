/* SPDX-License-Identifier: Apache-2.0 */
/* Device addresses of acceleration structures, by which instances refer to them; changes of these;
 * and what every change of the tables needs.
 *
 * The layer learns an address when the application queries it, or when it is needed to find the
 * structure that an instance refers to: a program may compute addresses. */
#include <stdlib.h>

#include "src/base/array.h"
#include "src/state/resources/records.h"
#include "src/state/resources/reference_changes.h"

void memory_record_release(struct memory_record *memory)
{
    if (memory && --memory->references == 0)
        free(memory);
}

bool resources_publish(struct resources *resources, struct handle_table *table, uint64_t handle,
                       void *record)
{
    bool published = record && handle_table_set(table, handle, record);
    if (!published)
        resources_become_unknown(resources);
    return published;
}

void resources_count_destroyed(struct resources *resources)
{
    atomic_fetch_add_explicit(&resources->destroy_count, 1, memory_order_relaxed);
}

void resources_become_unknown(struct resources *resources)
{
    unknown_set(&resources->unknown, UNKNOWN_OBJECTS);
}

/* ---- Device addresses of acceleration structures, by which instances refer to them.
 *
 * The layer learns an address when the application queries it, or when it is needed to find the
 * structure that an instance refers to: a program may compute addresses. */

/* The structures at one address: structures that alias memory may share it. */
struct accel_address {
    struct accel_record *first; /* first live structure; linked by same_address */
    uint64_t destroyed_at;      /* resources_destroy_count() when the last structure there was
                                 * destroyed */
};

struct past_reference past_references_add(struct past_references *past, uint64_t value,
                                          uint64_t destroyed_at)
{
    if (!past->items)
        past->items = calloc(PAST_REFERENCES, sizeof(*past->items));
    if (!past->items)
        return (struct past_reference){0};
    struct past_reference *item = &past->items[past->next++ % PAST_REFERENCES];
    const struct past_reference oldest = *item;
    *item = (struct past_reference){value, destroyed_at};
    return oldest;
}

static struct accel_address *find_or_add_address(struct resources *resources,
                                                 VkDeviceAddress address)
{
    struct accel_address *at = handle_table_find(&resources->accel_addresses, address);
    if (at)
        return at;
    at = malloc(sizeof(*at));
    if (at)
        *at = (struct accel_address){.destroyed_at = resources->past_addresses.forgotten_at};
    if (!at || !handle_table_set(&resources->accel_addresses, address, at)) {
        free(at);
        return NULL;
    }
    return at;
}

static void set_unknown(struct resources *resources, struct accel_record *accel, bool is_unknown)
{
    resources->unknown_references += is_unknown;
    resources->unknown_references -= accel->address_is_unknown;
    accel->address_is_unknown = is_unknown;
}

/* A top-level structure may not be referred to, and a structure whose buffer lacks
 * VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT has no address that an application could use. */
static bool may_be_referenced(const struct accel_record *accel)
{
    return accel->facts.type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR &&
           (!accel->buffer ||
            accel->buffer->where.usage & VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT);
}

/* An address has no structure any more. */
static void retire_reference(struct resources *resources, VkDeviceAddress address,
                             uint64_t destroyed_at)
{
    struct past_references *past = &resources->past_addresses;
    const struct past_reference oldest = past_references_add(past, address, destroyed_at);
    const struct accel_address *at =
        oldest.value ? handle_table_find(&resources->accel_addresses, oldest.value) : NULL;
    if (!at || at->first || at->destroyed_at != oldest.destroyed_at)
        return;
    past->forgotten_at = oldest.destroyed_at;
    free(handle_table_remove(&resources->accel_addresses, oldest.value));
}

void accel_record_forget_address(struct resources *resources, struct accel_record *accel)
{
    if (accel->address_is_unknown)
        resources->unknown_destroyed_at = resources_destroy_count(resources);
    struct accel_address *at =
        accel->address ? handle_table_find(&resources->accel_addresses, accel->address) : NULL;
    const VkDeviceAddress address = accel->address;
    resources_note_reference(resources, address, false);
    set_unknown(resources, accel, false);
    accel->address = 0;
    if (!at)
        return;
    struct accel_record **link = &at->first;
    while (*link && *link != accel)
        link = &(*link)->same_address;
    if (*link)
        *link = accel->same_address;
    at->destroyed_at = resources_destroy_count(resources);
    if (!at->first)
        retire_reference(resources, address, at->destroyed_at);
}

/* The caller holds the lock. If there is no memory, the address counts as unknown. */
static void add_address(struct resources *resources, struct accel_record *accel,
                        VkDeviceAddress address)
{
    struct accel_address *at = address ? find_or_add_address(resources, address) : NULL;
    set_unknown(resources, accel, !at && (address || may_be_referenced(accel)));
    if (!at)
        return;
    accel->address = address;
    accel->same_address = at->first;
    at->first = accel;
    resources_note_reference(resources, address, false);
}

/* Returns the first live structure at an address that instances refer to, or NULL. */
static struct accel_record *accel_records_at(const struct resources *resources,
                                             VkDeviceAddress address)
{
    const struct accel_address *at = handle_table_find(&resources->accel_addresses, address);
    return at ? at->first : NULL;
}

void resources_set_accel_address(struct resources *resources, VkAccelerationStructureKHR handle,
                                 VkDeviceAddress address)
{
    reader_lock_write(&resources->lock);
    struct accel_record *accel = handle_table_find(&resources->accels, handle_number(handle));
    /* That an address becomes known takes nothing from what is known of submissions before. */
    if (accel && accel->address && accel->address != address)
        accel_record_forget_address(resources, accel);
    if (accel && !accel->address)
        add_address(resources, accel, address);
    reader_lock_write_done(&resources->lock);
}

struct address_search {
    struct resources *resources;
    VkDeviceAddress (*query)(void *user, VkAccelerationStructureKHR structure);
    void *user;
};

/* The valid usage of vkGetAccelerationStructureDeviceAddressKHR: the buffer has the usage, and is
 * bound. A sparse buffer need not be, but structures in it are not queried. */
static void query_address(void *record, void *context)
{
    const struct address_search *search = context;
    struct accel_record *accel = record;
    if (accel->address_is_unknown && accel->buffer && may_be_referenced(accel) &&
        accel->facts.backed == YES)
        add_address(search->resources, accel, search->query(search->user, accel->facts.handle));
}

void resources_query_addresses(struct resources *resources, VkAccelerationStructureKHR handle,
                               VkDeviceAddress (*query)(void *user,
                                                        VkAccelerationStructureKHR structure),
                               void *user)
{
    struct address_search search = {resources, query, user};
    reader_lock_write(&resources->lock);
    struct accel_record *accel = handle_table_find(&resources->accels, handle_number(handle));
    if (accel)
        query_address(accel, &search);
    else if (!handle && resources->unknown_references)
        handle_table_each(&resources->accels, query_address, &search);
    reader_lock_write_done(&resources->lock);
}

/* Returns whether an address refers to a live structure if it isn't known to which one. */
static enum tristate is_alive(const struct resources *resources, const struct accel_address *at,
                              uint64_t destroy_count)
{
    if (unknown_is_set(&resources->unknown) || resources->unknown_references ||
        resources->unknown_destroyed_at > destroy_count)
        return UNKNOWN;
    if (!at)
        return resources->past_addresses.forgotten_at > destroy_count ? UNKNOWN : NO;
    return at->first || at->destroyed_at > destroy_count ? UNKNOWN : NO;
}

bool resources_reference_is_destroyed(struct resources *resources, VkDeviceAddress address,
                                      uint64_t destroy_count)
{
    unsigned token = resources_begin_reading(resources);
    const struct accel_address *at = handle_table_find(&resources->accel_addresses, address);
    const bool is_destroyed = at && !at->first && !unknown_is_set(&resources->unknown) &&
                              !resources->unknown_references &&
                              resources->unknown_destroyed_at <= destroy_count;
    resources_end_reading(resources, token);
    return is_destroyed;
}

/* A structure that was destroyed since may have had the address, too. */
static bool is_one(const struct resources *resources, const struct accel_address *at,
                   uint64_t destroy_count)
{
    return at && at->first && !at->first->same_address && at->destroyed_at <= destroy_count &&
           resources->unknown_destroyed_at <= destroy_count;
}

void resources_find_referenced(struct resources *resources, VkDeviceAddress address,
                               uint64_t destroy_count, struct accel_facts *facts)
{
    unsigned token = resources_begin_reading(resources);
    const struct accel_address *at = handle_table_find(&resources->accel_addresses, address);
    if (is_one(resources, at, destroy_count))
        resources_find_accel(resources, at->first->facts.handle, facts);
    else
        *facts = (struct accel_facts){.alive = is_alive(resources, at, destroy_count)};
    if (facts->backed == NO && resources_destroy_count(resources) > destroy_count)
        facts->backed = UNKNOWN;
    resources_end_reading(resources, token);
}

void resources_release_references(struct resources *resources)
{
    handle_table_drop(&resources->accel_addresses, free);
    free(resources->past_addresses.items);
}

/* ---- changes of the values that instances refer to structures by */

void resources_watch_references(struct resources *resources)
{
    resources->watched.is_on = true;
}

/* Without memory a change is lost, so all values count as valid from then on. */
void resources_note_reference(struct resources *resources, uint64_t reference, bool is_nv)
{
    struct watched_references *watched = &resources->watched;
    if (!watched->is_on || !reference)
        return;
    if (ARRAY_HAS_ROOM(watched->changes, watched->count, watched->capacity))
        watched->changes[watched->count++] =
            (struct reference_change){.reference = reference, .is_nv = is_nv};
    else
        unknown_set(&watched->unknown, UNKNOWN_GUARDED_REFERENCES);
}

static bool is_live(const struct accel_facts *facts)
{
    return facts->backed != NO && (!facts->details_known ||
                                   facts->type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR ||
                                   facts->type == VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
}

static void describe_change(const struct resources *resources, struct reference_change *change)
{
    uint32_t count = 0;
    if (change->is_nv) {
        const struct nv_reference_record *record =
            handle_table_find(&resources->nv_references, change->reference);
        change->is_live = record && record->alive > record->without_memory &&
                          record->level != NV_REFERENCE_TOP_LEVEL;
        return;
    }
    const struct accel_record *accel = accel_records_at(resources, change->reference);
    for (; accel; accel = accel->same_address) {
        change->is_live |= is_live(&accel->facts);
        change->id = count++ || accel->facts.is_external || accel->facts.is_sparse
                         ? 0 /* other devices, or other buffers, may have built it */
                         : accel->facts.id;
    }
}

uint32_t resources_take_reference_changes(struct resources *resources,
                                          struct reference_change **changes,
                                          struct unknown_references *unknown)
{
    struct watched_references *watched = &resources->watched;
    reader_lock_write(&resources->lock);
    uint32_t count = watched->count;
    *changes = watched->changes;
    for (uint32_t i = 0; i < count; i++)
        describe_change(resources, &watched->changes[i]);
    watched->changes = NULL;
    watched->count = watched->capacity = 0;
    bool is_unknown = unknown_is_set(&resources->unknown) || unknown_is_set(&watched->unknown);
    *unknown =
        (struct unknown_references){.khr = is_unknown || resources->unknown_references,
                                    .nv = is_unknown || unknown_is_set(&resources->nv_unknown)};
    reader_lock_write_done(&resources->lock);
    return count;
}
