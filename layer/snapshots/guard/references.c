/* SPDX-License-Identifier: Apache-2.0 */
/* The table of live references.
 *
 * Open addressing with linear probing. The device may read the table at any time, so an entry never
 * moves, and a search never passes an empty entry that was taken when its submission began: entries
 * are emptied from the end of a chain only. If the table is half full, a larger one takes its
 * place; the smaller ones stay until the device is destroyed, because earlier submissions may read
 * them. */
#include "layer/snapshots/guard/references.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/snapshots.h"
#include "src/base/text_buffer.h"
#include "src/base/unknown.h"
#include "src/report/words.h"
#include "src/snapshots/recorded_build.h"
#include "src/state/resources/reference_changes.h"

/* ---- as guard.comp has it */

enum { KIND_KHR = 1, KIND_NV = 2, TABLES = 28, FIRST_ENTRIES = 1024 };

struct references_entry {
    _Atomic uint32_t low, high; /* of the reference; both 0: empty */
    _Atomic uint32_t built;     /* the build's count */
    _Atomic uint32_t kinds;     /* 0: no structure has this reference now */
};

struct references_header {
    _Atomic uint32_t current;     /* index in `tables` */
    _Atomic uint32_t known_kinds; /* other references are kept as they are */
    uint32_t unused[2];
    struct {
        uint64_t entries;
        uint32_t mask, unused;
    } tables[TABLES];
};
_Static_assert(GUARD_UNLIMITED == STRUCTURE_NEVER_BUILT, "as if it were built last");
_Static_assert(sizeof(struct references_entry) == 16 &&
                   offsetof(struct references_header, tables) == 16,
               "as the shader has it");

static uint32_t hash_of(uint64_t reference)
{
    uint32_t hash = (uint32_t)reference * 0x9e3779b1u ^ (uint32_t)(reference >> 32) * 0x85ebca77u;
    hash = (hash ^ hash >> 15) * 0x2c1b3c6du;
    return hash ^ hash >> 16;
}

/* ---- the host's side */

/* A value that is, or was, a reference. */
struct reference {
    uint64_t value, id; /* id 0: no structure, or one that counts as built */
    uint32_t kinds;
};

struct guard {
    struct layer_device *device;
    struct staging *copies;
    atomic_bool is_warned;
    struct execution_clock guarded; /* see guard_clock() */
    uint32_t next_count;            /* only the hooks of the execution order use it */
    pthread_mutex_t lock;           /* guards the members below; held while a table is created */
    struct reference **slots;       /* as the entries of the current table are; owned */
    uint32_t slot_count, used_count;
    struct unknown_references unknown;
    struct unknown table_unknown;
    struct own_buffer header, entries[TABLES]; /* `header` is created on first use */
    uint32_t current;
};

VkResult guard_create(struct layer_device *device, uint64_t budget, struct guard **guard)
{
    const struct device_facts *facts = &device->facts;
    if (reporter_settings(device->instance->reporter)->guard == GUARD_OFF ||
        device->snapshots->are_for_backend)
        return VK_SUCCESS;
    *guard = calloc(1, sizeof(**guard));
    if (!*guard)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*guard)->device = device;
    (*guard)->next_count = 1;
    pthread_mutex_init(&(*guard)->lock, NULL);
    resources_watch_references(device->resources);
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
        (facts->extension.acceleration_structure
             ? VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR
             : 0) |
        (facts->extension.ray_tracing_nv
             ? VK_BUFFER_USAGE_RAY_TRACING_BIT_NV | VK_BUFFER_USAGE_TRANSFER_DST_BIT
             : 0);
    return staging_create(device, budget, usage, false, &(*guard)->copies);
}

void guard_destroy(struct guard *guard)
{
    if (!guard)
        return;
    const struct own_device own = snapshots_own_device(guard->device->snapshots);
    staging_destroy(guard->copies);
    own_buffer_free(&own, &guard->header);
    for (uint32_t i = 0; i < TABLES; i++)
        own_buffer_free(&own, &guard->entries[i]);
    for (uint32_t i = 0; i < guard->slot_count; i++)
        free(guard->slots[i]);
    free((void *)guard->slots);
    pthread_mutex_destroy(&guard->lock);
    free(guard);
}

struct execution_clock *guard_clock(struct guard *guard)
{
    return &guard->guarded;
}

struct staging *guard_memory(const struct guard *guard)
{
    return guard->copies;
}

/* ---- entries. Everything below is called with the lock held. */

static struct references_entry *entries_of(const struct guard *guard)
{
    return (void *)guard->entries[guard->current].bytes;
}

/* Does nothing while the device has no table. */
static void write_entry(const struct guard *guard, uint32_t slot)
{
    const struct reference *reference = guard->slots[slot];
    if (!guard->header.bytes || unknown_is_set(&guard->table_unknown))
        return;
    struct references_entry *entry = &entries_of(guard)[slot];
    atomic_store(&entry->built,
                 reference && reference->id
                     ? structures_first_build(guard->device->structures, reference->id)
                     : 0);
    atomic_store(&entry->low, reference ? (uint32_t)reference->value : 0);
    atomic_store(&entry->high, reference ? (uint32_t)(reference->value >> 32) : 0);
    atomic_store(&entry->kinds, reference ? reference->kinds : 0);
}

static void write_known_kinds(const struct guard *guard)
{
    struct references_header *header = (void *)guard->header.bytes;
    if (header)
        atomic_store(&header->known_kinds,
                     unknown_is_set(&guard->table_unknown)
                         ? 0
                         : (guard->unknown.khr ? 0 : KIND_KHR) | (guard->unknown.nv ? 0 : KIND_NV));
}

/* The slot of a value, or the empty one where it belongs. */
static uint32_t find_slot(struct reference *const *slots, uint32_t count, uint64_t value)
{
    uint32_t slot = hash_of(value) & (count - 1);
    while (slots[slot] && slots[slot]->value != value)
        slot = (slot + 1) & (count - 1);
    return slot;
}

/* Creates a buffer for the entries of the current slots. */
static bool create_entries(struct guard *guard, uint32_t table)
{
    const struct own_device own = snapshots_own_device(guard->device->snapshots);
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    struct own_buffer *buffer = &guard->entries[table];
    struct references_header *header = (void *)guard->header.bytes;
    if (own_buffer_create(&own, usage,
                          (uint64_t)guard->slot_count * sizeof(struct references_entry), true,
                          buffer) != VK_SUCCESS)
        return false;
    guard->current = table;
    for (uint32_t i = 0; i < guard->slot_count; i++)
        write_entry(guard, i);
    header->tables[table].entries = buffer->address;
    header->tables[table].mask = guard->slot_count - 1;
    atomic_store(&header->current, table);
    return true;
}

/* Makes room for one more value. */
static bool make_room_for_entries(struct guard *guard)
{
    if (guard->used_count < guard->slot_count / 2)
        return true;
    uint32_t count = guard->slot_count ? 2 * guard->slot_count : FIRST_ENTRIES;
    struct reference **slots =
        count > guard->slot_count ? calloc(count, sizeof(struct reference *)) : NULL;
    if (!slots)
        return false;
    guard->used_count = 0;
    for (uint32_t i = 0; i < guard->slot_count; i++) {
        struct reference *reference = guard->slots[i];
        if (reference && reference->kinds) {
            slots[find_slot(slots, count, reference->value)] = reference;
            guard->used_count++;
        } else {
            free(reference);
        }
    }
    free((void *)guard->slots);
    guard->slots = slots;
    guard->slot_count = count;
    return !guard->header.bytes ||
           (guard->current + 1 < TABLES && create_entries(guard, guard->current + 1));
}

static struct reference *find_or_add_reference(struct guard *guard, uint64_t value, uint32_t *slot)
{
    if (!make_room_for_entries(guard))
        return NULL;
    *slot = find_slot(guard->slots, guard->slot_count, value);
    if (guard->slots[*slot])
        return guard->slots[*slot];
    struct reference *reference = malloc(sizeof(*reference));
    if (!reference)
        return NULL;
    *reference = (struct reference){.value = value};
    guard->slots[*slot] = reference;
    guard->used_count++;
    return reference;
}

/* Empties the entry, and those before it without a structure, if it ends its chain. */
static void remove_destroyed(struct guard *guard, uint32_t slot)
{
    uint32_t mask = guard->slot_count - 1;
    while (guard->slots[slot] && !guard->slots[slot]->kinds && !guard->slots[(slot + 1) & mask]) {
        free(guard->slots[slot]);
        guard->slots[slot] = NULL;
        guard->used_count--;
        write_entry(guard, slot);
        slot = (slot - 1) & mask;
    }
}

/* ---- changes */

static void apply(struct guard *guard, const struct reference_change *change)
{
    uint32_t slot, kind = change->is_nv ? KIND_NV : KIND_KHR;
    struct reference *reference = find_or_add_reference(guard, change->reference, &slot);
    if (!reference) {
        unknown_set(&guard->table_unknown, UNKNOWN_GUARDED_REFERENCES);
        return;
    }
    if (!change->is_nv)
        reference->id = change->is_live ? change->id : 0;
    reference->kinds = change->is_live ? reference->kinds | kind : reference->kinds & ~kind;
    write_entry(guard, slot);
    remove_destroyed(guard, slot);
}

void guard_update(struct guard *guard)
{
    struct reference_change *changes;
    struct unknown_references unknown;
    pthread_mutex_lock(&guard->lock);
    uint32_t count = resources_take_reference_changes(guard->device->resources, &changes, &unknown);
    for (uint32_t i = 0; i < count && !unknown_is_set(&guard->table_unknown); i++)
        apply(guard, &changes[i]);
    guard->unknown = unknown;
    write_known_kinds(guard);
    pthread_mutex_unlock(&guard->lock);
    free(changes);
}

static bool create_table(struct guard *guard)
{
    const struct own_device own = snapshots_own_device(guard->device->snapshots);
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    if (!make_room_for_entries(guard))
        return false;
    if (own_buffer_create(&own, usage, sizeof(struct references_header), true, &guard->header) ==
            VK_SUCCESS &&
        create_entries(guard, 0)) {
        write_known_kinds(guard);
        return true;
    }
    own_buffer_free(&own, &guard->entries[0]);
    own_buffer_free(&own, &guard->header);
    return false;
}

VkDeviceAddress guard_table(struct guard *guard)
{
    pthread_mutex_lock(&guard->lock);
    bool is_there = guard->header.bytes || create_table(guard);
    VkDeviceAddress address = is_there ? guard->header.address : 0;
    pthread_mutex_unlock(&guard->lock);
    return address;
}

/* ---- builds */

uint32_t guard_next_count(const struct guard *guard)
{
    return guard->next_count;
}

/* Writes the entry of a live structure again. If its reference is not known yet, its entry has the
 * count from the start. */
static void renew_entry(struct guard *guard, uint64_t handle, uint64_t id)
{
    struct resource_span span = {0};
    resources_find_span(guard->device->resources, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle,
                        true, &span);
    pthread_mutex_lock(&guard->lock);
    if (span.address && guard->slot_count) {
        uint32_t slot = find_slot(guard->slots, guard->slot_count, span.address);
        if (guard->slots[slot] && guard->slots[slot]->id == id)
            write_entry(guard, slot);
    }
    pthread_mutex_unlock(&guard->lock);
}

void guard_note_built(struct guard *guard, uint64_t handle, uint64_t id, uint32_t count)
{
    if (guard->next_count < GUARD_UNLIMITED)
        guard->next_count++;
    if (id && structures_note_first_build(guard->device->structures, id, count))
        renew_entry(guard, handle, id);
}

void guard_warn_unguarded(struct guard *guard, const char *reason)
{
    if (!guard || atomic_exchange(&guard->is_warned, true))
        return;
    reporter_say_warning(
        guard->device->instance->reporter,
        "assay_validation.guard = references: some builds read the application's instances "
        "unguarded, because {}.",
        phrase(reason));
}
